//! Velocity and pressure of wall particles.

use std::ops::Range;

use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::rows::vector;
use crate::particles::zone::Zone;
use crate::pass::blocks::for_each_part;
use crate::pass::walls::extrapolate_wall_pressure;
use crate::physics::wall::{WallModel, WallPressure};
use crate::scene::model::WallPart;
use crate::systems::clock::Clock;
use crate::systems::neighbours::Grid;
use crate::systems::pair::Pair;
use crate::systems::rates::Sums;
use crate::systems::setup::SceneInUse;
use bevy_ecs::system::{Res, ResMut};

/// Sets the velocity of walls whose surface moves, and the pressure of wall particles from the flow next to them.
pub fn apply_walls<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<ParticleArrays<R, D>>,
) {
    let scene = &*scene.0;
    let time = clock.time;
    let parts = &scene.walls.parts;
    let moves = |part: &WallPart| part.velocity.iter().any(|component| component.constant() != Some(0.0));
    if parts.iter().any(moves) {
        let ParticleArrays { zone, patch, position, velocity, .. } = &mut *arrays;
        let (zone, patch, position) = (&*zone, &*patch, &*position);
        let work = |rows: Range<usize>, velocity: [&mut [R]; D]| {
            for (at, row) in rows.enumerate() {
                if zone[row] != Zone::Wall {
                    continue;
                }
                let part = &parts[usize::from(patch[row])];
                if moves(part) {
                    let x = vector(position, row);
                    for axis in 0..D {
                        let speed = part.velocity[axis].value(x.x, x.y, x.z, time);
                        velocity[axis][at] = R::from_f64(speed);
                    }
                }
            }
        };
        for_each_part(0..zone.len(), velocity.each_mut().map(Vec::as_mut_slice), &work);
    }
    let WallModel::Image { pressure, .. } = scene.walls.model;
    if pressure == WallPressure::Extrapolated {
        extrapolate_wall_pressure(&pair.0, &grid.0, &mut arrays, &mut sums.0);
    }
}
