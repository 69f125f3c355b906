//! Reservoir: storage or deletion of outflowing particles, reuse or creation of injected ones.
//!
//! ```text
//! recycle: true    Outflow → Reservoir → Inflow, as in Alvarado-Rodríguez et al. (2017), Fig. 1;
//!                  an empty reservoir grows or stops the run
//! recycle: false   outflowing particles are deleted, injected ones created, as in
//!                  Negi et al. (2020), Sec. 3.4; the numbers of deleted particles are reused
//! ```
//!
//! The counts balance in both cases: total = initial + grown + created − deleted.

use bevy_ecs::bundle::Bundle;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::components::{ParticleId, Position, Reservoir, SpsStress, Tracer, Velocity};
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::ledger::Ledger;
use crate::resources::particle_details::{ParticleDetails, StoredParticle};
use crate::systems::divergence::Failure;
use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::{Scene, WhenEmpty};

/// Numbers of deleted particles, which are reused; the last one first.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(crate) struct FreeNumbers(pub Vec<FreeNumber>);

/// Number that no particle has.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FreeNumber {
    /// Number.
    pub id: u32,
    /// Number of injections of particles with this number.
    pub passages: u32,
}

/// Returns the components of a particle at rest in the reservoir, except those that it keeps: tag
/// and passages.
fn stored_bundle(scene: &Scene, id: u32, position: DVec3) -> impl Bundle {
    (
        ParticleId(id),
        Position(position),
        Velocity(DVec3::ZERO),
        StoredParticle::at_rest(scene, position).state,
    )
}

/// Stores a particle that left its zone at a point, m, or deletes it.
pub(super) fn store(world: &mut World, scene: &Scene, id: u32, point: DVec3) {
    let entity = world.resource::<EntityIndex>().get(id);
    if !scene.reservoir.recycle {
        let tracer = entity.and_then(|entity| world.get::<Tracer>(entity));
        let mut passages = tracer.map_or(0, |tracer| tracer.passages);
        if let Some(entity) = entity {
            world.despawn(entity);
        }
        if let Some(mut details) = world.get_resource_mut::<ParticleDetails>() {
            passages = details.delete(id);
        }
        world.resource_mut::<EntityIndex>().set(id, None);
        world.resource_mut::<FreeNumbers>().0.push(FreeNumber { id, passages });
        let mut ledger = world.resource_mut::<Ledger>();
        ledger.deleted += 1;
        ledger.by_zone[Zone::Reservoir as usize] -= 1;
        return;
    }
    world.resource_mut::<FreeParticles>().0.push(id);
    if let Some(mut details) = world.get_resource_mut::<ParticleDetails>() {
        details.store(StoredParticle::at_rest(scene, point));
    }
    let Some(entity) = entity else { return };
    let mut entity = world.entity_mut(entity);
    // The next sort removes the row from the arrays. The components may be older than the arrays,
    // so all of them are set.
    entity.insert((stored_bundle(scene, id, point), Reservoir));
    if let Some(mut stress) = entity.get_mut::<SpsStress>() {
        *stress = SpsStress::default();
    }
}

/// Returns the number of a particle for an injection: a stored one, or a new one if the scene has
/// no reservoir or an empty one may grow. None if the run has to stop.
///
/// A new particle counts as in the reservoir until it is injected.
pub(super) fn take_particle(world: &mut World, scene: &Scene) -> Option<u32> {
    if let Some(id) = world.resource_mut::<FreeParticles>().0.pop() {
        if let Some(mut details) = world.get_resource_mut::<ParticleDetails>() {
            details.take_stored();
        }
        return Some(id);
    }
    if scene.reservoir.recycle && scene.reservoir.when_empty == WhenEmpty::Stop {
        world.resource_mut::<Failure>().reservoir_empty = true;
        return None;
    }
    let next = FreeNumber { id: world.resource::<EntityIndex>().len() as u32, passages: 0 };
    let FreeNumber { id, passages } = world.resource_mut::<FreeNumbers>().0.pop().unwrap_or(next);
    let entity = world.resource::<EntityIndex>().has_entities().then(|| {
        let tracer = Tracer { passages, ..Tracer::default() };
        let mut entity = world.spawn((stored_bundle(scene, id, DVec3::ZERO), tracer, Reservoir));
        if scene.scheme.has_stress() {
            entity.insert(SpsStress::default());
        }
        entity.id()
    });
    world.resource_mut::<EntityIndex>().set(id, entity);
    if let Some(mut details) = world.get_resource_mut::<ParticleDetails>() {
        details.create(id, passages);
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
