//! Entities of the particles by number, and the particles in the reservoir.

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;

/// Entities of the particles by their numbers.
///
/// Several ranks have no entities but the particles in the arrays alone.
#[derive(Resource, Clone, Debug)]
pub struct EntityIndex {
    /// Entity of each number; `Entity::PLACEHOLDER` for a number that is free. Empty without
    /// entities.
    entities: Vec<Entity>,
    /// Count of the numbers given out, those that are free again included.
    numbers: u32,
    has_entities: bool,
}

impl Default for EntityIndex {
    fn default() -> Self {
        Self::new(Vec::new())
    }
}

impl EntityIndex {
    /// Returns the index of particles in the order of their numbers; `Entity::PLACEHOLDER` for a
    /// number that is free.
    pub fn new(entities: Vec<Entity>) -> Self {
        let numbers = entities.len() as u32;
        Self { entities, numbers, has_entities: true }
    }

    /// Returns the index of a world that has particles without entities.
    pub fn without_entities(numbers: u32) -> Self {
        Self { entities: Vec::new(), numbers, has_entities: false }
    }

    /// Returns true if the particles of this world have entities.
    pub fn has_entities(&self) -> bool {
        self.has_entities
    }

    /// Returns the count of the numbers given out, those that are free again included.
    pub fn len(&self) -> usize {
        self.numbers as usize
    }

    /// Returns true if no number has been given out.
    pub fn is_empty(&self) -> bool {
        self.numbers == 0
    }

    /// Returns the entity of a particle; None for a number that is free, and without entities.
    pub fn get(&self, id: u32) -> Option<Entity> {
        self.entities.get(id as usize).copied().filter(|&entity| entity != Entity::PLACEHOLDER)
    }

    /// Gives a number, the next one at most, to an entity; None frees it, and stands for a particle
    /// without entity.
    pub fn set(&mut self, id: u32, entity: Option<Entity>) {
        self.numbers = self.numbers.max(id + 1);
        if self.has_entities {
            self.entities.resize(self.numbers as usize, Entity::PLACEHOLDER);
            self.entities[id as usize] = entity.unwrap_or(Entity::PLACEHOLDER);
        }
    }
}

/// Numbers of the particles in the reservoir; the last one is taken first.
#[derive(Resource, Clone, Debug, Default)]
pub struct FreeParticles(pub Vec<u32>);

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_counted_with_and_without_entities() {
        let entity = Entity::from_raw_u32(7);
        let mut index = EntityIndex::new(vec![Entity::PLACEHOLDER; 2]);
        index.set(2, entity);
        assert_eq!((index.len(), index.get(2), index.get(0), index.get(9)), (3, entity, None, None));
        index.set(2, None);
        assert_eq!((index.len(), index.get(2)), (3, None));
        let mut without = EntityIndex::without_entities(3);
        without.set(3, None);
        assert_eq!((without.len(), without.get(3)), (4, None));
    }
}
