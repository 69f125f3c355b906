//! Which home of the state is fresh: the components or the arrays.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;

use super::rates::Sums;
use crate::arrays::Arrays;
use crate::transfer;
use sphecs_core::math::real::Real;

/// Which home of the state is fresh.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum FreshHome {
    /// A caller changed components, or the world has just been made.
    #[default]
    Components,
    /// A step has changed the arrays.
    Arrays,
    /// Both hold the same state.
    Both,
}

/// Fills the arrays if the components are fresher; a system of [`StepSystems::Gather`](super::schedule::StepSystems).
pub fn gather<R: Real, const D: usize>(world: &mut World) {
    if *world.resource::<FreshHome>() == FreshHome::Components {
        world.resource_scope(|world, mut arrays: Mut<Arrays<R, D>>| transfer::gather(world, &mut arrays));
    }
    world.insert_resource(FreshHome::Arrays);
}

/// Brings the components up to date if the arrays are fresher.
pub fn scatter<R: Real, const D: usize>(world: &mut World) {
    if *world.resource::<FreshHome>() == FreshHome::Arrays {
        world.resource_scope(|world, arrays: Mut<Arrays<R, D>>| {
            transfer::scatter(world, &arrays);
            world.resource_scope(|world, sums: Mut<Sums<R, D>>| {
                transfer::scatter_stress(world, &arrays.id, &sums.0.stress);
            });
        });
        world.insert_resource(FreshHome::Both);
    }
}
