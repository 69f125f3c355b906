//! Location of the current particle state: components, arrays or both.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;

use super::pair_sums::Sums;
use crate::arrays::Arrays;
use crate::systems::boundaries::movers::orient;
use crate::transfer;
use sphecs_core::pass::column_access::AfterPasses;
use sphecs_core::pass::pair_real::PairReal;

/// Location of the current particle state.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum StateLocation {
    /// The components: a caller changed them, or the world has just been created.
    #[default]
    Components,
    /// The arrays: a step changed them.
    Arrays,
    /// Components and arrays agree.
    Both,
}

/// Fills the arrays if the components are current; a system of
/// [`StepSet::Gather`](crate::schedule::StepSet).
pub fn gather<R: PairReal<D>, const D: usize>(world: &mut World) {
    if *world.resource::<StateLocation>() == StateLocation::Components {
        world.resource_scope(|world, mut arrays: Mut<Arrays<R, D>>| {
            transfer::gather(world, &mut arrays);
            orient(world, &mut arrays);
        });
    }
    world.insert_resource(StateLocation::Arrays);
}

/// Updates the components if the arrays are current.
pub fn scatter<R: PairReal<D>, const D: usize>(world: &mut World) {
    if *world.resource::<StateLocation>() == StateLocation::Arrays {
        world.resource_scope(|world, arrays: Mut<Arrays<R, D>>| {
            transfer::scatter(world, &arrays);
            world.resource_scope(|world, sums: Mut<Sums<R, D>>| {
                transfer::scatter_stress(world, &arrays.id, sums.0.stress.read(AfterPasses));
            });
        });
        world.insert_resource(StateLocation::Both);
    }
}
