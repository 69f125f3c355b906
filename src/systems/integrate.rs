//! The kick: time step, new velocities and positions.

use bevy_ecs::system::{Res, ResMut};
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use super::boundaries::motion::{move_inflow, move_outflow};
use super::boundaries::outlets::OutletStates;
use super::boundaries::rows::PatchRows;
use super::clock::Clock;
use super::rates::{RatesFound, StepsSincePlain, Sums};
use super::setup::{Resolution, SceneInUse};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::integrator::kick_drift::KickDrift;
use crate::physics::integrator::verlet::Verlet;
use crate::physics::integrator::{Advance, Integrator, friction};
use crate::physics::timestep::TimeStepLimits;

/// Rows that a thread takes at a time.
const CHUNK: usize = 4096;

/// Chooses the time step and advances velocities and positions of fluid, inflow and outflow particles.
pub fn kick<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    resolution: Res<Resolution>,
    found: Res<RatesFound>,
    rows: Res<PatchRows>,
    outlets: Res<OutletStates>,
    sums: Res<Sums<R, D>>,
    mut since_plain: ResMut<StepsSincePlain>,
    mut clock: ResMut<Clock>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let scene = &*scene.0;
    let Some(parameters) = scene.scheme.wcsph() else { return };
    let limits = TimeStepLimits {
        cfl: scene.time.cfl,
        viscous: scene.time.viscous,
        damping: friction::DAMPING,
        smoothing_length: resolution.smoothing_length,
        viscosity: found.largest_viscosity,
    };
    let arrays = &mut *arrays;
    let time_step =
        limits.time_step(largest_acceleration(arrays), found.largest_signal, found.largest_damping);
    let time_step_before = clock.time_step;
    let damping = found.largest_damping_at_walls;
    match parameters.integrator {
        Integrator::Verlet { plain_step_every } => {
            let scheme = Verlet { time_step, time_step_before, plain: since_plain.0 == 0 };
            since_plain.0 = (since_plain.0 + 1) % plain_step_every;
            advance_fluid(&scheme, damping, &sums.0.damping, arrays);
        }
        Integrator::KickDrift => {
            advance_fluid(&KickDrift { time_step, time_step_before }, damping, &sums.0.damping, arrays);
        }
    }
    for (inlet, rows) in scene.inlets.iter().zip(&rows.inflow) {
        move_inflow(inlet, scene.fluid.viscosity, rows, clock.time, time_step, arrays);
    }
    for (index, (outlet, rows)) in scene.outlets.iter().zip(&rows.outflow).enumerate() {
        move_outflow(outlet, &outlets.0[index], rows, time_step, arrays);
    }
    arrays.fresh.par_iter_mut().with_min_len(CHUNK).for_each(|fresh| *fresh = false);
    clock.time += time_step;
    clock.time_step = time_step;
    clock.step += 1;
}

/// Largest |dv/dt| of fluid particles, m/s². A maximum does not depend on the order in which it is taken.
pub(super) fn largest_acceleration<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>) -> f64 {
    let squared = arrays
        .zone
        .par_iter()
        .with_min_len(CHUNK)
        .enumerate()
        .map(|(row, zone)| {
            if *zone != Zone::Fluid {
                return 0.0;
            }
            (0..D).map(|axis| arrays.acceleration[axis][row].to_f64().powi(2)).sum::<f64>()
        })
        .reduce(|| 0.0, f64::max);
    squared.sqrt()
}

/// Velocities and positions of the fluid; `largest_damping` and `damping`, 1/s, are those at walls.
fn advance_fluid<A: Advance, R: Real, const D: usize>(
    scheme: &A,
    largest_damping: f64,
    damping: &[R],
    arrays: &mut ParticleArrays<R, D>,
) {
    if friction::is_fast(scheme, largest_damping) {
        slow_down(scheme, damping, arrays);
    }
    kick_fluid(scheme, arrays);
}

/// Leaves of the accelerations at walls what a step can follow.
fn slow_down<A: Advance, R: Real, const D: usize>(
    scheme: &A,
    damping: &[R],
    arrays: &mut ParticleArrays<R, D>,
) {
    let (zone, fresh) = (&arrays.zone, &arrays.fresh);
    for acceleration in &mut arrays.acceleration {
        acceleration
            .par_iter_mut()
            .zip(damping.par_iter())
            .zip(zone.par_iter().zip(fresh.par_iter()))
            .with_min_len(CHUNK)
            .for_each(|((a, damping), (&zone, &fresh))| {
                let damping = damping.to_f64();
                if zone == Zone::Fluid && friction::is_fast(scheme, damping) {
                    *a = *a * R::from_f64(friction::share(scheme, fresh, damping));
                }
            });
    }
}

fn kick_fluid<A: Advance, R: Real, const D: usize>(scheme: &A, arrays: &mut ParticleArrays<R, D>) {
    let (zone, fresh) = (&arrays.zone, &arrays.fresh);
    let columns = arrays
        .position
        .iter_mut()
        .zip(&mut arrays.velocity)
        .zip(&mut arrays.velocity_before)
        .zip(&arrays.acceleration);
    for (((position, velocity), before), acceleration) in columns {
        position
            .par_iter_mut()
            .zip(velocity.par_iter_mut())
            .zip(before.par_iter_mut())
            .zip(acceleration.par_iter())
            .zip(zone.par_iter().zip(fresh.par_iter()))
            .with_min_len(CHUNK)
            .for_each(|((((x, v), v_before), &a), (&zone, &fresh))| {
                if zone == Zone::Fluid {
                    (*x, [*v, *v_before]) = scheme.advance(fresh, *x, [*v, *v_before], a);
                }
            });
    }
}
