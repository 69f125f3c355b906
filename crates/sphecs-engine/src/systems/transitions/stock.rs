//! Where particles that leave go to, and where those that enter come from.
//!
//! ```text
//! recycle: true    Outflow → Reservoir → Inflow, as in Alvarado-Rodríguez et al. (2017), Fig. 1; an empty reservoir grows or stops
//! recycle: false   what leaves is deleted, what enters is created, as in Negi et al. (2020), Sec. 3.4; numbers are given anew
//! ```
//!
//! The ledger balances in both: total = initial + grown + created − deleted.

use bevy_ecs::bundle::Bundle;
use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::components::{ParticleId, Position, Reservoir, SpsStress, Thermodynamics, Tracer, Velocity};
use crate::systems::failure::Failure;
use crate::systems::ledger::Ledger;
use crate::systems::setup::{Seats, Stored};
use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::{Scene, WhenEmpty};

/// Numbers of deleted particles, to be given anew; the last is taken first.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct FreeNumbers(pub Vec<FreeNumber>);

/// A number that no particle has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FreeNumber {
    /// The number.
    pub id: u32,
    /// Passages that the particles of this number made.
    pub passages: u32,
}

/// State of a particle at rest in the reservoir, but for what it keeps: tag and passages.
fn stored(scene: &Scene, id: u32, position: DVec3) -> impl Bundle {
    (
        ParticleId(id),
        Position(position),
        Velocity(DVec3::ZERO),
        Thermodynamics { density: scene.fluid.density, pressure: 0.0 },
    )
}

/// Stores a particle that left its last zone at a point (m), or deletes it.
pub(super) fn leave(world: &mut World, scene: &Scene, id: u32, point: DVec3) {
    let seat = world.resource::<Seats>().0[id as usize];
    if !scene.reservoir.recycle {
        let passages = world.get::<Tracer>(seat).map_or(0, |tracer| tracer.passages);
        world.despawn(seat);
        world.resource_mut::<Seats>().0[id as usize] = Entity::PLACEHOLDER;
        world.resource_mut::<FreeNumbers>().0.push(FreeNumber { id, passages });
        let mut ledger = world.resource_mut::<Ledger>();
        ledger.deleted += 1;
        ledger.by_zone[Zone::Reservoir as usize] -= 1;
        return;
    }
    let mut entity = world.entity_mut(seat);
    // The arrays drop the row at the next sort. What its components still hold depends on who looked last.
    entity.insert((stored(scene, id, point), Reservoir));
    if let Some(mut stress) = entity.get_mut::<SpsStress>() {
        *stress = SpsStress::default();
    }
    world.resource_mut::<Stored>().0.push(id);
}

/// The number of a particle to enter: a stored one, or a new one where there is no reservoir or an empty one may grow. It is in the reservoir
/// until it has entered.
pub(super) fn take(world: &mut World, scene: &Scene) -> Option<u32> {
    if let Some(id) = world.resource_mut::<Stored>().0.pop() {
        return Some(id);
    }
    if scene.reservoir.recycle && scene.reservoir.when_empty == WhenEmpty::Stop {
        world.resource_mut::<Failure>().reservoir_empty = true;
        return None;
    }
    let next = FreeNumber { id: world.resource::<Seats>().0.len() as u32, passages: 0 };
    let FreeNumber { id, passages } = world.resource_mut::<FreeNumbers>().0.pop().unwrap_or(next);
    let tracer = Tracer { passages, ..Tracer::default() };
    let mut entity = world.spawn((stored(scene, id, DVec3::ZERO), tracer, Reservoir));
    if scene.scheme.has_stress() {
        entity.insert(SpsStress::default());
    }
    let entity = entity.id();
    let seats = &mut world.resource_mut::<Seats>().0;
    match seats.get_mut(id as usize) {
        Some(seat) => *seat = entity,
        None => seats.push(entity),
    }
    let mut ledger = world.resource_mut::<Ledger>();
    if scene.reservoir.recycle {
        ledger.grown += 1;
    } else {
        ledger.created += 1;
    }
    ledger.by_zone[Zone::Reservoir as usize] += 1;
    Some(id)
}
