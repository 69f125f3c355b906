//! Plugins: what a simulation is made of.

use bevy_ecs::resource::Resource;
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::{FromWorld, World};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::checkpoint::Kept;

/// A world and its schedules while a simulation is being built.
pub struct Parts<'a> {
    /// The world, with the resources of the scene.
    pub world: &'a mut World,
    /// One time step.
    pub step: &'a mut Schedule,
    /// One evaluation of the rates.
    pub stage: &'a mut Schedule,
}

impl Parts<'_> {
    /// Inserts a resource and makes it part of the state that a checkpoint keeps, under a name that no other has.
    ///
    /// # Panics
    /// If another resource has the name.
    pub fn keep<T: Resource + FromWorld + Serialize + DeserializeOwned>(&mut self, name: &'static str) {
        self.world.init_resource::<T>();
        self.world.get_resource_or_init::<Kept>().add::<T>(name);
    }
}

/// A part of a simulation: owns its resources and puts its systems into sets.
pub trait Plugin {
    /// Inserts resources and adds systems. What a later step depends on is inserted by [`Parts::keep`], or a restart would forget it. The particles come into the world when all plugins are built.
    fn build(&self, parts: &mut Parts<'_>);
}
