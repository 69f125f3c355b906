//! Entities of the particles by number, and the particles in the reservoir.

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;

/// Entity of each particle, by its number; `Entity::PLACEHOLDER` for a number that is free.
#[derive(Resource, Clone, Debug, Default)]
pub struct EntityIndex(pub Vec<Entity>);

/// Numbers of the particles in the reservoir; the last one is taken first.
#[derive(Resource, Clone, Debug, Default)]
pub struct FreeParticles(pub Vec<u32>);
