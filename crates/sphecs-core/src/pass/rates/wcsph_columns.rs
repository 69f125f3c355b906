//! Columns that the terms of `Wcsph` take of the neighbours.

use crate::math::real::Real;
use crate::math::symmetric::components;
use crate::particles::arrays::ParticleArrays;
use crate::pass::column_access::WcsphRates;
use crate::pass::fused::LoopShape;
use crate::pass::pack::{ColumnList, Scalar, Symmetric, Vector};
use crate::pass::rates::TimeLevel;
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;
use crate::pass::wall_sides::facing_column;

/// Most columns beside the coordinates in 3D: velocity, three scalars, strain, ∇C and volume,
/// normal and stress.
const MOST_COLUMNS: usize = 3 + 3 + 6 + 4 + 3 + 6 + 3;

/// Columns of a pass in their order.
pub(super) type WcsphColumnList<'a, R, const D: usize> = ColumnList<'a, R, D, MOST_COLUMNS>;

/// Places of the columns in a pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct WcsphColumns {
    pub velocity: Vector,
    pub density: Scalar,
    pub pressure: Scalar,
    /// Rate of strain, only where noise is damped.
    pub strain: Option<Symmetric>,
    /// Image distance, only where there are walls.
    pub image_distance: Option<Scalar>,
    /// Concentration gradient and volume of the fluid, only where the drift of shifting is
    /// corrected.
    pub concentration: Option<Concentration>,
    /// Wall normals, only where a wall is free-slip.
    pub normal: Option<Vector>,
    /// T/ρ², only with sub-particle-scale stress.
    pub stress: Option<Symmetric>,
    /// Facing of the neighbours, only where a wall is thin.
    pub facing: Option<Vector>,
    /// Number of columns, coordinates included.
    pub width: usize,
}

/// Places of the columns by which the drift of shifting is corrected.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Concentration {
    /// ∇C, 1/m.
    pub gradient: Vector,
    /// Volume of a fluid particle, m³ (m² in 2D); 0 of other particles.
    pub volume: Scalar,
}

impl WcsphColumns {
    /// Returns the places in a loop of a fixed shape: those of [`columns`] as far as the shape has
    /// them.
    #[inline(always)]
    pub(super) const fn of_shape<S: LoopShape, const D: usize>() -> Self {
        let of_flow = 2 * D + 2 + if S::DAMPED { components(D) } else { 0 };
        let before = if S::WALLS { of_flow + 1 } else { of_flow };
        let concentration = Concentration { gradient: Vector(before), volume: Scalar(before + D) };
        Self {
            velocity: Vector(D),
            density: Scalar(2 * D),
            pressure: Scalar(2 * D + 1),
            strain: if S::DAMPED { Some(Symmetric(2 * D + 2)) } else { None },
            image_distance: if S::WALLS { Some(Scalar(of_flow)) } else { None },
            concentration: if S::CORRECTS_DRIFT { Some(concentration) } else { None },
            normal: None,
            stress: None,
            facing: None,
            width: if S::CORRECTS_DRIFT { before + D + 1 } else { before },
        }
    }
}

/// Returns the columns that the terms of a scene take, and their places in the pack.
///
/// The columns of the fixed shapes come first: their loops rely on the places.
pub(super) fn columns<'a, R: Real, const D: usize>(
    pair: &PairSettings,
    particles: &'a ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &'a PairSums<R, D>,
    has_walls: bool,
) -> (WcsphColumns, WcsphColumnList<'a, R, D>) {
    let mut list = WcsphColumnList::empty();
    let sees_dummies = has_walls && pair.wall_model.sees_kernel_mean();
    let velocity = if sees_dummies { sums.velocity_seen.read(WcsphRates) } else { level.columns(particles) };
    let places = WcsphColumns {
        velocity: list.add_vector(velocity),
        density: list.add_scalar(&particles.density),
        pressure: list.add_scalar(&particles.pressure),
        strain: (pair.noise_damping != 0.0).then(|| list.add_symmetric(sums.strain.read(WcsphRates))),
        image_distance: has_walls.then(|| list.add_scalar(&sums.columns.image_distance)),
        concentration: (!pair.shifting.keeps_drift()).then(|| Concentration {
            gradient: list.add_vector(sums.concentration_gradient.read(WcsphRates)),
            volume: list.add_scalar(&sums.columns.fluid_volume),
        }),
        normal: (has_walls && pair.has_free_slip()).then(|| list.add_vector(&particles.wall_normal)),
        stress: pair.viscous_term.needs().stress.then(|| list.add_symmetric(sums.stress.read(WcsphRates))),
        facing: facing_column(&mut list, sums),
        width: 0,
    };
    (WcsphColumns { width: list.width(), ..places }, list)
}
