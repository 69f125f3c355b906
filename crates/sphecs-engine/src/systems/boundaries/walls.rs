//! Velocity and pressure of wall particles.
//!
//! A wall particle has the velocity of the surface point in front of it, x_w + d_w n: that of its own place would, inside
//! a cylinder that turns, be too slow by the depth, and the fluid would see a surface that lags.

use std::ops::Range;

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use crate::systems::forces::body_force;
use bevy_ecs::system::{Res, ResMut};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, vector};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::rates::VelocityLevel;
use sphecs_core::pass::wall_velocity::find_velocity_seen;
use sphecs_core::pass::walls::extrapolate_wall_pressure;
use sphecs_core::physics::wall::{Slip, WallModel, WallPressure};
use sphecs_scene::model::{BodyForce, Scene, WallPart};

/// Sets the velocity of walls whose surface moves, and pressure and velocity of wall particles from the flow next to them, as
/// the wall model asks.
pub fn apply_walls<R: Real, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Option<Res<StepsSinceCorrection>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    let time = clock.time;
    let parts = &scene.walls.parts;
    if parts.iter().any(WallPart::moves) {
        let ParticleArrays {
            zone,
            patch,
            position,
            velocity,
            velocity_before,
            wall_distance,
            wall_normal,
            ..
        } = &mut **arrays;
        let (zone, patch, position) = (&*zone, &*patch, &*position);
        let (wall_distance, wall_normal) = (&*wall_distance, &*wall_normal);
        let work = |rows: Range<usize>, (velocity, before): Columns<R, D>| {
            for (at, row) in rows.enumerate() {
                if zone[row] != Zone::Wall {
                    continue;
                }
                let part = &parts[usize::from(patch[row])];
                if part.moves() {
                    let depth = wall_distance[row].to_f64();
                    let surface = vector(position, row) + real_vector(wall_normal, row) * depth;
                    let now = part.velocity_at(surface, time);
                    for axis in 0..D {
                        before[axis][at] = velocity[axis][at];
                        velocity[axis][at] = R::from_f64(now[axis]);
                    }
                }
            }
        };
        let columns =
            (velocity.each_mut().map(Vec::as_mut_slice), velocity_before.each_mut().map(Vec::as_mut_slice));
        for_each_part(0..zone.len(), columns, &work);
    }
    match scene.walls.model.pressure() {
        WallPressure::Extrapolated => {
            let carried = |arrays: &ParticleArrays<R, D>, row: usize| carried(scene, time, arrays, row);
            extrapolate_wall_pressure(&pair.0, &grid.0, &mut arrays, &mut sums.0, &carried);
        }
        WallPressure::Mirrored => find_body_force(scene, time, &arrays, &mut sums.0.body_force),
    }
    if scene.walls.model == WallModel::Dummy {
        let level = since_correction.map_or(VelocityLevel::Present, |since| since.time_level());
        find_velocity_seen(&pair.0, &grid.0, &arrays, level, &mut sums.0);
    }
}

/// What carries the pressure of the fluid into a wall row: g − a_wall, m/s², Adami et al. (2012), Eq. 27.
///
/// Their a_wall is that of the fluid at the surface, held there by the pressure. Along the surface it is friction that takes the fluid with it, and
/// where it slips it does not move with the wall: so a_wall is what a no-slip surface has of it along its normal.
fn carried<R: Real, const D: usize>(
    scene: &Scene,
    time: f64,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> [f64; D] {
    let place = arrays.position_of(row);
    let mut force = body_force(&scene.body_force, place, time);
    let part = &scene.walls.parts[usize::from(arrays.patch[row])];
    if part.slip == Slip::NoSlip && part.moves() {
        let normal = real_vector(&arrays.wall_normal, row);
        let surface = place + normal * arrays.wall_distance[row].to_f64();
        force -= normal * part.turning_at(surface, time, scene.spacing).dot(normal);
    }
    std::array::from_fn(|axis| force[axis])
}

/// Body force of the fluid rows, m/s², where it is an expression; else the columns stay empty.
fn find_body_force<R: Real, const D: usize>(
    scene: &Scene,
    time: f64,
    arrays: &ParticleArrays<R, D>,
    columns: &mut [Vec<R>; D],
) {
    if matches!(scene.body_force, BodyForce::Constant(_)) {
        return;
    }
    for column in columns.iter_mut() {
        column.resize(arrays.len(), R::default());
    }
    let work = |rows: Range<usize>, columns: [&mut [R]; D]| {
        for (at, row) in rows.enumerate() {
            if arrays.zone[row] == Zone::Fluid {
                let force = body_force(&scene.body_force, arrays.position_of(row), time);
                for axis in 0..D {
                    columns[axis][at] = R::from_f64(force[axis]);
                }
            }
        }
    };
    for_each_part(0..arrays.len(), columns.each_mut().map(Vec::as_mut_slice), &work);
}

/// Velocities, present and before, of a part's rows.
type Columns<'a, R, const D: usize> = ([&'a mut [R]; D], [&'a mut [R]; D]);
