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
use crate::physics::shifting::{ShiftStep, Shifting};

/// Moves fluid and outflow particles by the shifting vector that the pair sums found. They keep their velocity: carried
/// along its gradient, v + δx·∇v, the noise of single particles feeds itself (a constricted channel blew up with A = 6).
pub fn shift<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    resolution: Res<Resolution>,
    found: Res<RatesFound>,
    sums: Res<Sums<R, D>>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let shifting = scene.0.scheme.shifting;
    if shifting == Shifting::Off {
        return;
    }
    let step = ShiftStep {
        smoothing_length: resolution.smoothing_length,
        spacing: resolution.spacing,
        largest_speed: found.largest_speed,
        time_step: clock.time_step,
    };
    let ParticleArrays { zone, position, .. } = &mut *arrays;
    let (zone, sums) = (&*zone, &sums.0);
    let work = |rows: Range<usize>, position: [&mut [f64]; D]| {
        for (at, row) in rows.enumerate() {
            if zone[row] != Zone::Fluid && zone[row] != Zone::Outflow {
                continue;
            }
            let concentration: [f64; D] = std::array::from_fn(|axis| sums.shift[axis][row].to_f64());
            let moved = shifting.displacement(concentration, step);
            for axis in 0..D {
                position[axis][at] += moved[axis];
            }
        }
    };
    for_each_part(0..zone.len(), position.each_mut().map(Vec::as_mut_slice), &work);
}
