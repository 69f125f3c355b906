//! Plugins, of which a simulation is composed.
//!
//! - [`builtin`]: the plugins that every simulation has

pub mod builtin;

use bevy_ecs::resource::Resource;
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::{FromWorld, World};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::saved_state::SavedResources;

/// World and schedules of a simulation that is being built.
pub struct PluginContext<'a> {
    /// World with the resources of the scene, but without particles.
    pub world: &'a mut World,
    /// Schedule of one time step.
    pub step: &'a mut Schedule,
    /// Schedule of one evaluation of the rates.
    pub stage: &'a mut Schedule,
}

impl PluginContext<'_> {
    /// Inserts a resource and adds it to the state that checkpoints contain, under a unique name.
    ///
    /// # Panics
    /// If another resource has the name.
    pub fn save_resource<T: Resource + FromWorld + Serialize + DeserializeOwned>(
        &mut self,
        name: &'static str,
    ) {
        self.world.init_resource::<T>();
        self.world.get_resource_or_init::<SavedResources>().add::<T>(name);
    }
}

/// Part of a simulation: inserts its resources and adds its systems to sets.
pub trait Plugin {
    /// Inserts resources and adds systems. The particles are spawned after all plugins are built.
    ///
    /// A resource that later steps depend on is inserted by [`PluginContext::save_resource`]; a
    /// resumed run would otherwise start without its value.
    fn build(&self, context: &mut PluginContext<'_>);
}
