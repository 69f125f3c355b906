//! The kick: time step, new velocities and positions.

use std::ops::Range;

use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use super::boundaries::motion::{move_inflow, move_outflow};
use super::boundaries::outlets::OutletStates;
use super::boundaries::rows::PatchRows;
use super::clock::Clock;
use super::pair::Pair;
use super::rates::{RatesFound, StepsSincePlain, Sums};
use super::setup::{Resolution, SceneInUse};
use crate::arrays::Arrays;
use sphecs_core::math::lanes::{InstructionSet, Lanes, Vectorised};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part, join_parts};
use sphecs_core::physics::integrator::kick_drift::KickDrift;
use sphecs_core::physics::integrator::verlet::Verlet;
use sphecs_core::physics::integrator::{Advance, Integrator, friction};
use sphecs_core::physics::timestep::TimeStepLimits;

/// Rows that a thread takes at a time.
const CHUNK: usize = 4096;

/// Chooses the time step and advances velocities and positions of fluid, inflow and outflow particles.
pub fn kick<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    resolution: Res<Resolution>,
    found: Res<RatesFound>,
    (pair, rows): (Res<Pair>, Res<PatchRows>),
    outlets: Res<OutletStates>,
    sums: Res<Sums<R, D>>,
    mut since_plain: ResMut<StepsSincePlain>,
    mut clock: ResMut<Clock>,
    mut velocities: Local<Vec<DVec3>>,
    mut arrays: ResMut<Arrays<R, D>>,
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
    let arrays = &mut **arrays;
    let time_step = limits.time_step(
        largest_acceleration(arrays, pair.0.lanes),
        found.largest_signal,
        found.largest_damping,
    );
    let time_step_before = clock.time_step;
    let damping = found.largest_damping_at_walls;
    match parameters.integrator {
        Integrator::Verlet { plain_step_every } => {
            let scheme = Verlet { time_step, time_step_before, plain: since_plain.0 == 0 };
            since_plain.0 = (since_plain.0 + 1) % plain_step_every;
            advance_fluid(&scheme, damping, &sums.0.damping, pair.0.lanes, arrays);
        }
        Integrator::KickDrift => {
            advance_fluid(
                &KickDrift { time_step, time_step_before },
                damping,
                &sums.0.damping,
                pair.0.lanes,
                arrays,
            );
        }
    }
    for (inlet, rows) in scene.inlets.iter().zip(&rows.inflow) {
        move_inflow(inlet, scene.fluid.viscosity, rows, clock.time, time_step, &mut velocities, arrays);
    }
    for (index, (outlet, rows)) in scene.outlets.iter().zip(&rows.outflow).enumerate() {
        move_outflow(outlet, &outlets.0[index], rows, time_step, arrays);
    }
    arrays.fresh.par_iter_mut().with_min_len(CHUNK).for_each(|fresh| *fresh = false);
    clock.time += time_step;
    clock.time_step = time_step;
    clock.step += 1;
}

/// Largest |dv/dt| of fluid particles, m/s². A maximum does not depend on the order in which it is taken. Not taken where the rates are summed:
/// body forces, walls and plugins add to them.
pub(super) fn largest_acceleration<R: Real, const D: usize>(
    arrays: &ParticleArrays<R, D>,
    lanes: InstructionSet,
) -> f64 {
    let (zone, acceleration) = (&*arrays.zone, &arrays.acceleration);
    let largest = |rows: Range<usize>| R::dispatch(lanes, LargestSquare { zone, acceleration, rows });
    let squared: f64 = join_parts(0..zone.len(), &largest, &f64::max);
    squared.sqrt()
}

/// Finds the largest |dv/dt|² of a part's rows: on lanes for their instructions alone, as [`KickPart`].
struct LargestSquare<'a, R, const D: usize> {
    zone: &'a [Zone],
    acceleration: &'a [Vec<R>; D],
    rows: Range<usize>,
}

/// Maxima that are taken side by side: one alone would wait for itself at every row.
const MAXIMA: usize = 16;

