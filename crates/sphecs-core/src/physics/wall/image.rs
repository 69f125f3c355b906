//! Image particles: velocity of a wall particle in the sums of a fluid particle.
//!
//! ```text
//! v_a − v_b = (1 + d_b/d_a) (v_a − v_wall)
//! ```
//!
//! Morris et al. (1997), as in Alvarado-Rodríguez et al. (2017), section 3.1: the velocity is
//! continued linearly through the surface, d_a in front of it and d_b behind. All particles but
//! those of a wall have d_b = 0, so that one formula serves all pairs. Morris et al. cap the factor
//! at 1.5, which costs 3 to 4 % of the peak of a Poiseuille flow; the cap is an option here.
//!
//! A free-slip wall exerts no viscous force; its image has the tangential velocity of the fluid and
//! the mirrored normal velocity.

use super::{WallMethod, WallPressure};
use crate::math::lanes::{Lanes, dot};

/// Smallest distance of a fluid particle from a wall in the factor of the image, over Δ. On the
/// surface itself the factor would be infinite.
const LEAST_DISTANCE: f64 = 0.1;

/// The model with its parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Image {
    /// Largest factor 1 + d_w/d_a of the image velocity; None: no cap.
    pub velocity_cap: Option<f64>,
    /// Source of the pressure of a wall particle.
    pub pressure: WallPressure,
}

impl WallMethod for Image {
    fn pressure(&self) -> WallPressure {
        self.pressure
    }

    fn largest_factor(&self) -> f64 {
        self.velocity_cap.unwrap_or(f64::INFINITY)
    }

    #[inline(always)]
    fn inverse_distance(&self, distance: f64, spacing: f64) -> f64 {
        inverse_distance(distance, spacing)
    }

    #[inline(always)]
    fn image_distance(&self, distance: f64) -> f64 {
        distance
    }

    fn can_be_one_sided(&self) -> bool {
        true
    }

    fn fault(&self) -> Option<&'static str> {
        let points_backwards = self.velocity_cap.is_some_and(|cap| cap.is_nan() || cap < 1.0);
        points_backwards.then_some(
            "`velocity_cap` of the walls is less than 1, must be at least 1: the image velocity would point the \
             wrong way",
        )
    }
}

/// Returns 1/d_a, 1/m, with d_a kept off zero; 0 for a particle without a wall in its support.
#[inline(always)]
pub fn inverse_distance(distance: f64, spacing: f64) -> f64 {
    1.0 / distance.max(LEAST_DISTANCE * spacing)
}

/// Returns the factor 1 + d_b/d_a, at most the cap.
#[inline(always)]
pub fn velocity_factor<L: Lanes>(image_distance: L, inverse_distance: L, cap: L) -> L {
    image_distance.mul_add(inverse_distance, L::constant(1.0)).min(cap)
}

/// Returns x_ab · (v_a − v_b) with the image velocity of a free-slip wall of normal n:
/// (1 + d_b/d_a) (x_ab·n) (v_ab·n).
#[inline(always)]
pub fn free_slip_product<L: Lanes, const D: usize>(factor: L, normal: [L; D], x: [L; D], v: [L; D]) -> L {
    factor * dot(normal, x) * dot(normal, v)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    #[test]
    fn a_cap_below_one_is_a_fault() {
        let image = |cap| Image { velocity_cap: cap, pressure: WallPressure::Extrapolated };
        for cap in [0.9, -2.0, f64::NAN] {
            let fault = image(Some(cap)).fault().unwrap_or_else(|| panic!("a cap of {cap} is no fault"));
            assert!(fault.starts_with("`velocity_cap` of the walls is less than 1"), "{fault}");
        }
        assert_eq!(image(Some(1.0)).fault(), None);
        assert_eq!(image(None).fault(), None);
    }

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
