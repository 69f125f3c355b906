//! Particles of a scene or of a saved state, spawned as entities or put into the arrays alone.

use bevy_ecs::bundle::{Bundle, NoBundleEffect};
use bevy_ecs::entity::Entity;
use bevy_ecs::query::With;
use bevy_ecs::world::World;
use glam::DVec3;

use crate::arrays::Arrays;
use crate::components::{
    Fluid, Inflow, Outflow, ParticleBundle, ParticleId, Position, Reservoir, SpsStress, Thermodynamics,
    Tracer, Velocity, Wall, WallSurface,
};
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::{InflowCapacity, Ledger};
use crate::resources::particle_details::ParticleDetails;
use crate::resources::state_location::StateLocation;
use crate::systems::transitions::refill::WaitingInjections;
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::eos::Tait;
use sphecs_scene::model::{ParticleSeed, Scene};

/// Fills the reservoir and the particle counts from initial particles.
pub(crate) fn count_particles(world: &mut World, scene: &Scene, seeds: &[ParticleSeed]) {
    let mut free = FreeParticles::default();
    let mut capacity = InflowCapacity(vec![0; scene.source_count()]);
    let mut inflow = InflowParticles::none(scene.source_count());
    let mut outflow = vec![0; scene.outlets.len()];
    let mut ledger = Ledger {
        initial: seeds.len() as u64,
        entered: vec![0; scene.source_count()],
        entered_back: vec![0; scene.source_count()],
        left: vec![0; scene.outlets.len()],
        left_back: vec![0; scene.outlets.len()],
        ..Ledger::default()
    };
    for (id, seed) in (0..).zip(seeds) {
        ledger.by_zone[seed.zone as usize] += 1;
        match seed.zone {
            Zone::Reservoir => free.0.push(id),
            Zone::Inflow => {
                capacity.0[usize::from(seed.patch)] += 1;
                inflow.inject(seed.patch);
            }
            Zone::Outflow => outflow[usize::from(seed.patch)] += 1,
            Zone::Fluid | Zone::Wall => {}
        }
    }
    world.insert_resource(free);
    world.insert_resource(inflow);
    world.insert_resource(capacity);
    world.insert_resource(WaitingInjections { capacity: outflow, waiting: Vec::new() });
    world.insert_resource(ledger);
}

/// Spawns the initial particles and fills the entity index.
pub(crate) fn spawn_particles(world: &mut World, scene: &Scene, seeds: &[ParticleSeed]) {
    let turbulent = scene.scheme.has_stress();
    let tait = scene.fluid.tait();
    let mut entities = Vec::with_capacity(seeds.len());
    for group in seeds.chunk_by(|a, b| a.zone == b.zone) {
        let first = entities.len() as u32;
        let state = (first..).zip(group).map(|(id, seed)| (seed_bundle(tait, id, seed), seed));
        let mut spawn = Spawn { world, turbulent, entities: &mut entities };
        match group[0].zone {
            Zone::Fluid => spawn.all(state.map(|(bundle, _)| (bundle, Fluid))),
            Zone::Wall => spawn.all(
                state.map(|(bundle, seed)| (bundle, (Wall { part: seed.patch }, WallSurface::of_seed(seed)))),
            ),
            Zone::Inflow => spawn.all(state.map(|(bundle, seed)| (bundle, Inflow { inlet: seed.patch }))),
            Zone::Outflow => spawn.all(state.map(|(bundle, seed)| (bundle, Outflow { outlet: seed.patch }))),
            Zone::Reservoir => spawn.all(state.map(|(bundle, _)| (bundle, Reservoir))),
        }
    }
    world.insert_resource(EntityIndex::new(entities));
}

/// Fills the arrays with initial particles that get no components.
pub(crate) fn fill_arrays<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    mut seeds: Vec<ParticleSeed>,
) {
    let tait = scene.fluid.tait();
    let row = |(id, seed): (u32, &ParticleSeed)| {
        let is_wall = seed.zone == Zone::Wall;
        let surface = if is_wall { WallSurface::of_seed(seed) } else { WallSurface::default() };
        ParticleRow {
            id,
            zone: seed.zone,
            patch: if seed.zone == Zone::Fluid { 0 } else { seed.patch },
            needs_restart: true,
            position: seed.position,
            velocity: seed.velocity,
            previous_velocity: seed.velocity,
            density: tait.density(seed.pressure),
            pressure: seed.pressure,
            previous_pressure: seed.pressure,
            drift: DVec3::ZERO,
            wall_distance: surface.distance,
            wall_normal: surface.normal,
            wall_thickness: surface.thickness,
        }
    };
    world.insert_resource(ParticleDetails::of_seeds(scene, &seeds));
    world.insert_resource(EntityIndex::without_entities(seeds.len() as u32));
    let mut arrays = world.resource_mut::<Arrays<R, D>>();
    arrays.reserve(seeds.iter().filter(|seed| seed.zone != Zone::Reservoir).count());
    let mut batch = Vec::new();
    // From the end, so that the memory of the initial particles is freed as the columns are filled:
    // the largest runs are limited by it.
    while !seeds.is_empty() {
        let first = seeds.len().saturating_sub(BATCH);
        let numbered = (first as u32..seeds.len() as u32).zip(&seeds[first..]).rev();
        batch.clear();
        batch.extend(numbered.filter(|(_, seed)| seed.zone != Zone::Reservoir).map(row));
        arrays.extend(&batch);
        seeds.truncate(first);
        seeds.shrink_to_fit();
    }
    arrays.reverse();
    world.insert_resource(StateLocation::Arrays);
}

