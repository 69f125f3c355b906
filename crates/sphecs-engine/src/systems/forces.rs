//! Body force of the scene, and forces that a user adds.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::scene::ActiveScene;
use crate::systems::force_fields::{FluidBuffers, FluidState, ForceField};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::BodyForce;

/// Forces per mass that plugins add; each is evaluated for every fluid particle in every stage.
///
/// ```
/// use glam::DVec3;
/// use sphecs_engine::systems::forces::{AddedForces, ParticleState};
///
/// let mut forces = AddedForces::default();
/// // A spring towards the plane y = 0 with a stiffness per mass of 2 1/s².
/// forces.add(|particle: &ParticleState| DVec3::new(0.0, -2.0 * particle.position.y, 0.0));
/// ```
///
/// A force that is computed for whole columns is added by [`AddedForces::add_field`].
#[derive(Resource, Default)]
pub struct AddedForces {
    forces: Vec<Box<AddedForce>>,
    fields: Vec<Box<ForceField>>,
}

/// Force per mass, m/s², as a function of the state of a particle.
type AddedForce = dyn Fn(&ParticleState) -> DVec3 + Send + Sync;

/// State of a particle on which an added force may depend.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub struct ParticleState {
    /// Number of the particle.
    pub id: u32,
    /// Time, s.
    pub time: f64,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

impl AddedForces {
    /// Adds a force per mass, m/s². It must be a pure function of the particle's state: it is
    /// called from several threads in no fixed order.
    pub fn add(&mut self, force: impl Fn(&ParticleState) -> DVec3 + Send + Sync + 'static) {
        self.forces.push(Box::new(force));
    }

    /// Adds a function that adds forces per mass, m/s², to the entries of all fluid particles.
    ///
    /// It is called once in every stage. Each entry must be a pure function of the state: the order
    /// of the particles changes from step to step.
    ///
    /// ```
    /// use glam::DVec3;
    /// use sphecs_engine::systems::force_fields::FluidState;
    /// use sphecs_engine::systems::forces::AddedForces;
    ///
    /// let mut forces = AddedForces::default();
    /// // A drag with a rate of 2 1/s.
    /// forces.add_field(|fluid: &FluidState<'_>, force: &mut [DVec3]| {
    ///     for (force, velocity) in force.iter_mut().zip(fluid.velocity) {
    ///         *force -= 2.0 * velocity;
    ///     }
    /// });
    /// ```
    pub fn add_field(&mut self, field: impl Fn(&FluidState<'_>, &mut [DVec3]) + Send + Sync + 'static) {
        self.fields.push(Box::new(field));
    }

    fn is_empty(&self) -> bool {
        self.forces.is_empty() && self.fields.is_empty()
    }
}

/// Returns the body force per mass, m/s², at a position, m, and time, s.
pub(crate) fn body_force(force: &BodyForce, position: DVec3, time: f64) -> DVec3 {
    match force {
        BodyForce::Constant(force) => *force,
        BodyForce::Expression(components) => {
            let at = |axis: usize| components[axis].value(position.x, position.y, position.z, time);
            DVec3::new(at(0), at(1), at(2))
        }
    }
}

/// Adds the body force and the added forces to the accelerations of fluid particles. That on
/// outflow particles depends on their pressure:
/// [`outlet_balance`](super::boundaries::outlet_balance).
pub(crate) fn add_forces<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    added: Res<AddedForces>,
    mut buffers: Local<FluidBuffers>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let force = &scene.0.body_force;
    if added.is_empty() && matches!(force, BodyForce::Constant(force) if *force == DVec3::ZERO) {
        return;
    }
    let time = clock.time;
    let mut acceleration = std::mem::replace(&mut arrays.acceleration, std::array::from_fn(|_| Vec::new()));
    let state = &**arrays;
    let work = |rows: Range<usize>, acceleration: [&mut [R]; D]| {
        for (at, row) in rows.enumerate() {
            if state.zone[row] != Zone::Fluid {
                continue;
            }
            let position = state.position_of(row);
            let mut sum = body_force(force, position, time);
            if !added.forces.is_empty() {
                let state = ParticleState {
                    id: state.id[row],
                    time,
                    position,
                    velocity: state.velocity_of(row),
                    density: state.density[row].to_f64(),
                    pressure: state.pressure[row].to_f64(),
                };
                sum += added.forces.iter().map(|force| force(&state)).sum::<DVec3>();
            }
            for axis in 0..D {
                acceleration[axis][at] += R::from_f64(sum[axis]);
            }
        }
    };
    for_each_part(0..state.len(), acceleration.each_mut().map(Vec::as_mut_slice), &work);
    if !added.fields.is_empty() {
        buffers.evaluate(&arrays, time, &added.fields);
        buffers.add_to(&mut acceleration);
    }
    arrays.acceleration = acceleration;
}
