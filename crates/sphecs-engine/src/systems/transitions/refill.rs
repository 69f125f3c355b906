//! Injections at the far end of an outflow zone that wait for a free position.
//!
//! Through an opening that a pressure drives fluid may enter for good. Particles of the zone are
//! disordered, so that the position behind the one that entered may be taken. If the injection
//! were omitted, the zone would thin out: 9 % in 6 s of a channel of 1 cm under `EdacTvf`. It is
//! made up for as soon as its position is free, unless the zone has filled up meanwhile because
//! the flow turned.

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use serde::{Deserialize, Serialize};

use super::injection::{Injection, is_free, place};
use crate::resources::grid::Grid;
use crate::systems::boundaries::outlets::Outlets;
use crate::systems::boundaries::patch_rows::PatchRows;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Smallest distance, over the spacing, from an injected particle to the others: that of a line
/// whose spacing disorder has shortened.
const MIN_DISTANCE: f64 = 0.8;

/// Injections that wait, and the particles that each outflow zone had at the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WaitingInjections {
    /// Particles of each outflow zone at the start.
    pub capacity: Vec<u64>,
    /// Injections, the oldest first.
    pub waiting: Vec<Injection>,
}

/// Lets an injection wait that found its position taken, where fluid may enter for good.
pub(super) fn defer<R: PairReal<D>, const D: usize>(world: &mut World, injection: Injection) {
    let outlet = usize::from(injection.patch);
    let enters = |world: &World| world.resource::<Outlets<R, D>>().needs()[outlet].is_bidirectional;
    if injection.zone == Zone::Outflow && enters(world) {
        world.resource_mut::<WaitingInjections>().waiting.push(injection);
    }
}

/// Makes the injections whose position is free now, and drops those into zones that are full.
pub(super) fn refill<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
) {
    if world.resource::<WaitingInjections>().waiting.is_empty() {
        return;
    }
    let WaitingInjections { capacity, mut waiting } =
        std::mem::take(&mut *world.resource_mut::<WaitingInjections>());
    waiting.retain(|injection| {
        let outlet = usize::from(injection.patch);
        if present(world, arrays, outlet) >= capacity[outlet] {
            return false;
        }
        // A place that left the zone sideways, or the far end moving on, does not matter: the end
        // of the zone is fixed.
        let patch = &scene.outlets[outlet].patch;
        let at = injection.place + patch.towards * (patch.depth - patch.along(injection.place));
        let free = is_free(world, arrays, at, MIN_DISTANCE * scene.spacing);
        if free {
            place(world, scene, arrays, &Injection { place: at, ..*injection });
        }
        !free
    });
    *world.resource_mut::<WaitingInjections>() = WaitingInjections { capacity, waiting };
}

/// Returns the present number of particles of an outflow zone.
fn present<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    outlet: usize,
) -> u64 {
    let sorted = world.resource::<Grid<D>>().0.starts().last().map_or(0, |&end| end as usize);
    let rows = world.resource::<PatchRows>().outflow[outlet].iter().map(|&row| row as usize);
    let is_of_zone =
        |&row: &usize| arrays.zone[row] == Zone::Outflow && usize::from(arrays.patch[row]) == outlet;
    // A particle that left the fluid in this step is counted from the next sort on.
    rows.chain(sorted..arrays.len()).filter(is_of_zone).count() as u64
}
