//! Discs that wall particles represent on the surface of a wall.
//!
//! ```text
//! s_b = x_b + d_b n_b,   t = x_a − s_b,   R = 0.75 Δ
//! t_n = t·n_b,   t_s = max(0, √(|t|² − t_n²) − R)
//! ```
//!
//! Every wall particle stores its foot point s_b on the surface and represents a disc of radius R
//! around it. R is more than half the diagonal of a lattice cell, so the discs of a flat wall leave
//! no gap and the distance to it, √(t_n² + t_s²), is exact. At a convex corner a disc reaches
//! beyond the wall by at most R − Δ/2, and shortens a distance by no more than that. Next to the
//! wall particle at the corner, which belongs to one face only, the distance to the other face is
//! 12 % too long.

use crate::math::lanes::{Lanes, dot};

/// Radius R of a disc, over Δ.
const RADIUS: f64 = 0.75;

/// Returns R, in the unit of the spacing.
pub(in crate::pass) fn radius(spacing: f64) -> f64 {
    RADIUS * spacing
}

/// Place of a point at the disc of a wall particle.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct AtDisc<T> {
    /// Distance in front of the surface t_n, negative behind it.
    pub front: T,
    /// Distance beyond the edge of the disc t_s; 0 above it.
    pub beyond: T,
}

impl<L: Lanes> AtDisc<L> {
    /// Returns the place in every lane: x is x_a − x_b, `depth` is d_b, all in one unit.
    #[inline(always)]
    pub(in crate::pass) fn of_lanes<const D: usize>(x: [L; D], depth: L, normal: [L; D], radius: L) -> Self {
        let zero = L::constant(0.0);
        let mut foot = [zero; D];
        for d in 0..D {
            foot[d] = x[d] - depth * normal[d];
        }
        let front = dot(foot, normal);
        let aside = (dot(foot, foot) - front * front).max(zero).sqrt();
        Self { front, beyond: (aside - radius).max(zero) }
    }
}

impl AtDisc<f64> {
    /// Returns the place of one point, as [`AtDisc::of_lanes`].
    pub(in crate::pass) fn of_point<const D: usize>(
        x: [f64; D],
        depth: f64,
        normal: [f64; D],
        radius: f64,
    ) -> Self {
        let foot: [f64; D] = std::array::from_fn(|d| x[d] - depth * normal[d]);
        let product = |a: [f64; D], b: [f64; D]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let front = product(foot, normal);
        let aside = (product(foot, foot) - front * front).max(0.0).sqrt();
        Self { front, beyond: (aside - radius).max(0.0) }
    }
}
