//! Injections at the far end of a zone that wait for a free position.
//!
//! Particles of a zone that came from the fluid are disordered, so that the position behind one
//! that entered the fluid may be taken. If the injection were omitted, the zone would thin out, and
//! with it the fluid: the outflow zone by 9 % in 6 s of a channel of 1 cm that a pressure drives,
//! and by 20 % in six periods of a channel whose inflow turns back, both under `EdacTvf`. It is
//! made up for as soon as its position is free, unless the zone has filled up meanwhile because
//! the flow turned.

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use serde::{Deserialize, Serialize};

use super::injection::{Injection, is_free, place};
use crate::resources::grid::Grid;
use crate::resources::ledger::InflowCapacity;
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

/// Lets an injection wait that found its position taken, unless the condition of its outlet expects
/// no backflow.
pub(super) fn defer<R: PairReal<D>, const D: usize>(world: &mut World, injection: Injection) {
    let is_one_way = |world: &World| {
        let needs = world.resource::<Outlets<R, D>>().needs();
        injection.zone == Zone::Outflow && needs[usize::from(injection.patch)].is_one_way
    };
    if !is_one_way(world) {
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
        let patch = usize::from(injection.patch);
        let (opening, full, end) = if injection.zone == Zone::Inflow {
            let opening = &scene.inlets[patch].patch;
            (opening, world.resource::<InflowCapacity>().0[patch], -opening.depth)
        } else {
            let opening = &scene.outlets[patch].patch;
            (opening, capacity[patch], opening.depth)
        };
        if present(world, arrays, injection) >= full {
            return false;
        }
        // The zone has moved since, but not its far end.
        let at = injection.place + opening.towards * (end - opening.along(injection.place));
        let free = is_free(world, arrays, at, MIN_DISTANCE * scene.spacing);
        if free {
            place(world, scene, arrays, &Injection { place: at, ..*injection });
        }
        !free
    });
    *world.resource_mut::<WaitingInjections>() = WaitingInjections { capacity, waiting };
}

/// Returns the present number of particles of the zone of an injection.
fn present<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    injection: &Injection,
) -> u64 {
    let sorted = world.resource::<Grid<D>>().0.starts().last().map_or(0, |&end| end as usize);
    let rows = world.resource::<PatchRows>();
    let of_zone = if injection.zone == Zone::Inflow { &rows.inflow } else { &rows.outflow };
    let rows = of_zone[usize::from(injection.patch)].iter().map(|&row| row as usize);
    let is_of_zone = |&row: &usize| {
        let (zone, patch) = (arrays.zone[row], arrays.patch[row]);
        (zone, patch) == (injection.zone, injection.patch)
    };
    // A particle that left the fluid in this step is counted from the next sort on.
    rows.chain(sorted..arrays.len()).filter(is_of_zone).count() as u64
}
