//! Values of the particles that the arrays do not have, for particles without components.
//!
//! Particles of one rank alone have them as components. A run on several ranks has no components:
//! they would take three times the memory of the columns, and rank 0 would have those of all
//! particles.

use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;

use super::entity_index::{EntityIndex, FreeParticles};
use crate::components::{ParticleId, Position, Thermodynamics, Tracer, Velocity, WallSurface};
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::{ParticleSeed, Scene};

/// Values of all particles that the arrays do not have; of several ranks only rank 0 has them.
#[derive(Resource, Clone, Debug, Default, PartialEq)]
pub struct ParticleDetails {
    /// Passive scalar and number of injections by number; 0 for a number that is free.
    tracers: Vec<Tracer>,
    /// Wall particles with their place behind the surface, by rising number.
    walls: Vec<(u32, WallSurface)>,
    /// Particles in the reservoir, in the order of [`FreeParticles`].
    stored: Vec<StoredParticle>,
}

/// State of a particle in the reservoir.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct StoredParticle {
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Density and pressure.
    pub state: Thermodynamics,
}

impl StoredParticle {
    /// Returns a particle at rest at a point, m.
    pub(crate) fn at_rest(scene: &Scene, position: DVec3) -> Self {
        let state = Thermodynamics { density: scene.fluid.density, pressure: 0.0 };
        Self { position, velocity: DVec3::ZERO, state }
    }
}

impl ParticleDetails {
    /// Returns the details of the initial particles of a scene.
    pub(crate) fn of_seeds(scene: &Scene, seeds: &[ParticleSeed]) -> Self {
        let tait = scene.fluid.tait();
        let numbered = || (0..).zip(seeds);
        let wall = |(id, seed): (u32, &ParticleSeed)| (id, WallSurface::of_seed(seed));
        let stored = |seed: &ParticleSeed| StoredParticle {
            position: seed.position,
            velocity: seed.velocity,
            state: Thermodynamics { density: tait.density(seed.pressure), pressure: seed.pressure },
        };
        Self {
            tracers: seeds.iter().map(|seed| Tracer { tag: seed.tag as f32, passages: 0 }).collect(),
            walls: numbered().filter(|(_, seed)| seed.zone == Zone::Wall).map(wall).collect(),
            stored: seeds.iter().filter(|seed| seed.zone == Zone::Reservoir).map(stored).collect(),
        }
    }

    /// Returns the details that the components of a world have.
    pub(crate) fn of_components(world: &mut World) -> Self {
        let index = world.resource::<EntityIndex>();
        let stored = world.resource::<FreeParticles>().0.iter().map(|&id| {
            let entity = world.entity(index.get(id).expect("a stored particle has an entity"));
            let (position, velocity, state) = entity.components::<(&Position, &Velocity, &Thermodynamics)>();
            StoredParticle { position: position.0, velocity: velocity.0, state: *state }
        });
        let stored = stored.collect();
        let mut tracers = vec![Tracer::default(); index.len()];
        let mut walls = Vec::new();
        let mut particles = world.query::<(&ParticleId, &Tracer, Option<&WallSurface>)>();
        for (id, tracer, surface) in particles.iter(world) {
            tracers[id.0 as usize] = *tracer;
            walls.extend(surface.map(|surface| (id.0, *surface)));
        }
        walls.sort_unstable_by_key(|(id, _)| *id);
        Self { tracers, walls, stored }
    }

    /// Returns the count of the numbers given out.
    pub(crate) fn numbers(&self) -> usize {
        self.tracers.len()
    }

    /// Returns the tracer of a particle.
    pub fn tracer(&self, id: u32) -> Tracer {
        self.tracers.get(id as usize).copied().unwrap_or_default()
    }

    /// Returns the places of the wall particles by rising number.
    pub(crate) fn walls(&self) -> &[(u32, WallSurface)] {
        &self.walls
    }

    /// Returns the particles in the reservoir, in the order of [`FreeParticles`].
    pub(crate) fn stored(&self) -> &[StoredParticle] {
        &self.stored
    }

    /// Counts an injection of a particle, which gets a passive scalar.
    pub(crate) fn inject(&mut self, id: u32, tag: f32) {
        let tracer = &mut self.tracers[id as usize];
        *tracer = Tracer { tag, passages: tracer.passages + 1 };
    }

    /// Adds a particle in the reservoir.
    pub(crate) fn store(&mut self, particle: StoredParticle) {
        self.stored.push(particle);
    }

    /// Takes the particle out of the reservoir that was added last.
    pub(crate) fn take_stored(&mut self) {
        self.stored.pop();
    }

    /// Gives a number to a new particle.
    pub(crate) fn create(&mut self, id: u32, passages: u32) {
        let numbers = self.tracers.len().max(id as usize + 1);
        self.tracers.resize(numbers, Tracer::default());
        self.tracers[id as usize] = Tracer { passages, ..Tracer::default() };
    }