impl<R: Real, const D: usize> Vectorised<R> for LargestSquare<'_, R, D> {
    type Output = f64;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> f64 {
        let mut largest = [0.0_f64; MAXIMA];
        for start in self.rows.clone().step_by(MAXIMA) {
            let group = start..self.rows.end.min(start + MAXIMA);
            let mut squared = [0.0_f64; MAXIMA];
            for column in self.acceleration {
                for (squared, a) in squared.iter_mut().zip(&column[group.clone()]) {
                    *squared += a.to_f64() * a.to_f64();
                }
            }
            for ((largest, squared), &zone) in largest.iter_mut().zip(squared).zip(&self.zone[group]) {
                let squared = if zone == Zone::Fluid { squared } else { 0.0 };
                *largest = if squared > *largest { squared } else { *largest };
            }
        }
        largest.into_iter().fold(0.0, f64::max)
    }
}

/// Velocities and positions of the fluid; `largest_damping` and `damping`, 1/s, are those at walls.
fn advance_fluid<A: Advance, R: Real, const D: usize>(
    scheme: &A,
    largest_damping: f64,
    damping: &[R],
    lanes: InstructionSet,
    arrays: &mut ParticleArrays<R, D>,
) {
    if friction::is_fast(scheme, largest_damping) {
        slow_down(scheme, damping, arrays);
    }
    kick_fluid(scheme, lanes, arrays);
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

/// Whether all of some rows are fluid and none is fresh: then a loop over them needs no branches.
#[inline(always)]
pub(super) fn are_plain(zone: &[Zone], fresh: &[bool]) -> bool {
    zone.iter().zip(fresh).fold(true, |all, (zone, fresh)| all & (*zone == Zone::Fluid) & !fresh)
}

fn kick_fluid<A: Advance, R: Real, const D: usize>(
    scheme: &A,
    lanes: InstructionSet,
    arrays: &mut ParticleArrays<R, D>,
) {
    let ParticleArrays { zone, fresh, position, velocity, velocity_before, acceleration, .. } = arrays;
    let (zone, fresh, acceleration) = (&**zone, &**fresh, &*acceleration);
    let work = |rows: Range<usize>, (position, velocity, before): Columns<R, D>| {
        R::dispatch(lanes, KickPart { scheme, zone, fresh, acceleration, rows, position, velocity, before });
    };
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        velocity.each_mut().map(Vec::as_mut_slice),
        velocity_before.each_mut().map(Vec::as_mut_slice),
    );
    for_each_part(0..zone.len(), columns, &work);
}

/// Positions, velocities and earlier velocities of a part's rows.
type Columns<'a, R, const D: usize> = ([&'a mut [f64]; D], [&'a mut [R]; D], [&'a mut [R]; D]);

/// A part of the rows: on lanes for their instructions alone, which its loops, of plain numbers, are compiled for.
struct KickPart<'a, A, R, const D: usize> {
    scheme: &'a A,
    zone: &'a [Zone],
    fresh: &'a [bool],
    acceleration: &'a [Vec<R>; D],
    rows: Range<usize>,
    position: [&'a mut [f64]; D],
    velocity: [&'a mut [R]; D],
    before: [&'a mut [R]; D],
}

impl<A: Advance, R: Real, const D: usize> Vectorised<R> for KickPart<'_, A, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let Self { scheme, zone, fresh, acceleration, rows, position, velocity, before } = self;
        let first = rows.start;
        for start in rows.clone().step_by(GROUP) {
            let group = start..rows.end.min(start + GROUP);
            let part = group.start - first..group.end - first;
            let (zone, fresh) = (&zone[group.clone()], &fresh[group.clone()]);
            let plain = are_plain(zone, fresh);
            for axis in 0..D {
                let x = &mut position[axis][part.clone()];
                let v = &mut velocity[axis][part.clone()];
                let v_before = &mut before[axis][part.clone()];
                let advanced = x.iter_mut().zip(v).zip(v_before).zip(&acceleration[axis][group.clone()]);
                if plain {
                    for (((x, v), v_before), &a) in advanced {
                        (*x, [*v, *v_before]) = scheme.advance(false, *x, [*v, *v_before], a);
                    }
                } else {
                    for ((((x, v), v_before), &a), (&zone, &fresh)) in advanced.zip(zone.iter().zip(fresh)) {
                        if zone == Zone::Fluid {
                            (*x, [*v, *v_before]) = scheme.advance(fresh, *x, [*v, *v_before], a);
                        }
                    }
                }
            }
        }
    }
}
