//! Dummy particles: velocity of a wall particle in the sums of the fluid.
//!
//! ```text
//! no slip      v_w = 2 v_wall − ṽ,                          ṽ_w = Σ_b v_b W_wb / Σ_b W_wb
//! free slip    v_w = ṽ − 2 ((ṽ − v_wall)·n) n,   no viscous force
//! ```
//!
//! These are Eqs. 22 and 23 of Adami et al. (2012), with sums over fluid, inflow and outflow. The
//! kernel mean at a wall particle is the velocity of the fluid some way in front of the surface,
//! not at the mirror image of the particle. So the profile is not continued linearly, and the
//! effective surface is slightly displaced. The peak of a Poiseuille flow with 25 particles across
//! is off by 0.45 %, with the image by 0.26 % (docs/book/src/theory/walls.md). In return no factor
//! becomes large for a particle that touches the wall.
//!
//! Only the viscous term uses v_w. In the equation of an evolved pressure the divergence uses the
//! velocity of the wall itself, as in their section 2.3.

use super::{WallMethod, WallPressure};

/// The model; it has no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dummy;

impl WallMethod for Dummy {
    fn pressure(&self) -> WallPressure {
        WallPressure::Extrapolated
    }

    fn largest_factor(&self) -> f64 {
        1.0
    }

    #[inline(always)]
    fn inverse_distance(&self, _distance: f64, _spacing: f64) -> f64 {
        // Wall particles already have the velocity of the formula.
        0.0
    }

    #[inline(always)]
    fn image_distance(&self, distance: f64) -> f64 {
        distance
    }

    fn sees_kernel_mean(&self) -> bool {
        true
    }
}

/// Returns the velocity that the fluid sees in a no-slip wall particle, m/s, from those of the wall
/// and of the kernel mean.
#[inline(always)]
pub fn no_slip<const D: usize>(wall: [f64; D], mean: [f64; D]) -> [f64; D] {
    std::array::from_fn(|d| 2.0 * wall[d] - mean[d])
}

/// Returns the velocity that the fluid sees in a free-slip wall particle of unit normal n, m/s: the
/// mean with its normal part mirrored.
#[inline(always)]
pub fn free_slip<const D: usize>(wall: [f64; D], mean: [f64; D], normal: [f64; D]) -> [f64; D] {
    let into: f64 = (0..D).map(|d| (mean[d] - wall[d]) * normal[d]).sum();
    std::array::from_fn(|d| mean[d] - 2.0 * into * normal[d])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_both_sides_is_the_velocity_of_the_wall() {
        let (wall, mean) = ([0.5, -1.0], [2.0, 3.0]);
        let seen = no_slip(wall, mean);
        for d in 0..2 {
            assert_eq!(0.5 * (seen[d] + mean[d]), wall[d]);
        }
    }

    #[test]
    fn a_free_slip_wall_keeps_the_tangential_velocity_and_mirrors_the_normal_one() {
        let (wall, mean, normal) = ([9.0, 1.0, 4.0], [2.0, 3.0, -1.0], [0.0, 1.0, 0.0]);
        assert_eq!(free_slip(wall, mean, normal), [2.0, -1.0, -1.0]);
        let slanted = free_slip([0.0; 2], [1.0, 0.0], [0.6, 0.8]);
        assert!((slanted[0] - (1.0 - 2.0 * 0.36)).abs() < 1e-15 && (slanted[1] + 2.0 * 0.48).abs() < 1e-15);
    }
}
