//! Plugins: what a simulation is made of.

use bevy_ecs::schedule::Schedule;
use bevy_ecs::world::World;

/// A world and its schedules while a simulation is being built.
pub struct Parts<'a> {
    /// The world, with the resources of the scene.
    pub world: &'a mut World,
    /// One time step.
    pub step: &'a mut Schedule,
    /// One evaluation of the rates.
    pub stage: &'a mut Schedule,
}

/// A part of a simulation: owns its resources and puts its systems into sets.
pub trait Plugin {
    /// Inserts resources and adds systems. The particles come into the world when all plugins are built.
    fn build(&self, parts: &mut Parts<'_>);
}
