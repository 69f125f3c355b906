//! What makes a run stop: non-finite values, densities and speeds out of bounds, particles lost.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use glam::DVec3;

use super::clock::Clock;
use super::setup::SceneInUse;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::pass::blocks::join_parts;
use crate::scene::model::Scheme;

/// The first reason to stop that a step found.
#[derive(Resource, Clone, Debug, Default)]
pub struct Failure {
    /// An impossible state.
    pub fault: Option<Fault>,
    /// An inlet found the reservoir empty and the scene says to stop.
    pub reservoir_empty: bool,
    /// Index of an inlet that is filled once and has nothing left.
    pub drained: Option<u16>,
}

/// A particle in an impossible state.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Number of the particle.
    pub id: u32,
    /// Its zone.
    pub zone: Zone,
    /// Its position, m.
    pub position: DVec3,
    /// What was found, with the bound it broke.
    pub found: String,
    /// What a user can do about it.
    pub cure: &'static str,
}

/// A speed beyond this multiple of the sound speed is a blow-up: weakly compressible flow needs ten times less
/// than the sound speed.
const LARGEST_MACH: f64 = 3.0;

/// A density off its reference by more than this is a blow-up: 1 % is what the scheme is made for.
const LARGEST_DENSITY_DEVIATION: f64 = 0.5;

impl Failure {
    /// Records that a row left the grid, unless something was recorded before.
    pub fn outside_grid<R: Real, const D: usize>(&mut self, arrays: &ParticleArrays<R, D>, row: usize) {
        let finite = arrays.position_of(row).is_finite();
        let found = if finite {
            "position outside the domain".to_owned()
        } else {
            "position is not finite".to_owned()
        };
        self.record(
            arrays,
            row,
            found,
            "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or refine `spacing`",
        );
    }

    fn record<R: Real, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        row: usize,
        found: String,
        cure: &'static str,
    ) {
        if self.fault.is_none() {
            self.fault = Some(Fault {
                id: arrays.id[row],
                zone: arrays.zone[row],
                position: arrays.position_of(row),
                found,
                cure,
            });
        }
    }
}

/// Looks at every moving particle after the step; records the one with the smallest number.
pub fn check_state<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    arrays: Res<ParticleArrays<R, D>>,
    mut failure: ResMut<Failure>,
) {
    if failure.fault.is_some() || clock.step == 0 {
        return;
    }
    let fluid = scene.0.fluid;
    let speed_limit = LARGEST_MACH * fluid.sound_speed;
    // A zone that its condition does not keep even may clump, as one at rest that a flow from rest runs into. Where densities are summed and
    // say nothing of the pressure, what counts is the fluid.
    let evolves = arrays.evolves_pressure;
    let smaller_number =
        |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min_by_key(|&row| arrays.id[row]);
    let find = |rows: Range<usize>| {
        let mut first: Option<usize> = None;
        for row in rows {
            let mut squared = 0.0;
            for axis in 0..D {
                let v = arrays.velocity[axis][row].to_f64();
                squared += v * v;
            }
            let deviation = (arrays.density[row].to_f64() / fluid.density - 1.0).abs();
            let may_clump = evolves && arrays.zone[row] == Zone::Outflow;
            let limit = if may_clump { f64::INFINITY } else { LARGEST_DENSITY_DEVIATION };
            // Written so that a NaN fails too.
            let sound = squared <= speed_limit * speed_limit && deviation <= limit;
            if !sound {
                first = smaller_number(first, Some(row));
            }
        }
        first
    };
    let Some(row) = join_parts(0..arrays.len(), &find, &smaller_number) else { return };
    let speed = arrays.velocity_of(row).length();
    let density = arrays.density[row].to_f64();
    let density_cure = match scene.0.scheme {
        Scheme::Wcsph(_) => {
            "check that no wall or zone is missing, raise `fluid.sound_speed`, or keep `tensile_control` and shifting on"
        }
        Scheme::EdacTvf(_) => {
            "check that no wall or zone is missing, raise `scheme.background`, or start less even: see scenes/taylor_green_edac.ron"
        }
    };
    if speed <= speed_limit {
        failure.record(
            &arrays,
            row,
            format!("density `{density:.4}` kg/m³, reference `{}` kg/m³ ± 50 %", fluid.density),
            density_cure,
        );
    } else {
        failure.record(
            &arrays,
            row,
            format!("speed `{speed:.4}` m/s, limit `{speed_limit}` m/s (3 c0)"),
            "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or start with a smoother ramp",
        );
    }
}
