//! Walls that move: their particles follow the pose of their wall.
//!
//! ```text
//! x = R X + o,   v = v_o + ω × (x_s − o),   n = R N,   x_s = R (X + d N) + o
//! ```
//!
//! X and N are position and normal in reference coordinates, d is the distance behind the surface.
//! A particle has the velocity of the surface point x_s in front of it, as all wall particles. The
//! pose is a function of time alone, so positions do not drift, and are bitwise identical in a
//! resumed run.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut, SystemParam};
use bevy_ecs::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::resources::clock::Clock;
use crate::resources::scene::ActiveScene;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::pose::Pose;
use sphecs_scene::model::{ParticleSeed, Scene};
use sphecs_scene::movers::WallPoses;

/// Particles of the walls that move, in reference coordinates.
///
/// Their numbers follow each other: they are the last of the wall particles.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MoverParticles {
    /// Number of the first one.
    first: u32,
    /// Positions X, m.
    position: Vec<DVec3>,
    /// Unit normals N, into the fluid.
    normal: Vec<DVec3>,
    /// Distances d behind the surface, m.
    distance: Vec<f64>,
}

impl MoverParticles {
    /// Returns the particles of a scene whose seeds are given in the order of their numbers.
    pub(crate) fn new(scene: &Scene, seeds: &[ParticleSeed]) -> Self {
        let poses = scene.wall_poses(0.0);
        let mut particles = Self::default();
        for (id, seed) in seeds.iter().enumerate().filter(|(_, seed)| seed.zone == Zone::Wall) {
            let Some(pose) = scene.pose_of_part(&poses, seed.patch) else { continue };
            if particles.position.is_empty() {
                particles.first = id as u32;
            }
            particles.position.push(pose.reference(seed.position));
            particles.normal.push(pose.reference_direction(seed.wall_normal));
            particles.distance.push(seed.wall_distance);
        }
        particles
    }

    /// Returns the numbers of the particles.
    pub fn numbers(&self) -> Range<u32> {
        self.first..self.first + self.position.len() as u32
    }

    /// Returns the index of the particle with a number.
    fn index(&self, id: u32) -> Option<usize> {
        id.checked_sub(self.first).map(|index| index as usize).filter(|index| *index < self.position.len())
    }
}

/// Poses of the walls that move at the time of the particles.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct PresentPoses(pub WallPoses);

/// Motion of the walls, in a scene that has any.
#[derive(SystemParam)]
pub(crate) struct WallMotion<'w> {
    particles: Option<Res<'w, MoverParticles>>,
    poses: ResMut<'w, PresentPoses>,
}

impl WallMotion<'_> {
    /// Returns the poses at the time of the particles.
    pub(crate) fn poses(&self) -> &WallPoses {
        &self.poses.0
    }

    /// Moves the walls to their pose at a time, s.
    pub(crate) fn finish_step<R: PairReal<D>, const D: usize>(
        &mut self,
        scene: &Scene,
        time: f64,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        if let Some(particles) = &self.particles {
            self.poses.0 = scene.wall_poses(time);
            place(scene, particles, &self.poses.0, arrays);
        }
    }
}

/// Finds the poses of a new world at its present time.
pub(crate) fn find_poses(world: &mut World) {
    let time = world.resource::<Clock>().time;
    let poses = world.resource::<ActiveScene>().0.wall_poses(time);
    world.insert_resource(PresentPoses(poses));
}

/// Sets the normals of walls that move in the arrays; components keep those of the start.
pub(crate) fn orient<R: PairReal<D>, const D: usize>(world: &World, arrays: &mut ParticleArrays<R, D>) {
    let Some(particles) = world.get_resource::<MoverParticles>() else { return };
    let (scene, poses) = (&world.resource::<ActiveScene>().0, &world.resource::<PresentPoses>().0);
    for row in 0..arrays.len() {
        if arrays.zone[row] == Zone::Wall
            && let Some(index) = particles.index(arrays.id[row])
            && let Some(pose) = scene.pose_of_part(poses, arrays.patch[row])
        {
            let normal = pose.direction(particles.normal[index]);
            for axis in 0..D {
                arrays.wall_normal[axis][row] = R::from_f64(normal[axis]);
            }
        }
    }
}

/// Sets positions, velocities and normals of the particles of walls that move.
fn place<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    particles: &MoverParticles,
    poses: &WallPoses,
    arrays: &mut ParticleArrays<R, D>,
) {
    let ParticleArrays { id, zone, patch, position, velocity, previous_velocity, wall_normal, .. } = arrays;
    let (id, zone, patch) = (&*id, &*zone, &*patch);
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        velocity.each_mut().map(Vec::as_mut_slice),
        previous_velocity.each_mut().map(Vec::as_mut_slice),
        wall_normal.each_mut().map(Vec::as_mut_slice),
    );
    let work = |rows: Range<usize>, (position, velocity, before, normal): RowColumns<R, D>| {
        for (at, row) in rows.enumerate() {
            if zone[row] != Zone::Wall {
                continue;
            }
            let (Some(index), Some(pose)) = (particles.index(id[row]), scene.pose_of_part(poses, patch[row]))
            else {
                continue;
            };
            let placed = Placed::new(particles, index, pose);
            let inside = scene.wrapped(placed.position);
            for axis in 0..D {
                position[axis][at] = inside[axis];
                before[axis][at] = velocity[axis][at];
                velocity[axis][at] = R::from_f64(placed.velocity[axis]);
                normal[axis][at] = R::from_f64(placed.normal[axis]);
            }
        }
    };
    for_each_part(0..zone.len(), columns, &work);
}

/// Positions; velocities, present and previous; normals of the rows of a part.
type RowColumns<'a, R, const D: usize> =
    ([&'a mut [f64]; D], [&'a mut [R]; D], [&'a mut [R]; D], [&'a mut [R]; D]);

/// State of a particle in a pose.
struct Placed {
    position: DVec3,
    velocity: DVec3,
    normal: DVec3,
}

impl Placed {
    fn new(particles: &MoverParticles, index: usize, pose: &Pose) -> Self {
        let (reference, normal) = (particles.position[index], particles.normal[index]);
        let surface = pose.place(reference + particles.distance[index] * normal);
        Self {
            position: pose.place(reference),
            velocity: pose.velocity_at(surface),
            normal: pose.direction(normal),
        }
    }
}
