//! Kick of the scheme `Wcsph`: time step, new velocities and positions.

use std::ops::Range;

use bevy_ecs::system::{Res, ResMut};
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use crate::arrays::Arrays;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use crate::systems::advance::{StepSettings, ZoneMotion, are_regular_fluid};
use sphecs_core::math::lanes::{InstructionSet, Lanes, Vectorised};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part};
use sphecs_core::pass::column_access::AfterPasses;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::integrator::kick_drift::KickDrift;
use sphecs_core::physics::integrator::verlet::Verlet;
use sphecs_core::physics::integrator::{Advance, Integrator, friction};

/// Rows per task of a thread.
const CHUNK: usize = 4096;

/// Chooses the time step and advances velocities and positions of fluid, inflow and outflow
/// particles.
pub(crate) fn kick<R: PairReal<D>, const D: usize>(
    (scene, mut settings): (Res<ActiveScene>, StepSettings),
    (pair, sums): (Res<Pair>, Res<Sums<R, D>>),
    mut since_correction: ResMut<StepsSinceCorrection>,
    mut zones: ZoneMotion<R, D>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let Some(parameters) = scene.0.scheme.wcsph() else { return };
    let (arrays, lanes) = (&mut arrays.0, pair.0.lanes);
    let largest_acceleration = settings.join_extremes(arrays, &pair.0);
    let found = &settings.found;
    let time_step = settings.limits(friction::DAMPING).time_step(
        largest_acceleration,
        found.largest_signal.max(scene.0.fluid.sound_speed),
        found.largest_damping,
    );
    let previous_time_step = zones.clock.time_step;
    let damping = found.largest_damping_at_walls;
    match parameters.integrator {
        Integrator::Verlet { corrective_step_every } => {
            let is_corrective = since_correction.0 == 0;
            let scheme = Verlet { time_step, previous_time_step, is_corrective };
            since_correction.0 = (since_correction.0 + 1) % corrective_step_every;
            advance_fluid(&scheme, damping, sums.0.damping.read(AfterPasses), lanes, arrays);
        }
        Integrator::KickDrift => {
            let scheme = KickDrift { time_step, previous_time_step };
            advance_fluid(&scheme, damping, sums.0.damping.read(AfterPasses), lanes, arrays);
        }
    }
    zones.finish_step(time_step, arrays);
}

/// Advances velocities and positions of the fluid; `largest_damping` and `damping`, 1/s, are those
/// at walls.
fn advance_fluid<A: Advance, R: PairReal<D>, const D: usize>(
    scheme: &A,
    largest_damping: f64,
    damping: &[R],
    lanes: InstructionSet,
    arrays: &mut ParticleArrays<R, D>,
) {
    if friction::is_fast(scheme, largest_damping) {
        limit_friction(scheme, damping, arrays);
    }
    kick_fluid(scheme, lanes, arrays);
}

/// Reduces the accelerations at walls to the part that the step resolves.
fn limit_friction<A: Advance, R: PairReal<D>, const D: usize>(
    scheme: &A,
    damping: &[R],
    arrays: &mut ParticleArrays<R, D>,
) {
    let (zone, needs_restart) = (&arrays.zone, &arrays.needs_restart);
    for acceleration in &mut arrays.acceleration {
        acceleration
            .par_iter_mut()
            .zip(damping.par_iter())
            .zip(zone.par_iter().zip(needs_restart.par_iter()))
            .with_min_len(CHUNK)
            .for_each(|((a, damping), (&zone, &needs_restart))| {
                let damping = damping.to_f64();
                if zone == Zone::Fluid && friction::is_fast(scheme, damping) {
                    *a = *a * R::from_f64(friction::implicit_factor(scheme, needs_restart, damping));
                }
            });
    }
}

/// Advances velocities and positions of the fluid rows.
fn kick_fluid<A: Advance, R: PairReal<D>, const D: usize>(
    scheme: &A,
    lanes: InstructionSet,
    arrays: &mut ParticleArrays<R, D>,
) {
    let ParticleArrays { zone, needs_restart, position, velocity, previous_velocity, acceleration, .. } =
        arrays;
    let (zone, needs_restart, acceleration) = (&**zone, &**needs_restart, &*acceleration);
    let work = |rows: Range<usize>, (position, velocity, before): RowColumns<R, D>| {
        R::dispatch(
            lanes,
            KickPart { scheme, zone, needs_restart, acceleration, rows, position, velocity, before },
        );
    };
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        velocity.each_mut().map(Vec::as_mut_slice),
        previous_velocity.each_mut().map(Vec::as_mut_slice),
    );
    for_each_part(0..zone.len(), columns, &work);
}

/// Positions, velocities and previous velocities of some rows.
type RowColumns<'a, R, const D: usize> = ([&'a mut [f64]; D], [&'a mut [R]; D], [&'a mut [R]; D]);

/// Kick of some rows.
///
/// A vectorised task only to be compiled for the instruction set; its loops are scalar.
struct KickPart<'a, A, R, const D: usize> {
    scheme: &'a A,
    zone: &'a [Zone],
    needs_restart: &'a [bool],
    acceleration: &'a [Vec<R>; D],
    rows: Range<usize>,
    position: [&'a mut [f64]; D],
    velocity: [&'a mut [R]; D],
    before: [&'a mut [R]; D],
}

impl<A: Advance, R: PairReal<D>, const D: usize> Vectorised<R> for KickPart<'_, A, R, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let Self { scheme, zone, needs_restart, acceleration, rows, position, velocity, before } = self;
        let first = rows.start;
        for start in rows.clone().step_by(GROUP) {
            let group = start..rows.end.min(start + GROUP);
            let part = group.start - first..group.end - first;
            let (zone, needs_restart) = (&zone[group.clone()], &needs_restart[group.clone()]);
            let is_regular = are_regular_fluid(zone, needs_restart);
            for axis in 0..D {
                let x = &mut position[axis][part.clone()];
                let v = &mut velocity[axis][part.clone()];
                let v_before = &mut before[axis][part.clone()];
                let advanced = x.iter_mut().zip(v).zip(v_before).zip(&acceleration[axis][group.clone()]);
                if is_regular {
                    for (((x, v), v_before), &a) in advanced {
                        (*x, [*v, *v_before]) = scheme.advance(false, *x, [*v, *v_before], a);
                    }
                } else {
                    for ((((x, v), v_before), &a), (&zone, &needs_restart)) in
                        advanced.zip(zone.iter().zip(needs_restart))
                    {
                        if zone == Zone::Fluid {
                            (*x, [*v, *v_before]) = scheme.advance(needs_restart, *x, [*v, *v_before], a);
                        }
                    }
                }
            }
        }
    }
}
