//! Results of the pair passes.

use bevy_ecs::resource::Resource;
use serde::{Deserialize, Serialize};

use sphecs_core::math::real::Real;
use sphecs_core::pass::rates::{TimeLevel, larger};
use sphecs_core::pass::sums::PairSums;

/// Sums of the pair passes, which are computed in every step.
#[derive(Resource, Default)]
pub struct Sums<R: Real, const D: usize>(pub PairSums<R, D>);

/// Extremes that the pair pass found; they limit the time step.
///
/// From the pair pass to the kick they are those of the particles of this rank.
#[derive(
    Resource,
    Clone,
    Copy,
    Debug,
    Default,
    PartialEq,
    Serialize,
    Deserialize,
    bytemuck::Pod,
    bytemuck::Zeroable,
)]
#[serde(deny_unknown_fields)]
#[repr(C)]
pub struct RatesFound {
    /// Largest c_a + max_b |h x·v/(r² + η²)|, m/s.
    pub largest_signal: f64,
    /// Largest speed of a fluid particle, m/s.
    pub largest_speed: f64,
    /// Largest |∇·v|, 1/s.
    pub largest_divergence: f64,
    /// Largest kinematic viscosity, eddy viscosity included, m²/s.
    pub largest_viscosity: f64,
    /// Largest rate at which the viscous term damps a particle, 1/s; under `Wcsph` only of
    /// particles with no wall in their support.
    pub largest_damping: f64,
    /// Largest damping rate of particles with a wall in their support, 1/s; 0 under `EdacTvf`.
    pub largest_damping_at_walls: f64,
}

impl RatesFound {
    /// Returns the extremes of two parts of a flow; a value that is NaN in one of them stays so.
    pub fn join(self, other: Self) -> Self {
        Self {
            largest_signal: larger(self.largest_signal, other.largest_signal),
            largest_speed: larger(self.largest_speed, other.largest_speed),
            largest_divergence: larger(self.largest_divergence, other.largest_divergence),
            largest_viscosity: larger(self.largest_viscosity, other.largest_viscosity),
            largest_damping: larger(self.largest_damping, other.largest_damping),
            largest_damping_at_walls: larger(self.largest_damping_at_walls, other.largest_damping_at_walls),
        }
    }
}

/// Steps since the last corrective (Euler) step of Verlet's scheme; 0 in a corrective step.
///
/// Always 0 under kick–drift–kick.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepsSinceCorrection(pub u32);

impl StepsSinceCorrection {
    /// Returns the time level of the velocities in the dissipative terms of the present step: see
    /// `physics/integrator/verlet.rs`.
    pub fn time_level(self) -> TimeLevel {
        if self.0 == 0 { TimeLevel::Present } else { TimeLevel::Previous }
    }
}
