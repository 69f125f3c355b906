//! Plugins, of which a simulation is composed.
//!
//! - `builtin`: the plugins that every simulation has

pub(crate) mod builtin;

use bevy_ecs::resource::Resource;
use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::{FromWorld, World};
use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::saved_state::SavedResources;
use crate::systems::boundaries::outlet_registry::AddedOutlets;
use sphecs_core::boundary::outlet::method::OutletMethod;

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

    /// Adds an outlet condition that a scene names as `condition: Custom("name")`.
    ///
    /// Its memory is part of the state that checkpoints contain. A resumed run needs the same
    /// plugin.
    ///
    /// # Panics
    /// If another condition has the name.
    pub fn add_outlet<M: OutletMethod>(&mut self, name: &str, method: M) {
        self.world.get_resource_or_init::<AddedOutlets>().add(name, method);
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

impl Plugin for Box<dyn Plugin + Send> {
    fn build(&self, context: &mut PluginContext<'_>) {
        (**self).build(context);
    }
}