    /// Frees the number of a particle and returns how often it was injected.
    pub(crate) fn delete(&mut self, id: u32) -> u32 {
        std::mem::take(&mut self.tracers[id as usize]).passages
    }

    /// Adds the details to a saved state.
    pub(crate) fn save(&self, to: &mut Columns) {
        let Self { tracers, walls, stored } = self;
        to.put("particle.tag", tracers.iter().map(|tracer| tracer.tag).collect::<Vec<f32>>());
        to.put("particle.passages", tracers.iter().map(|tracer| tracer.passages).collect::<Vec<u32>>());
        to.put("wall.id", walls.iter().map(|(id, _)| *id).collect::<Vec<u32>>());
        let surfaces = || walls.iter().map(|(_, surface)| surface);
        to.put("wall.distance", surfaces().map(|surface| surface.distance).collect::<Vec<f64>>());
        to.put("wall.thickness", surfaces().map(|surface| surface.thickness).collect::<Vec<f64>>());
        put_vectors("wall.normal", surfaces().map(|surface| surface.normal), to);
        put_vectors("stored.position", stored.iter().map(|particle| particle.position), to);
        put_vectors("stored.velocity", stored.iter().map(|particle| particle.velocity), to);
        to.put("stored.density", stored.iter().map(|stored| stored.state.density).collect::<Vec<f64>>());
        to.put("stored.pressure", stored.iter().map(|stored| stored.state.pressure).collect::<Vec<f64>>());
    }

    /// Takes the details of a saved state that has a number of particles in the reservoir.
    ///
    /// # Errors
    /// [`ColumnMismatch`] if a column is missing or has not as many values as the others.
    pub(crate) fn restore(stored: usize, from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let tags = from.take::<f32>("particle.tag")?;
        let passages = from.take_exactly::<u32>("particle.passages", tags.len())?;
        let walls = from.take::<u32>("wall.id")?;
        let distance = from.take_exactly::<f64>("wall.distance", walls.len())?;
        let thickness = from.take_exactly::<f64>("wall.thickness", walls.len())?;
        let normal = take_vectors("wall.normal", walls.len(), from)?;
        let position = take_vectors("stored.position", stored, from)?;
        let velocity = take_vectors("stored.velocity", stored, from)?;
        let density = from.take_exactly::<f64>("stored.density", stored)?;
        let pressure = from.take_exactly::<f64>("stored.pressure", stored)?;
        let surface =
            |at: usize| WallSurface { distance: distance[at], normal: normal[at], thickness: thickness[at] };
        let state = |at: usize| Thermodynamics { density: density[at], pressure: pressure[at] };
        let particle =
            |at: usize| StoredParticle { position: position[at], velocity: velocity[at], state: state(at) };
        let tracers = tags.into_iter().zip(passages);
        Ok(Self {
            tracers: tracers.map(|(tag, passages)| Tracer { tag, passages }).collect(),
            walls: walls.into_iter().enumerate().map(|(at, id)| (id, surface(at))).collect(),
            stored: (0..stored).map(particle).collect(),
        })
    }
}

fn put_vectors(name: &str, vectors: impl Iterator<Item = DVec3> + Clone, to: &mut Columns) {
    for axis in 0..3 {
        to.put(format!("{name}.{axis}"), vectors.clone().map(|vector| vector[axis]).collect::<Vec<f64>>());
    }
}

fn take_vectors(name: &str, count: usize, from: &mut Columns) -> Result<Vec<DVec3>, ColumnMismatch> {
    let mut vectors = vec![DVec3::ZERO; count];
    for axis in 0..3 {
        let values = from.take_exactly::<f64>(&format!("{name}.{axis}"), count)?;
        vectors.iter_mut().zip(values).for_each(|(vector, value)| vector[axis] = value);
    }
    Ok(vectors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn details_are_restored_as_they_were_saved() {
        let mut details = ParticleDetails::default();
        (0..3).for_each(|id| details.create(id, 4 * id));
        details.inject(2, 0.5);
        details.inject(1, -0.0);
        assert_eq!((details.delete(1), details.tracer(1)), (5, Tracer::default()));
        assert_eq!(details.tracer(2), Tracer { tag: 0.5, passages: 9 });
        let at_rest = |x: f64| StoredParticle {
            position: DVec3::new(x, 2.0, 3.0),
            velocity: DVec3::ZERO,
            state: Thermodynamics { density: 1000.0, pressure: x },
        };
        [1.0, 7.0, 8.0].into_iter().for_each(|x| details.store(at_rest(x)));
        details.take_stored();
        details.walls = vec![(0, WallSurface { distance: 0.1, normal: DVec3::Y, thickness: 0.0 })];
        let mut columns = Columns::default();
        details.save(&mut columns);
        let restored = ParticleDetails::restore(2, &mut columns.clone()).expect("they fit");
        assert_eq!(restored, details);
        assert!(ParticleDetails::restore(3, &mut columns).is_err(), "there are two in the reservoir");
    }
}
