//! Image particles: the velocity that a fluid particle sees in a wall.
//!
//! ```text
//! v_a − v_b = (1 + d_b/d_a) (v_a − v_wall)
//! ```
//!
//! Morris et al. (1997), as in Alvarado-Rodríguez et al. (2017), section 3.1: the velocity is continued linearly
//! through the surface, d_a in front of it and d_b behind. Everything but a wall has d_b = 0, so that one formula
//! serves all pairs. Morris et al. cap the factor at 1.5, which costs 3 to 4 % of the peak of a Poiseuille flow: an
//! option here.
//!
//! A free-slip wall exerts no viscous force; its image has the fluid's own tangential velocity and the mirrored
//! normal one.

use crate::math::lanes::{Lanes, dot};

/// Least distance of a fluid particle from a wall in the image's factor, over Δ: on the surface itself the factor
/// would be infinite.
const LEAST_DISTANCE: f64 = 0.1;

/// 1/d_a, 1/m, with d_a kept off zero; 0 for a particle without a wall in its support.
#[inline(always)]
pub fn inverse_distance(distance: f64, spacing: f64) -> f64 {
    1.0 / distance.max(LEAST_DISTANCE * spacing)
}

/// The factor 1 + d_b/d_a, not above the cap.
#[inline(always)]
pub fn velocity_factor<L: Lanes>(image_distance: L, inverse_distance: L, cap: L) -> L {
    image_distance.mul_add(inverse_distance, L::constant(1.0)).min(cap)
}

/// x_ab · (v_a − v_b) with the image velocity of a free-slip wall of normal n: (1 + d_b/d_a) (x_ab·n) (v_ab·n).
#[inline(always)]
pub fn free_slip_product<L: Lanes, const D: usize>(factor: L, normal: [L; D], x: [L; D], v: [L; D]) -> L {
    factor * dot(normal, x) * dot(normal, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    #[test]
    fn image_continues_a_linear_profile() {
        let factor = |behind: f64, before: f64, cap: f64| {
            velocity_factor(Array([behind]), Array([inverse_distance(before, 0.01)]), Array([cap])).0[0]
        };
        assert!((factor(0.015, 0.005, f64::INFINITY) - 4.0).abs() < 1e-12);
        assert_eq!(factor(0.015, 0.005, 1.5), 1.5);
        assert_eq!(factor(0.0, 0.005, 1.5), 1.0, "not a wall");
        assert_eq!(factor(0.015, f64::INFINITY, 1.5), 1.0, "no wall near");
        assert!(factor(0.015, 0.0, f64::INFINITY).is_finite());
    }
}
