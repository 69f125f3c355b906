//! Sides of thin walls: whether a pair of particles has a thin wall between it.
//!
//! ```text
//! e_a = ± n_w of the nearest wall particle, towards particle a;  f_a = e_a (d_a + t) for flow,
//! f_w = n_w (t − d_w) for a particle of the wall itself
//! behind(a, b):  (x_a − x_b)·e_a > d_a   and   d_b' = −f_b·e_a > 0
//! ```
//!
//! t is the thickness of the wall, d the distance to its surface. A wall thinner than the support
//! has too few particles to fill the support of the fluid on one side, which reaches the fluid on
//! the other. Here that fluid stands for the missing wall particles: in the sums of particle a, a
//! neighbour b behind the wall is a wall particle at the depth d_b' behind the surface that faces
//! a, with the velocity of the wall and the pressure of a mirrored. So no momentum crosses the
//! wall, the support stays full, and there are no further particles. Particles of the wall itself
//! that are nearer to its other side are seen in the same way.
//!
//! A particle has a side where the foot of its perpendicular is on a face of the wall, so it has
//! none beyond an edge. The method is our own.
//!
//! | file | subject |
//! |---|---|
//! | `disc.rs` | place of a point at the disc of a wall particle |
//! | `search.rs` | sides of the particles |
//! | `point_side.rs` | side of a point that is sampled |
//! | `behind.rs` | neighbours behind a wall, in the pair loops |

mod behind;
mod disc;
mod point_side;
mod search;
#[cfg(test)]
mod tests;

pub(super) use behind::{Behind, OwnSide};
pub(super) use disc::{AtDisc, radius};
pub(super) use point_side::PointSide;
pub(super) use search::find_wall_sides;

use super::column_access::FusedInputsReader;
use super::pack::{ColumnList, Vector};
use super::sums::PairSums;
use crate::math::real::Real;

/// Writer of the sides.
#[derive(Debug)]
pub struct WallSides(());

/// Sides of the particles near thin walls.
#[derive(Debug)]
pub struct SideColumns<R, const D: usize> {
    /// f of the module head, m; 0 for particles without a side.
    pub facing: [Vec<R>; D],
    /// Velocity of the surface that a particle faces, m/s.
    pub surface_velocity: [Vec<R>; D],
    /// Part of the wall that a particle of the flow faces; meaningless without a side.
    pub part: Vec<R>,
    /// Part of each wall particle, for the search.
    wall_part: Vec<R>,
}

impl<R, const D: usize> Default for SideColumns<R, D> {
    fn default() -> Self {
        Self {
            facing: std::array::from_fn(|_| Vec::new()),
            surface_velocity: std::array::from_fn(|_| Vec::new()),
            part: Vec::new(),
            wall_part: Vec::new(),
        }
    }
}

/// Adds the column of the facing, where a wall is thin.
pub(super) fn facing_column<'a, R: Real, const D: usize, const MOST: usize>(
    list: &mut ColumnList<'a, R, D, MOST>,
    sums: &'a PairSums<R, D>,
) -> Option<Vector> {
    let facing = &sums.sides.read(FusedInputsReader).facing;
    (!facing[0].is_empty()).then(|| list.add_vector(facing))
}
