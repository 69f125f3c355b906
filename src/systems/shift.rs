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
    let per_step = 1.0 / step.time_step;
    let (zone, sums) = (&*zone, &sums.0);
    let work =
        |rows: Range<usize>, (position, [mut now, mut before]): Columns<R, D, 2>, drift: &mut [&mut [R]]| {
            for (at, row) in rows.enumerate() {
                if zone[row] != Zone::Fluid && zone[row] != Zone::Outflow {
                    for drift in &mut *drift {
                        drift[at] = R::default();
                    }
                    continue;
                }
                let concentration: [f64; D] = std::array::from_fn(|axis| sums.shift[axis][row].to_f64());
                let squared_speed = (0..D).map(|axis| now[axis][at].to_f64().powi(2)).sum::<f64>();
                let moved = shifting.displacement(concentration, squared_speed, step);
                for axis in 0..D {
                    position[axis][at] += moved[axis];
                }
                for (drift, moved) in drift.iter_mut().zip(moved) {
                    drift[at] = R::from_f64(moved * per_step);
                }
                if shifting.carries_velocity() && zone[row] == Zone::Fluid {
                    let gradient =
                        sums.neighbour_gradient.each_ref().map(|of| of.each_ref().map(|g| g[row].to_f64()));
                    let change = carried(moved, gradient);
                    for velocity in [&mut now, &mut before] {
                        for axis in 0..D {
                            velocity[axis][at] += R::from_f64(change[axis]);
                        }
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

/// Positions; velocities, present and before, and drifts if there are any, of a part's rows.
type Columns<'a, R, const D: usize, const N: usize> = ([&'a mut [f64]; D], [[&'a mut [R]; D]; N]);
