//! Systems of the scheme `EdacTvf` of Negi et al. (2020): density, rates, kick, shifting in outflow
//! zones.

use std::ops::Range;

use bevy_ecs::system::{Res, ResMut};

use super::advance::{StepSettings, ZoneMotion, are_regular_fluid};
use super::boundaries::emitter_states::EmitterStates;
use super::boundaries::emitters::set_end_densities;
use super::boundaries::patch_rows::PatchRows;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{RatesFound, Sums};
use crate::resources::scene::ActiveScene;
use sphecs_core::math::lanes::{InstructionSet, Lanes, Vectorised};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part};
use sphecs_core::pass::column_access::AfterPasses;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::edac::Edac;
use sphecs_core::physics::integrator::kick_drift::{self, KickDrift};
use sphecs_scene::model::{BodyForce, Patch, Scene, Scheme};

/// Returns the terms of the scheme.
fn terms(scene: &Scene) -> Option<&Edac> {
    match &scene.scheme {
        Scheme::EdacTvf(scheme) => Some(&scheme.terms),
        Scheme::Wcsph(_) => None,
    }
}

/// Computes the density of fluid, inflow and outflow particles by summation.
///
/// At the outer end of a zone the support is truncated, and the sum is too small. Particles there
/// get the reference density; otherwise their volumes would double and push their neighbours into
/// the fluid.
pub(crate) fn sum_volumes<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    (rows, emitters): (Res<PatchRows>, Option<ResMut<EmitterStates>>),
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    R::sum_density(&pair.0, &grid.0, &mut arrays, &mut sums.0);
    let scene = &*scene.0;
    let inlets = scene.inlets.iter().map(|inlet| (&inlet.patch, -1.0)).zip(&rows.inflow);
    let outlets = scene.outlets.iter().map(|outlet| (&outlet.patch, 1.0)).zip(&rows.outflow);
    let full_support_until = |patch: &Patch| patch.depth - pair.0.discretisation.support;
    for ((patch, outwards), rows) in inlets.chain(outlets) {
        for &row in rows {
            if outwards * patch.along(arrays.position_of(row as usize)) > full_support_until(patch) {
                arrays.density[row as usize] = R::from_f64(scene.fluid.density);
            }
        }
    }
    if let Some(mut emitters) = emitters {
        set_end_densities(scene, &mut emitters, &rows, &mut arrays);
    }
}

/// Computes pair forces, pressure rate and acceleration by the background pressure, and the
/// extremes that limit the time step.
pub(crate) fn sum_edac_rates<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut found: ResMut<RatesFound>,
) {
    let Some(terms) = terms(&scene.0) else { return };
    let summary = R::sum_edac_rates(&pair.0, terms, &grid.0, &mut arrays, &mut sums.0);
    *found = RatesFound {
        largest_signal: scene.0.fluid.sound_speed + summary.speed,
        largest_speed: summary.speed,
        largest_divergence: summary.divergence,
        largest_damping: summary.damping,
        largest_damping_at_walls: 0.0,
        largest_viscosity: scene.0.fluid.viscosity,
    };
}

/// Chooses the time step and advances velocity, pressure and position.
pub(crate) fn kick_and_drift<R: PairReal<D>, const D: usize>(
    (scene, mut settings): (Res<ActiveScene>, StepSettings),
    (pair, sums): (Res<Pair>, Res<Sums<R, D>>),
    mut zones: ZoneMotion<R, D>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let gravity = match &scene.0.body_force {
        BodyForce::Constant(force) => force.length(),
        // The accelerations already contain a force that varies in space.
        BodyForce::Expression(_) => 0.0,
    };
    let (arrays, lanes) = (&mut arrays.0, pair.0.lanes);
    let largest_acceleration = settings.join_extremes(arrays, &pair.0);
    let found = &settings.found;
    let time_step = settings.limits(kick_drift::DAMPING).time_step(
        largest_acceleration.max(gravity),
        found.largest_signal,
        found.largest_damping,
    );
    let scheme = KickDrift { time_step, previous_time_step: zones.clock.time_step };
    advance_fluid(
        scheme,
        arrays,
        sums.0.shift.read(AfterPasses),
        sums.0.pressure_rate.read(AfterPasses),
        lanes,
    );
    zones.finish_step(time_step, arrays);
}

/// Advances velocity, pressure, drift and position of the fluid; other rows have no drift.
fn advance_fluid<R: PairReal<D>, const D: usize>(
    scheme: KickDrift,
    arrays: &mut ParticleArrays<R, D>,
    background: &[Vec<R>; D],
    pressure_rate: &[R],
    lanes: InstructionSet,
) {
    let ParticleArrays {
        zone,
        needs_restart,
        position,
        velocity,
        previous_velocity,
        acceleration,
        pressure,
        previous_pressure,
        drift,
        ..
    } = arrays;
    let (zone, needs_restart, acceleration) = (&**zone, &**needs_restart, &*acceleration);
    let work = |rows: Range<usize>, (position, [velocity, half, drift], pressures): RowColumns<R, D>| {
        let rates = Rates { acceleration, background, pressure: pressure_rate };
        R::dispatch(
            lanes,
            DriftPart {
                scheme,
                zone,
                needs_restart,
                rates,
                rows,
                position,
                velocity,
                half,
                drift,
                pressures,
            },
        );
    };
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        [velocity, previous_velocity, drift].map(|columns| columns.each_mut().map(Vec::as_mut_slice)),
        [pressure.as_mut_slice(), previous_pressure.as_mut_slice()],
    );
    for_each_part(0..zone.len(), columns, &work);
}

