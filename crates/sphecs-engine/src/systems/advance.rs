//! Parts of a step that the schemes share: largest acceleration, motion of the zones, end of the
//! step.

use std::ops::Range;

use bevy_ecs::system::{Local, Res, ResMut, SystemParam};
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::boundaries::emitter_states::EmitterStates;
use super::boundaries::emitters::move_emitters;
use super::boundaries::inflow_columns::InflowColumns;
use super::boundaries::inlets::move_inflow;
use super::boundaries::movers::WallMotion;
use super::boundaries::outlets::Outlets;
use super::boundaries::patch_rows::PatchRows;
use crate::resources::clock::Clock;
use crate::resources::pair_sums::RatesFound;
use crate::resources::scene::ActiveScene;
use sphecs_core::math::lanes::{InstructionSet, Lanes, Vectorised};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::join_parts;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::settings::PairSettings;
use sphecs_core::physics::timestep::TimeStepLimits;

/// Rows per task of a thread.
const CHUNK: usize = 4096;

/// Scene and extremes that limit the time step.
#[derive(SystemParam)]
pub(crate) struct StepSettings<'w> {
    scene: Res<'w, ActiveScene>,
    /// Extremes that the pair pass found.
    pub found: ResMut<'w, RatesFound>,
}

impl StepSettings<'_> {
    /// Joins the extremes of all ranks and returns the largest |dv/dt| of fluid particles, m/s².
    ///
    /// The pair pass cannot find that one, since body forces, walls and plugins add to the
    /// accelerations afterwards. The ranks meet here and not after the pair pass: the work at
    /// openings in between differs from rank to rank.
    pub(crate) fn join_extremes<R: PairReal<D>, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        pair: &PairSettings,
    ) -> f64 {
        let own = Extremes { squared: largest_squared_acceleration(arrays, pair.lanes), found: *self.found };
        let all = pair.ranks.joined(own, Extremes::join);
        *self.found = all.found;
        all.squared.sqrt()
    }

    /// Returns the limits of the time step, with the damping factor C_λ of the integrator.
    pub(crate) fn limits(&self, damping: f64) -> TimeStepLimits {
        TimeStepLimits {
            cfl: self.scene.0.time.cfl,
            viscous: self.scene.0.time.viscous,
            damping,
            smoothing_length: self.scene.0.discretisation.smoothing_length,
            viscosity: self.found.largest_viscosity,
        }
    }
}

/// Clock, inflow and outflow zones, walls that move: everything that a step advances besides the
/// fluid.
#[derive(SystemParam)]
pub(crate) struct ZoneMotion<'w, 's, R: PairReal<D>, const D: usize> {
    scene: Res<'w, ActiveScene>,
    rows: Res<'w, PatchRows>,
    outlets: Res<'w, Outlets<R, D>>,
    columns: ResMut<'w, InflowColumns>,
    emitters: Option<ResMut<'w, EmitterStates>>,
    walls: WallMotion<'w>,
    /// Time at the beginning of the step, and size of the previous step.
    pub clock: ResMut<'w, Clock>,
    velocities: Local<'s, Vec<DVec3>>,
}

impl<R: PairReal<D>, const D: usize> ZoneMotion<'_, '_, R, D> {
    /// Moves inflow, outflow and wall particles over a time step, s, and advances the clock.
    pub(crate) fn finish_step(&mut self, time_step: f64, arrays: &mut ParticleArrays<R, D>) {
        let (scene, clock) = (&*self.scene.0, &mut *self.clock);
        let (time, viscosity) = (clock.time, scene.fluid.viscosity);
        for (index, (inlet, rows)) in scene.inlets.iter().zip(&self.rows.inflow).enumerate() {
            let column = self.columns.column(index);
            move_inflow((inlet, viscosity), column, rows, (time, time_step), &mut self.velocities, arrays);
        }
        for (index, (outlet, rows)) in scene.outlets.iter().zip(&self.rows.outflow).enumerate() {
            self.outlets.all[index].move_particles(outlet, rows, time_step, arrays);
        }
        arrays
            .needs_restart
            .par_iter_mut()
            .with_min_len(CHUNK)
            .for_each(|needs_restart| *needs_restart = false);
        clock.time += time_step;
        clock.time_step = time_step;
        clock.step += 1;
        self.walls.finish_step(scene, clock.time, arrays);
        if let Some(emitters) = &mut self.emitters {
            let walls = (scene, self.walls.poses());
            move_emitters(walls, emitters, &mut self.columns, &self.rows, (time, time_step), arrays);
        }
    }
}

/// Returns true if all rows are fluid without need of a restart, so that a loop over them has no
/// branches.
#[inline(always)]
pub(crate) fn are_regular_fluid(zone: &[Zone], needs_restart: &[bool]) -> bool {
    zone.iter()
        .zip(needs_restart)
        .fold(true, |all, (zone, needs_restart)| all & (*zone == Zone::Fluid) & !needs_restart)
}

/// Extremes of the particles of a rank.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Extremes {
    /// Largest |dv/dt|², m²/s⁴.
    squared: f64,
    found: RatesFound,
}

impl Extremes {
    fn join(self, other: Self) -> Self {
        Self { squared: self.squared.max(other.squared), found: self.found.join(other.found) }
    }
}

/// Returns the largest |dv/dt|² of fluid particles, m²/s⁴.
///
/// A maximum does not depend on the order of its operands.
fn largest_squared_acceleration<R: PairReal<D>, const D: usize>(
    arrays: &ParticleArrays<R, D>,
    lanes: InstructionSet,
) -> f64 {
    let (zone, acceleration) = (&*arrays.zone, &arrays.acceleration);
    let largest = |rows: Range<usize>| R::dispatch(lanes, LargestSquare { zone, acceleration, rows });
    join_parts(0..zone.len(), &largest, &f64::max)
}

/// Finds the largest |dv/dt|² of some rows.
///
/// A vectorised task so that it is compiled for the instruction set; its loops are scalar.
struct LargestSquare<'a, R, const D: usize> {
    zone: &'a [Zone],
    acceleration: &'a [Vec<R>; D],
    rows: Range<usize>,
}

/// Number of independent maxima: a single one would be a chain of dependent comparisons.
const MAXIMA: usize = 16;

impl<R: PairReal<D>, const D: usize> Vectorised<R> for LargestSquare<'_, R, D> {
    type Output = f64;
    type Module = Self;

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
