//! Velocity and pressure of wall particles.
//!
//! A wall particle has the velocity of the surface point in front of it, x_w + d_w n. The velocity
//! at its own position would be too low inside a turning cylinder, in proportion to the depth, and
//! the fluid would see a surface that lags.

use std::ops::Range;

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use crate::systems::boundaries::movers::PresentPoses;
use crate::systems::forces::body_force;
use bevy_ecs::system::{Res, ResMut};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, vector};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::rates::TimeLevel;
use sphecs_core::physics::wall::{Slip, WallPressure};
use sphecs_scene::model::{BodyForce, Scene, WallPart};
use sphecs_scene::movers::WallPoses;

/// Sets the velocity of moving walls, and pressure and velocity of wall particles from the flow
/// next to them, as the wall model requires.
pub fn apply_walls<R: PairReal<D>, const D: usize>(
    (scene, poses): (Res<ActiveScene>, Res<PresentPoses>),
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Option<Res<StepsSinceCorrection>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let (scene, poses) = (&*scene.0, &poses.0);
    let time = clock.time;
    if scene.walls.parts.iter().any(WallPart::moves) {
        set_surface_velocity(&scene.walls.parts, time, &mut arrays);
    }
    match scene.walls.model.pressure() {
        WallPressure::Extrapolated => {
            let carried =
                |arrays: &ParticleArrays<R, D>, row: usize| carried((scene, poses), time, arrays, row);
            R::extrapolate_wall_pressure(&pair.0, &grid.0, &mut arrays, &mut sums.0, &carried);
        }
        WallPressure::Mirrored => find_body_force(scene, time, &arrays, &mut sums.0.body_force),
    }
    find_dummy_velocity(pair, grid, since_correction, sums, arrays.into());
}

/// Finds the velocities of dummy walls in the viscous term, in the present order of the particles.
/// Does nothing under other wall models.
pub(crate) fn find_dummy_velocity<R: PairReal<D>, const D: usize>(
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Option<Res<StepsSinceCorrection>>,
    mut sums: ResMut<Sums<R, D>>,
    arrays: Res<Arrays<R, D>>,
) {
    if pair.0.wall_model.sees_kernel_mean() {
        let level = since_correction.map_or(TimeLevel::Present, |since| since.time_level());
        R::find_velocity_seen(&pair.0, &grid.0, &arrays, level, &mut sums.0);
    }
}

/// Sets the velocity of the particles of moving wall parts to that of the surface in front of them.
fn set_surface_velocity<R: PairReal<D>, const D: usize>(
    parts: &[WallPart],
    time: f64,
    arrays: &mut ParticleArrays<R, D>,
) {
    let ParticleArrays {
        zone, patch, position, velocity, previous_velocity, wall_distance, wall_normal, ..
    } = arrays;
    let (zone, patch, position) = (&*zone, &*patch, &*position);
    let (wall_distance, wall_normal) = (&*wall_distance, &*wall_normal);
    let work = |rows: Range<usize>, (velocity, before): RowColumns<R, D>| {
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
        (velocity.each_mut().map(Vec::as_mut_slice), previous_velocity.each_mut().map(Vec::as_mut_slice));
    for_each_part(0..zone.len(), columns, &work);
}

/// Returns the acceleration g − a_wall that extrapolates the pressure of the fluid to a wall row,
/// m/s²: Adami et al. (2012), Eq. 27.
///
/// Their a_wall is the acceleration of the fluid at the surface, caused by the pressure. Along the
/// surface the fluid is accelerated by friction, and where it slips it does not move with the wall.
/// So a_wall is the normal part of the acceleration of a no-slip surface, and of any wall that
/// changes its place.
fn carried<R: PairReal<D>, const D: usize>(
    (scene, poses): (&Scene, &WallPoses),
    time: f64,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> [f64; D] {
    let place = arrays.position_of(row);
    let mut force = body_force(&scene.body_force, place, time);
    let part = &scene.walls.parts[usize::from(arrays.patch[row])];
    if let Some(pose) = scene.pose_of_part(poses, arrays.patch[row]) {
        let normal = real_vector(&arrays.wall_normal, row);
        let place = scene.image_at_wall(poses, arrays.patch[row], place);
        let surface = place + normal * arrays.wall_distance[row].to_f64();
        force -= normal * pose.acceleration_at(surface).dot(normal);
    } else if part.slip == Slip::NoSlip && part.moves() {
        let normal = real_vector(&arrays.wall_normal, row);
        let surface = place + normal * arrays.wall_distance[row].to_f64();
        force -= normal * part.convective_acceleration_at(surface, time, scene.spacing).dot(normal);
    }
    std::array::from_fn(|axis| force[axis])
}

/// Finds the body force of the fluid rows, m/s², where it is an expression; else the columns stay
/// empty.
fn find_body_force<R: PairReal<D>, const D: usize>(
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

/// Velocities, present and previous, of the rows of a part.
type RowColumns<'a, R, const D: usize> = ([&'a mut [R]; D], [&'a mut [R]; D]);
