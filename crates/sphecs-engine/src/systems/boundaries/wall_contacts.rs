//! Forces on bodies by the particles that a step moved back to their surfaces.
//!
//! ```text
//! F = Σ m Δv/Δt,   T = Σ (x − c) × m Δv/Δt
//! ```
//!
//! Δv is the velocity into the wall that a [moved](super::wall_projection) fluid particle lost, Δt
//! the size of the step. The forces belong to those of the next step, so that the body gains in all
//! what the fluid loses.

use bevy_ecs::resource::Resource;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use sphecs_core::pass::body::{BodySum, ExactBodySum};
use sphecs_core::pass::ranks::Ranks;
use sphecs_scene::model::Scene;
use sphecs_scene::movers::{Wall, WallPoses};
use sphecs_scene::wall_particles::surface;

/// A fluid particle that was moved back to a wall.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WallContact {
    /// Wall.
    pub wall: Wall,
    /// Position of the particle behind it, m.
    pub point: DVec3,
    /// Velocity that the particle lost, m/s.
    pub lost: DVec3,
}

/// Forces on the bodies of the scene by the contacts of the last step.
#[derive(Resource, Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WallContacts {
    /// Force, N, and torque, N m, on each body (per metre of depth in 2D); empty without contacts.
    forces: Vec<[DVec3; 2]>,
    /// Contacts of the step; kept for their memory.
    #[serde(skip)]
    pub(super) found: Vec<WallContact>,
    /// Number of fluid particles that the step moved back to a wall.
    #[serde(skip)]
    pub(super) moved: u64,
}

impl WallContacts {
    /// Sums the contacts found in a step of size `time_step`, s, by all ranks, of which any found
    /// some. Their order does not matter.
    pub(super) fn sum(&mut self, scene: &Scene, poses: &WallPoses, time_step: f64, ranks: &Ranks) {
        self.forces.clear();
        let rate = scene.discretisation.mass / time_step;
        let mut sums: Vec<ExactBodySum> = scene
            .bodies
            .iter()
            .map(|body| {
                let wall = Wall::of_part(scene, body.part);
                let pose = scene.pose_of_part(poses, body.part);
                let about = pose.map_or(body.about, |pose| pose.place(body.about));
                let mut sum = ExactBodySum::default();
                for contact in self.found.iter().filter(|contact| contact.wall == wall) {
                    let reference = || pose.map_or(contact.point, |pose| pose.reference(contact.point));
                    if wall == Wall::Casing && surface(scene, wall, reference()).part != body.part {
                        continue;
                    }
                    let force = rate * contact.lost;
                    let arm = scene.image_at_wall(poses, body.part, contact.point) - about;
                    let pressure_torque = arm.cross(force);
                    sum += &BodySum { pressure_force: force, pressure_torque, ..BodySum::default() };
                }
                sum
            })
            .collect();
        ExactBodySum::join_all(&mut sums, ranks);
        let values = sums.iter().map(ExactBodySum::value);
        self.forces.extend(values.map(|sum| [sum.pressure_force, sum.pressure_torque]));
        self.found.clear();
    }

    /// Forgets the contacts of the step before.
    pub(super) fn clear(&mut self) {
        self.forces.clear();
    }

    /// Adds the force on a body, by its index in the scene.
    pub(crate) fn add(&self, body: usize, sum: &mut BodySum) {
        if let Some([force, torque]) = self.forces.get(body) {
            sum.pressure_force += *force;
            sum.pressure_torque += *torque;
        }
    }
}
