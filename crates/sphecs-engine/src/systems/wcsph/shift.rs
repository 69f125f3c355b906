//! Particle shifting after the kick, in the scheme `Wcsph`.

use std::ops::Range;

use bevy_ecs::system::{Res, ResMut};

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{RatesFound, Sums};
use crate::resources::scene::ActiveScene;
use sphecs_core::math::lanes::{Lanes, Vectorised};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part};
use sphecs_core::pass::column_access::AfterPasses;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::sums::PairSums;
use sphecs_core::physics::shifting::{ShiftStep, Shifting, add_carried};

/// Displaces fluid and outflow particles by the shifting vector of the pair sums.
///
/// With a shifting that carries velocity, fluid particles take the velocity of their new position,
/// at both time levels. The velocity of outflow particles is that of the outlet condition.
pub(crate) fn shift<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    found: Res<RatesFound>,
    pair: Res<Pair>,
    sums: Res<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let Some(scheme) = scene.0.scheme.wcsph().filter(|scheme| !scheme.shifting.is_off()) else {
        return;
    };
    let shifting = scheme.shifting;
    let step = ShiftStep {
        smoothing_length: scene.0.discretisation.smoothing_length,
        spacing: scene.0.discretisation.spacing,
        largest_speed: found.largest_speed,
        time_step: clock.time_step,
    };
    let ParticleArrays { zone, position, velocity, previous_velocity, drift, .. } = &mut **arrays;
    let (zone, sums) = (&**zone, &sums.0);
    let position = position.each_mut().map(Vec::as_mut_slice);
    let velocities = [velocity, previous_velocity].map(|columns| columns.each_mut().map(Vec::as_mut_slice));
    let drift = drift.each_mut().map(Vec::as_mut_slice);
    let work = |rows: Range<usize>, (position, velocities, drift): RowColumns<R, D>| {
        R::dispatch(
            pair.0.lanes,
            ShiftPart { shifting, step, sums, zone, rows, position, velocities, drift },
        );
    };
    for_each_part(0..zone.len(), (position, velocities, drift), &work);
}

/// Columns of some rows: positions; present and previous velocities; drifts, empty if they are not
/// stored.
type RowColumns<'a, R, const D: usize> = ([&'a mut [f64]; D], [[&'a mut [R]; D]; 2], [&'a mut [R]; D]);

/// Shifting of some rows.
///
/// A vectorised task only to be compiled for the instruction set; its loops are scalar.
struct ShiftPart<'a, R: PairReal<D>, const D: usize> {
    shifting: Shifting,
    step: ShiftStep,
    sums: &'a PairSums<R, D>,
    zone: &'a [Zone],
    rows: Range<usize>,
    position: [&'a mut [f64]; D],
    velocities: [[&'a mut [R]; D]; 2],
    drift: [&'a mut [R]; D],
}

impl<R: PairReal<D>, const D: usize> Vectorised<R> for ShiftPart<'_, R, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(mut self) {
        let carries = self.shifting.carries_velocity();
        let first = self.rows.start;
        for start in self.rows.clone().step_by(GROUP) {
            let group = start..self.rows.end.min(start + GROUP);
            let part = start - first..group.end - first;
            let mut moved = self.displacements(&group, &part);
            for axis in 0..D {
                for (x, moved) in self.position[axis][part.clone()].iter_mut().zip(&moved[axis]) {
                    *x += moved;
                }
            }
            let per_step = 1.0 / self.step.time_step;
            for axis in 0..D {
                if let Some(drift) = self.drift[axis].get_mut(part.clone()) {
                    for (drift, moved) in drift.iter_mut().zip(&moved[axis]) {
                        *drift = R::from_f64(moved * per_step);
                    }
                }
            }
            if carries {
                for moved in &mut moved {
                    for (moved, zone) in moved.iter_mut().zip(&self.zone[group.clone()]) {
                        *moved = if *zone == Zone::Fluid { *moved } else { 0.0 };
                    }
                }
                self.carry(&group, &part, &moved);
            }
        }
    }
}

impl<R: PairReal<D>, const D: usize> ShiftPart<'_, R, D> {
    /// Changes the velocities of rows to those of their new positions.
    #[inline(always)]
    fn carry(&mut self, group: &Range<usize>, part: &Range<usize>, moved: &[[f64; GROUP]; D]) {
        let [now, before] = &mut self.velocities;
        for component in 0..D {
            let slopes = &self.sums.neighbour_gradient.read(AfterPasses)[component];
            let velocities =
                now[component][part.clone()].iter_mut().zip(&mut before[component][part.clone()]);
            let mut changes = [0.0; GROUP];
            for axis in 0..D {
                add_carried(&mut changes, &moved[axis], &slopes[axis][group.clone()]);
            }
            for ((now, before), change) in velocities.zip(changes) {
                let change = R::from_f64(change);
                *now += change;
                *before += change;
            }
        }
    }

    /// Returns the displacements of a group of rows, m; zero for rows that are not shifted.
    #[inline(always)]
    fn displacements(&self, group: &Range<usize>, part: &Range<usize>) -> [[f64; GROUP]; D] {
        let rows = group.len().min(GROUP);
        let (mut scales, mut squared) = ([0.0; GROUP], [0.0; GROUP]);
        let (scales, squared) = (&mut scales[..rows], &mut squared[..rows]);
        for axis in 0..D {
            add_squares(scales, &self.velocities[0][axis][part.clone()]);
            add_squares(squared, &self.sums.shift.read(AfterPasses)[axis][group.clone()]);
        }
        self.shifting.scales(scales, self.step);
        let mut too_long = false;
        for (scale, squared) in scales.iter().zip(&mut *squared) {
            *squared *= scale * scale;
            too_long |= *squared > self.step.squared_limit();
        }
        if too_long {
            for (scale, squared) in scales.iter_mut().zip(squared) {
                *scale = self.step.shortened(*scale, *squared);
            }
        }
        for (scale, zone) in scales.iter_mut().zip(&self.zone[group.clone()]) {
            *scale = if matches!(zone, Zone::Fluid | Zone::Outflow) { *scale } else { 0.0 };
        }
        let mut moved = [[0.0; GROUP]; D];
        for axis in 0..D {
            let vectors = &self.sums.shift.read(AfterPasses)[axis][group.clone()];
            for ((moved, scale), x) in moved[axis].iter_mut().zip(&*scales).zip(vectors) {
                // Sums of rows that are not shifted may be left over from another step.
                *moved = if *scale == 0.0 { 0.0 } else { scale * x.to_f64() };
            }
        }
        moved
    }
}

#[inline(always)]
fn add_squares<R: Real>(sums: &mut [f64], column: &[R]) {
    for (sum, x) in sums.iter_mut().zip(column) {
        *sum += x.to_f64() * x.to_f64();
    }
}
