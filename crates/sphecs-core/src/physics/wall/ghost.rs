//! Ghost particles: wall particles with a state made from that of each fluid particle.
//!
//! ```text
//! v_w = 2 v_wall − v_a              →   v_a − v_w = 2 (v_a − v_wall)
//! v_w = v_a − 2 ((v_a − v_wall)·n) n  for a free-slip wall
//! p_w = p_a + ρ_a g·(x_w − x_a)
//!
//! ∇p:   Σ V_b (p_b + p_a) ∇W + Σ V_w (p_w + p_a) ∇W
//! ∇·v:  Σ V_b (v_b − v_a)·∇W + Σ V_w (v_w − v_a)·∇W
//! ```
//!
//! Simcenter STAR-CCM+ User Guide, page “SPH Boundary Conditions”, Eqs. 1123–1125 (the page bears
//! no year). Its f_b is a force per volume, ρ_a g here. This is the image of
//! [`image`](super::image) with d_w = d_a for all pairs, so that one formula serves the pair loops.
//! The ghost is 1 m behind the surface and the particle 1 m in front of it. The divergence uses the
//! velocity of the ghost under both schemes.
//!
//! The drag of a particle does not depend on its distance from the wall. Deep ghosts drag the first
//! layer of particles too little and the layers behind it too much. The error is 0.8 to 1.3 % of
//! the peaks of plane flows with 20 to 25 particles across (docs/book/src/theory/walls.md).

use super::{WallMethod, WallPressure};

/// The model; it has no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ghost;

impl WallMethod for Ghost {
    fn pressure(&self) -> WallPressure {
        WallPressure::Mirrored
    }

    fn largest_factor(&self) -> f64 {
        FACTOR
    }

    #[inline(always)]
    fn inverse_distance(&self, _distance: f64, _spacing: f64) -> f64 {
        INVERSE_DISTANCE
    }

    #[inline(always)]
    fn image_distance(&self, _distance: f64) -> f64 {
        DISTANCE
    }

    fn mirrors_velocity(&self) -> bool {
        true
    }
}

/// Ratio of (v_a − v_w) to (v_a − v_wall).
pub const FACTOR: f64 = 2.0;

/// Distance d_w of all ghosts behind the surface in the factor 1 + d_w/d_a, m.
pub const DISTANCE: f64 = 1.0;

/// 1/d_a of all particles in the factor 1 + d_w/d_a, 1/m.
pub const INVERSE_DISTANCE: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;
    use crate::physics::wall::image::{free_slip_product, velocity_factor};

    #[test]
    fn the_formula_of_the_image_gives_the_factor_of_the_ghost() {
        let factor = |image: f64| {
            velocity_factor(Array([image]), Array([INVERSE_DISTANCE]), Array([f64::INFINITY])).0[0]
        };
        assert_eq!(factor(DISTANCE), FACTOR);
        assert_eq!(factor(0.0), 1.0, "not a wall");
    }

    #[test]
    fn a_free_slip_ghost_mirrors_the_normal_velocity() {
        let (v_a, wall, normal, x) = ([2.0, -3.0], [0.5, 0.5], [0.6, 0.8], [0.3, 0.7]);
        let into: f64 = (0..2).map(|d| (v_a[d] - wall[d]) * normal[d]).sum();
        let ghost: [f64; 2] = std::array::from_fn(|d| v_a[d] - 2.0 * into * normal[d]);
        let expected: f64 = (0..2).map(|d| x[d] * (v_a[d] - ghost[d])).sum();
        let lanes = |vector: [f64; 2]| vector.map(|component| Array([component]));
        let difference = std::array::from_fn(|d| Array([v_a[d] - wall[d]]));
        let found = free_slip_product(Array([FACTOR]), lanes(normal), lanes(x), difference).0[0];
        assert!((found - expected).abs() < 1e-14);
    }
}
