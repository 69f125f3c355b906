//! Columns that the terms of `EdacTvf` take of the neighbours.

use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::pass::column_access::EdacRates;
use crate::pass::fused::LoopShape;
use crate::pass::pack::{ColumnList, Scalar, Vector};
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;
use crate::pass::wall_sides::facing_column;

/// Most columns beside the coordinates in 3D: velocity, drift, three scalars, normal and the
/// velocity of dummy walls.
const MOST_COLUMNS: usize = 3 + 3 + 3 + 3 + 3 + 3;

/// Columns of a pass in their order.
pub(super) type EdacColumnList<'a, R, const D: usize> = ColumnList<'a, R, D, MOST_COLUMNS>;

/// Places of the columns in a pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct EdacColumns {
    pub velocity: Vector,
    /// Transport velocity less the velocity, m/s.
    pub drift: Vector,
    pub density: Scalar,
    pub pressure: Scalar,
    /// Image distance, only where there are walls.
    pub image_distance: Option<Scalar>,
    /// Wall normals, only where a wall is free-slip.
    pub normal: Option<Vector>,
    /// Velocities as the viscous term takes them, only where walls are dummy particles.
    pub viscous_velocity: Option<Vector>,
    /// Facing of the neighbours, only where a wall is thin.
    pub facing: Option<Vector>,
    /// Number of columns, coordinates included.
    pub width: usize,
}

impl EdacColumns {
    /// Returns the places in a loop of a fixed shape: those of [`columns`] as far as the shape has
    /// them.
    #[inline(always)]
    pub(super) const fn of_shape<S: LoopShape, const D: usize>() -> Self {
        let of_flow = 3 * D + 2;
        Self {
            velocity: Vector(D),
            drift: Vector(2 * D),
            density: Scalar(3 * D),
            pressure: Scalar(3 * D + 1),
            image_distance: if S::WALLS { Some(Scalar(of_flow)) } else { None },
            normal: None,
            viscous_velocity: None,
            facing: None,
            width: if S::WALLS { of_flow + 1 } else { of_flow },
        }
    }
}

/// Returns the columns that the terms of a scene take, and their places in the pack.
///
/// The columns of the fixed shapes come first: their loops rely on the places.
pub(super) fn columns<'a, R: Real, const D: usize>(
    pair: &PairSettings,
    particles: &'a ParticleArrays<R, D>,
    sums: &'a PairSums<R, D>,
    has_walls: bool,
) -> (EdacColumns, EdacColumnList<'a, R, D>) {
    let mut list = EdacColumnList::empty();
    let has_dummies = has_walls && pair.wall_model.sees_kernel_mean();
    let places = EdacColumns {
        velocity: list.add_vector(&particles.velocity),
        drift: list.add_vector(&particles.drift),
        density: list.add_scalar(&particles.density),
        pressure: list.add_scalar(&particles.pressure),
        image_distance: has_walls.then(|| list.add_scalar(&sums.columns.image_distance)),
        normal: (has_walls && pair.has_free_slip()).then(|| list.add_vector(&particles.wall_normal)),
        viscous_velocity: has_dummies.then(|| list.add_vector(sums.velocity_seen.read(EdacRates))),
        facing: facing_column(&mut list, sums),
        width: 0,
    };
    (EdacColumns { width: list.width(), ..places }, list)
}
