//! Particle shifting after the kick.

use std::ops::Range;

use bevy_ecs::system::{Res, ResMut};

use super::clock::Clock;
use super::rates::{RatesFound, Sums};
use super::setup::{Resolution, SceneInUse};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::pass::blocks::for_each_part;
use crate::physics::shifting::{ShiftStep, Shifting, carried};

/// Moves fluid and outflow particles by the shifting vector that the pair sums found. Fluid particles take the velocity of
/// the place they are moved to, at both time levels, if the shifting says so; those of an outflow have theirs from
/// the outlet's condition.
pub fn shift<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    resolution: Res<Resolution>,
    found: Res<RatesFound>,
    sums: Res<Sums<R, D>>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let Some(scheme) = scene.0.scheme.wcsph().filter(|scheme| scheme.shifting != Shifting::Off) else {
        return;
    };
    let shifting = scheme.shifting;
    let step = ShiftStep {
        smoothing_length: resolution.smoothing_length,
        spacing: resolution.spacing,
        largest_speed: found.largest_speed,
        time_step: clock.time_step,
    };
    let ParticleArrays { zone, position, velocity, velocity_before, drift, drifts, .. } = &mut *arrays;
    let (zone, sums) = (&*zone, &sums.0);
    let (carries, per_step) = (shifting.carries_velocity(), 1.0 / step.time_step);
    let work =
        |rows: Range<usize>, (position, [mut now, mut before]): Columns<R, D, 2>, drift: &mut [&mut [R]]| {
            let first = rows.start;
            for start in rows.clone().step_by(GROUP) {
                let group = start..rows.end.min(start + GROUP);
                let part = start - first..group.end - first;
                let zone = &zone[group.clone()];
                let concentration = sums.shift.each_ref().map(|column| &column[group.clone()]);
                let velocity = now.each_ref().map(|column| &column[part.clone()]);
                let mut moved = displacements(shifting, step, zone, concentration, velocity);
                for axis in 0..D {
                    for (x, moved) in position[axis][part.clone()].iter_mut().zip(&moved[axis]) {
                        *x += moved;
                    }
                }
                for (drift, moved) in drift.iter_mut().zip(&moved) {
                    for (drift, moved) in drift[part.clone()].iter_mut().zip(moved) {
                        *drift = R::from_f64(moved * per_step);
                    }
                }
                if !carries {
                    continue;
                }
                for (at, zone) in zone.iter().enumerate() {
                    for moved in &mut moved {
                        moved[at] = if *zone == Zone::Fluid { moved[at] } else { 0.0 };
                    }
                }
                for (of_component, (now, before)) in
                    sums.neighbour_gradient.iter().zip(now.iter_mut().zip(before.iter_mut()))
                {
                    let slopes = of_component.each_ref().map(|slopes| &slopes[group.clone()]);
                    let velocities = now[part.clone()].iter_mut().zip(&mut before[part.clone()]);
                    for (at, (now, before)) in velocities.enumerate() {
                        let mut moves = [0.0; D];
                        let mut slope = [0.0; D];
                        for axis in 0..D {
                            (moves[axis], slope[axis]) = (moved[axis][at], slopes[axis][at].to_f64());
                        }
                        let change = R::from_f64(carried(moves, slope));
                        *now += change;
                        *before += change;
                    }
                }
            }
        };
    let position = position.each_mut().map(Vec::as_mut_slice);
    let [now, before] = [velocity, velocity_before].map(|columns| columns.each_mut().map(Vec::as_mut_slice));
    let rows = 0..zone.len();
    if *drifts {
        let columns = (position, [now, before, drift.each_mut().map(Vec::as_mut_slice)]);
        for_each_part(rows, columns, &|rows, (position, [now, before, mut drift]): Columns<R, D, 3>| {
            work(rows, (position, [now, before]), &mut drift);
        });
    } else {
        for_each_part(rows, (position, [now, before]), &|rows, columns: Columns<R, D, 2>| {
            work(rows, columns, &mut []);
        });
    }
}

/// Rows that are looked at together: loops over them have no branches and become vectors.
const GROUP: usize = 64;

/// Displacements of a group of rows, m: none of those that are not shifted.
#[inline(always)]
fn displacements<R: Real, const D: usize>(
    shifting: Shifting,
    step: ShiftStep,
    zone: &[Zone],
    concentration: [&[R]; D],
    velocity: [&[R]; D],
) -> [[f64; GROUP]; D] {
    let rows = zone.len().min(GROUP);
    let squares = |columns: [&[R]; D]| {
        let mut sums = [0.0; GROUP];
        for column in columns {
            for (sum, x) in sums.iter_mut().zip(column) {
                *sum += x.to_f64() * x.to_f64();
            }
        }
        sums
    };
    let (mut scales, mut squared) = (squares(velocity), squares(concentration));
    let (scales, squared) = (&mut scales[..rows], &mut squared[..rows]);
    shifting.scales(scales, step);
    let mut too_long = false;
    for (scale, squared) in scales.iter().zip(&mut *squared) {
        *squared *= scale * scale;
        too_long |= *squared > step.squared_limit();
    }
    if too_long {
        for (scale, squared) in scales.iter_mut().zip(squared) {
            *scale = step.shortened(*scale, *squared);
        }
    }
    for (scale, zone) in scales.iter_mut().zip(zone) {
        *scale = if matches!(zone, Zone::Fluid | Zone::Outflow) { *scale } else { 0.0 };
    }
    let mut moved = [[0.0; GROUP]; D];
    for axis in 0..D {
        for ((moved, scale), x) in moved[axis].iter_mut().zip(&*scales).zip(concentration[axis]) {
            // What rows that are not shifted have in their sums is from rows of another step.
            *moved = if *scale == 0.0 { 0.0 } else { scale * x.to_f64() };
        }
    }
    moved
}

/// Positions; velocities, present and before, and drifts if there are any, of a part's rows.
type Columns<'a, R, const D: usize, const N: usize> = ([&'a mut [f64]; D], [[&'a mut [R]; D]; N]);
