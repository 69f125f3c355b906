//! Ghost particles: what each fluid particle sees in a wall is made of its own state.
//!
//! ```text
//! v_w = 2 v_wall − v_a              →   v_a − v_w = 2 (v_a − v_wall)
//! v_w = v_a − 2 ((v_a − v_wall)·n) n  for a free-slip wall
//! p_w = p_a + ρ_a g·(x_w − x_a)
//!
//! ∇p:   Σ V_b (p_b + p_a) ∇W + Σ V_w (p_w + p_a) ∇W        ∇·v:   Σ V_b (v_b − v_a)·∇W + Σ V_w (v_w − v_a)·∇W
//! ```
//!
//! Simcenter STAR-CCM+ User Guide, page “SPH Boundary Conditions”, Eqs. 1123–1125 (the page bears no year); its f_b is a force per
//! volume, ρ_a g here. That is the image of [`image`](super::image) with d_w = d_a for all pairs, so that the one formula of
//! the pair loops serves: the ghost “stands” 1 m behind the surface and the particle 1 m in front of it. The
//! divergence has the ghost's velocity under both schemes.
//!
//! The drag of a particle does not know how near the wall it is: the row next to the wall is dragged too little by the deep
//! ghosts, those further off too much (0.8 to 1.3 % of the peaks of plane flows with 20 to 25 rows: docs/walls.md).

/// (v_a − v_w) over (v_a − v_wall).
pub const FACTOR: f64 = 2.0;

/// Distance behind the surface that the factor 1 + d_w/d_a is given for all ghosts, m.
pub const DISTANCE: f64 = 1.0;

/// 1/d_a that goes with it, 1/m.
pub const INVERSE_DISTANCE: f64 = 1.0;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;
    use crate::physics::wall::image::{free_slip_product, velocity_factor};

    #[test]
    fn the_factor_of_the_image_is_that_of_the_ghost() {
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