/// Columns of some rows: positions; velocities, now and half a step earlier, and drifts; pressures,
/// now and half a step earlier.
type RowColumns<'a, R, const D: usize> = ([&'a mut [f64]; D], [[&'a mut [R]; D]; 3], [&'a mut [R]; 2]);

/// Rates that the passes summed.
#[derive(Clone, Copy)]
struct Rates<'a, R, const D: usize> {
    acceleration: &'a [Vec<R>; D],
    background: &'a [Vec<R>; D],
    pressure: &'a [R],
}

/// Kick and drift of some rows.
///
/// A vectorised task so that it is compiled for the instruction set; its loops are scalar.
struct DriftPart<'a, R, const D: usize> {
    scheme: KickDrift,
    zone: &'a [Zone],
    needs_restart: &'a [bool],
    rates: Rates<'a, R, D>,
    rows: Range<usize>,
    position: [&'a mut [f64]; D],
    velocity: [&'a mut [R]; D],
    half: [&'a mut [R]; D],
    drift: [&'a mut [R]; D],
    pressures: [&'a mut [R]; 2],
}

impl<R: PairReal<D>, const D: usize> Vectorised<R> for DriftPart<'_, R, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(mut self) {
        let first = self.rows.start;
        for start in self.rows.clone().step_by(GROUP) {
            let group = start..self.rows.end.min(start + GROUP);
            let part = start - first..group.end - first;
            if are_regular_fluid(&self.zone[group.clone()], &self.needs_restart[group.clone()]) {
                self.advance(group, part, false);
                continue;
            }
            for row in group {
                let at = row - first;
                if self.zone[row] == Zone::Fluid {
                    self.advance(row..row + 1, at..at + 1, self.needs_restart[row]);
                } else {
                    for drift in &mut self.drift {
                        drift[at] = R::default();
                    }
                }
            }
        }
    }
}

impl<R: PairReal<D>, const D: usize> DriftPart<'_, R, D> {
    /// Advances fluid rows, `part` of the written columns; all or none of them need a restart.
    #[inline(always)]
    fn advance(&mut self, rows: Range<usize>, part: Range<usize>, needs_restart: bool) {
        let scheme = self.scheme;
        let time_step = R::from_f64(scheme.time_step);
        for axis in 0..D {
            let rates = self.rates.acceleration[axis][rows.clone()].iter();
            let rates = rates.zip(&self.rates.background[axis][rows.clone()]);
            let velocities =
                self.velocity[axis][part.clone()].iter_mut().zip(&mut self.half[axis][part.clone()]);
            let moved = self.position[axis][part.clone()].iter_mut().zip(&mut self.drift[axis][part.clone()]);
            for (((v, half), (x, drift)), (&rate, &background)) in velocities.zip(moved).zip(rates) {
                *half = scheme.half(needs_restart, *v, *half, rate);
                *v = scheme.predict(*half, rate);
                *drift = time_step * background;
                *x = scheme.position(*x, half.to_f64(), drift.to_f64());
            }
        }
        let [pressure, half] = &mut self.pressures;
        let pressures = pressure[part.clone()].iter_mut().zip(&mut half[part]);
        for ((pressure, half), &rate) in pressures.zip(&self.rates.pressure[rows]) {
            *half = scheme.half(needs_restart, *pressure, *half, rate);
            *pressure = scheme.predict(*half, rate);
        }
    }
}

/// Shifts the particles of outflow zones as the background pressure shifts the fluid: δx = −2 Δt²
/// (p_b/ρ0) ∇C.
///
/// For a uniform distribution, Σ (V_a² + V_b²) ∇W/m is 2 ∇C/ρ0.
pub(crate) fn shift_outlets<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    rows: Res<PatchRows>,
    sums: Res<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let Some(terms) = terms(&scene.0) else { return };
    let sound = scene.0.fluid.sound_speed * clock.time_step;
    let strength = -2.0 * terms.background * sound * sound;
    let longest = LONGEST_SHIFT * scene.0.discretisation.spacing;
    for &row in rows.outflow.iter().flatten() {
        let row = row as usize;
        let concentration = sums.0.shift.read(AfterPasses).each_ref().map(|column| column[row].to_f64());
        let length = strength.abs() * concentration.iter().map(|x| x * x).sum::<f64>().sqrt();
        let share = if length > longest { longest / length } else { 1.0 };
        for axis in 0..D {
            arrays.position[axis][row] += share * strength * concentration[axis];
        }
    }
}

/// Largest displacement by the shifting of a zone in one step, over Δ.
const LONGEST_SHIFT: f64 = 0.1;