/// Despawns the particles, which remain in the arrays; what only their components have is kept.
pub(crate) fn despawn_particles(world: &mut World) {
    if !world.resource::<EntityIndex>().has_entities() {
        return;
    }
    let details = ParticleDetails::of_components(world);
    let particles: Vec<Entity> = world.query_filtered::<Entity, With<ParticleId>>().iter(world).collect();
    for particle in particles {
        world.despawn(particle);
    }
    let numbers = world.resource::<EntityIndex>().len() as u32;
    world.insert_resource(EntityIndex::without_entities(numbers));
    world.insert_resource(details);
}

/// Particles whose rows are made at once.
const BATCH: usize = 65_536;

fn seed_bundle(tait: Tait, id: u32, seed: &ParticleSeed) -> ParticleBundle {
    ParticleBundle {
        id: ParticleId(id),
        position: Position(seed.position),
        velocity: Velocity(seed.velocity),
        thermodynamics: Thermodynamics { density: tait.density(seed.pressure), pressure: seed.pressure },
        tracer: Tracer { tag: seed.tag as f32, passages: 0 },
    }
}

/// Particle of a saved state.
#[derive(Clone, Copy, Debug)]
pub(crate) struct SavedParticle {
    /// Components that every particle has.
    pub bundle: ParticleBundle,
    /// Zone.
    pub zone: Zone,
    /// Index of inlet, outlet or wall part.
    pub patch: u16,
    /// Position relative to the wall surface, for a wall particle.
    pub surface: WallSurface,
}

/// Spawns the particles of a saved state, in the order of their numbers, and fills the entity
/// index; a free number has no particle.
pub(crate) fn spawn_saved(world: &mut World, scene: &Scene, particles: &[Option<SavedParticle>]) {
    let turbulent = scene.scheme.has_stress();
    let mut index = vec![Entity::PLACEHOLDER; particles.len()];
    let mut spawned = Vec::new();
    // All groups in one pass: the particles of a large scene do not fit into the cache.
    let mut groups: [Vec<&SavedParticle>; Zone::ALL.len()] = Default::default();
    for particle in particles.iter().flatten() {
        groups[particle.zone as usize].push(particle);
    }
    for (zone, group) in Zone::ALL.into_iter().zip(groups) {
        let state = group.iter().map(|particle| (particle.bundle, **particle));
        let mut spawn = Spawn { world, turbulent, entities: &mut spawned };
        match zone {
            Zone::Fluid => spawn.all(state.map(|(bundle, _)| (bundle, Fluid))),
            Zone::Wall => {
                spawn.all(state.map(|(bundle, wall)| (bundle, (Wall { part: wall.patch }, wall.surface))));
            }
            Zone::Inflow => {
                spawn.all(state.map(|(bundle, inflow)| (bundle, Inflow { inlet: inflow.patch })));
            }
            Zone::Outflow => {
                spawn.all(state.map(|(bundle, outflow)| (bundle, Outflow { outlet: outflow.patch })));
            }
            Zone::Reservoir => spawn.all(state.map(|(bundle, _)| (bundle, Reservoir))),
        }
        for (particle, entity) in group.iter().zip(spawned.drain(..)) {
            index[particle.bundle.id.0 as usize] = entity;
        }
    }
    world.insert_resource(EntityIndex::new(index));
}

/// Spawns the particles of one role in one batch, so that their table is allocated in the exact
/// size.
struct Spawn<'a> {
    world: &'a mut World,
    /// True if the particles carry a sub-particle stress.
    turbulent: bool,
    /// Entities spawned so far.
    entities: &'a mut Vec<Entity>,
}

impl Spawn<'_> {
    /// Spawns particles with their roles.
    fn all<B: Bundle<Effect: NoBundleEffect>>(
        &mut self,
        particles: impl Iterator<Item = (ParticleBundle, B)>,
    ) {
        if self.turbulent {
            let particles = particles.map(|particle| (particle, SpsStress::default()));
            self.entities.extend(self.world.spawn_batch(particles));
        } else {
            self.entities.extend(self.world.spawn_batch(particles));
        }
    }
}
