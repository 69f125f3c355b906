//! Reasons to stop that the systems of a step find.

use bevy_ecs::resource::Resource;
use glam::DVec3;

use super::neighbourhood::Neighbourhood;
use sphecs_core::format::point;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// First reason to stop that a step found.
#[derive(Resource, Clone, Debug, Default)]
pub struct Failure {
    /// Particle with an impossible value.
    pub diverged: Option<DivergedParticle>,
    /// True if rank 0 records a particle of another rank than itself.
    pub is_elsewhere: bool,
    /// True if an inlet found the reservoir empty and the scene demands a stop.
    pub reservoir_empty: bool,
    /// Index of an inlet that is filled once and has no particles left.
    pub drained: Option<u16>,
}

/// Particle with an impossible value.
#[derive(Clone, Debug, PartialEq)]
pub struct DivergedParticle {
    /// Number of the particle.
    pub id: u32,
    /// Zone.
    pub zone: Zone,
    /// Position, m.
    pub position: DVec3,
    /// Impossible value, with the bound that it violates.
    pub found: String,
    /// Advice to the user.
    pub advice: &'static str,
    /// Particles around it.
    pub neighbourhood: Neighbourhood,
}

impl DivergedParticle {
    /// Returns the impossible value with zone, number and position of the particle.
    pub(crate) fn describe(&self) -> String {
        let at = point(&self.position.to_array(), 0.1 * self.neighbourhood.reach);
        format!("{} of {} particle {} at {at} m", self.found, self.zone.name(), self.id)
    }
}

/// Impossible value of a row.
pub(super) struct Finding {
    /// Value, with the bound that it violates.
    pub found: String,
    /// Advice to the user.
    pub advice: &'static str,
}

impl Failure {
    /// Records that a row is outside the grid of cells, unless a particle is recorded already.
    pub(crate) fn outside_grid<R: PairReal<D>, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        row: usize,
        support: f64,
    ) {
        let is_finite = arrays.position_of(row).is_finite();
        let found = if is_finite { "position outside the domain" } else { "position is not finite" };
        self.record(arrays, row, support, Finding { found: found.to_owned(), advice: STEP_ADVICE });
    }

    /// Records a row with an impossible value, unless one is recorded already.
    pub(super) fn record<R: PairReal<D>, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        row: usize,
        support: f64,
        Finding { found, advice }: Finding,
    ) {
        if self.diverged.is_none() {
            self.diverged = Some(DivergedParticle {
                id: arrays.id[row],
                zone: arrays.zone[row],
                position: arrays.position_of(row),
                found,
                advice,
                neighbourhood: Neighbourhood::around(arrays, row, support),
            });
        }
    }
}

/// Advice for a time step that was too long.
pub(super) const STEP_ADVICE: &str =
    "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or refine `spacing`";
