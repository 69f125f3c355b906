//! From a scene to a world: resources, particles as entities, and figures that every system needs.

use std::sync::Arc;

use super::ledger::Ledger;
use super::plugin::Parts;
use crate::components::{
    Fluid, Inflow, Outflow, ParticleBundle, ParticleId, Position, Reservoir, Returned, SpsStress,
    Thermodynamics, Tracer, Velocity, Wall, WallSurface,
};
use bevy_ecs::bundle::{Bundle, NoBundleEffect};
use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use serde::{Deserialize, Serialize};
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::eos::Tait;
use sphecs_scene::model::{ParticleSeed, Scene};

/// The scene that runs.
#[derive(Resource, Clone, Debug)]
pub struct SceneInUse(pub Arc<Scene>);

/// The entity of each particle, by its number; `Entity::PLACEHOLDER` for a number that is free.
#[derive(Resource, Clone, Debug, Default)]
pub struct Seats(pub Vec<Entity>);

/// Numbers of the particles in the reservoir; the last is taken first.
#[derive(Resource, Clone, Debug, Default)]
pub struct Stored(pub Vec<u32>);

/// Particles that each inflow zone holds in a steady flow: as many as at the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct InflowCapacity(pub Vec<u64>);

/// Inserts what stands beside the particles, before them: seats, stored particles, what inflow zones hold, and the ledger.
pub fn insert_registers(parts: &mut Parts<'_>) {
    parts.world.init_resource::<Seats>();
    parts.world.init_resource::<Stored>();
    parts.keep::<InflowCapacity>("inflow_capacity");
    parts.keep::<Ledger>("ledger");
}

/// Spawns the particles of a scene and fills the registers.
pub fn spawn_particles(world: &mut World, scene: &Scene, seeds: &[ParticleSeed]) {
    let turbulent = scene.scheme.has_stress();
    let tait = scene.fluid.tait();
    let mut seats = Seats(Vec::with_capacity(seeds.len()));
    let mut stored = Stored::default();
    let mut capacity = InflowCapacity(vec![0; scene.inlets.len()]);
    let mut ledger = Ledger {
        initial: seeds.len() as u64,
        entered: vec![0; scene.inlets.len()],
        entered_back: vec![0; scene.inlets.len()],
        left: vec![0; scene.outlets.len()],
        left_back: vec![0; scene.outlets.len()],
        ..Ledger::default()
    };
    for group in seeds.chunk_by(|a, b| a.zone == b.zone) {
        let first = seats.0.len() as u32;
        let state = (first..).zip(group).map(|(id, seed)| (seed_bundle(tait, id, seed), seed));
        let mut spawn = Spawn { world, turbulent, seats: &mut seats.0 };
        match group[0].zone {
            Zone::Fluid => spawn.all(state.map(|(bundle, _)| (bundle, Fluid))),
            Zone::Wall => spawn.all(state.map(|(bundle, seed)| {
                let surface = WallSurface { distance: seed.wall_distance, normal: seed.wall_normal };
                (bundle, (Wall { part: seed.patch }, surface))
            })),
            Zone::Inflow => spawn.all(state.map(|(bundle, seed)| (bundle, Inflow { inlet: seed.patch }))),
            Zone::Outflow => spawn.all(state.map(|(bundle, seed)| (bundle, Outflow { outlet: seed.patch }))),
            Zone::Reservoir => spawn.all(state.map(|(bundle, _)| (bundle, Reservoir))),
        }
        match group[0].zone {
            Zone::Reservoir => stored.0.extend(first..seats.0.len() as u32),
            Zone::Inflow => group.iter().for_each(|seed| capacity.0[usize::from(seed.patch)] += 1),
            Zone::Fluid | Zone::Wall | Zone::Outflow => {}
        }
        ledger.by_zone[group[0].zone as usize] += group.len() as u64;
    }
    world.insert_resource(seats);
    world.insert_resource(stored);
    world.insert_resource(capacity);
    world.insert_resource(ledger);
}

fn seed_bundle(tait: Tait, id: u32, seed: &ParticleSeed) -> ParticleBundle {
    ParticleBundle {
        id: ParticleId(id),
        position: Position(seed.position),
        velocity: Velocity(seed.velocity),
        thermodynamics: Thermodynamics { density: tait.density(seed.pressure), pressure: seed.pressure },
        tracer: Tracer { tag: seed.tag as f32, passages: 0 },
    }
}

/// A particle of a saved state.
#[derive(Clone, Copy, Debug)]
pub struct SavedParticle {
    /// What every particle has.
    pub bundle: ParticleBundle,
    /// Its zone.
    pub zone: Zone,
    /// Index of inlet, outlet or wall part.
    pub patch: u16,
    /// Whether it came back through its inlet.
    pub returned: bool,
    /// Of a wall: where it stands behind its surface.
    pub surface: WallSurface,
}

/// Spawns the particles of a saved state, which come in the order of their numbers, and seats them; a free number has none.
pub fn spawn_saved(world: &mut World, scene: &Scene, particles: &[Option<SavedParticle>]) {
    let turbulent = scene.scheme.has_stress();
    let mut seats = vec![Entity::PLACEHOLDER; particles.len()];
    let mut spawned = Vec::new();
    for (zone, returned) in Zone::ALL.into_iter().flat_map(|zone| [(zone, false), (zone, true)]) {
        let is_in = |particle: &&SavedParticle| particle.zone == zone && particle.returned == returned;
        let group: Vec<&SavedParticle> = particles.iter().flatten().filter(is_in).collect();
        let state = group.iter().map(|particle| (particle.bundle, **particle));
        let mut spawn = Spawn { world, turbulent, seats: &mut spawned };
        match (zone, returned) {
            (Zone::Fluid, _) => spawn.all(state.map(|(bundle, _)| (bundle, Fluid))),
            (Zone::Wall, _) => {
                spawn.all(state.map(|(bundle, wall)| (bundle, (Wall { part: wall.patch }, wall.surface))))
            }
            (Zone::Inflow, false) => {
                spawn.all(state.map(|(bundle, inflow)| (bundle, Inflow { inlet: inflow.patch })));
            }
            (Zone::Inflow, true) => {
                spawn.all(state.map(|(bundle, inflow)| (bundle, (Inflow { inlet: inflow.patch }, Returned))));
            }
            (Zone::Outflow, _) => {
                spawn.all(state.map(|(bundle, outflow)| (bundle, Outflow { outlet: outflow.patch })));
            }
            (Zone::Reservoir, _) => spawn.all(state.map(|(bundle, _)| (bundle, Reservoir))),
        }
        for (particle, entity) in group.iter().zip(spawned.drain(..)) {
            seats[particle.bundle.id.0 as usize] = entity;
        }
    }
    world.insert_resource(Seats(seats));
}

/// Particles of one role on their way into the world: all at once, so that the table has room for them and no more.
struct Spawn<'a> {
    world: &'a mut World,
    turbulent: bool,
    seats: &'a mut Vec<Entity>,
}

impl Spawn<'_> {
    /// Spawns them with the role that each has.
    fn all<B: Bundle<Effect: NoBundleEffect>>(
        &mut self,
        particles: impl Iterator<Item = (ParticleBundle, B)>,
    ) {
        if self.turbulent {
            let particles = particles.map(|particle| (particle, SpsStress::default()));
            self.seats.extend(self.world.spawn_batch(particles));
        } else {
            self.seats.extend(self.world.spawn_batch(particles));
        }
    }
}
