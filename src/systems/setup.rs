//! From a scene to a world: resources, particles as entities, and figures that every system needs.

use std::sync::Arc;

use super::ledger::Ledger;
use crate::particles::components::{
    Fluid, Inflow, Outflow, ParticleBundle, ParticleId, Position, Reservoir, SpsStress, Thermodynamics,
    Tracer, Velocity, Wall, WallSurface,
};
use crate::particles::zone::Zone;
use crate::physics::eos::Tait;
use crate::scene::model::{ParticleSeed, Scene};
use bevy_ecs::bundle::{Bundle, NoBundleEffect};
use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;

/// The scene that runs.
#[derive(Resource, Clone, Debug)]
pub struct SceneInUse(pub Arc<Scene>);

/// Lengths and mass of the discretisation.
#[derive(Resource, Clone, Copy, Debug, PartialEq)]
pub struct Resolution {
    /// Initial spacing Δ, m.
    pub spacing: f64,
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Radius of the kernel's support, m.
    pub support: f64,
    /// Mass of every particle, ρ0 Δ^D, kg (per metre of depth in 2D).
    pub mass: f64,
}

impl Resolution {
    /// Lengths and mass of a scene.
    pub fn of(scene: &Scene) -> Self {
        let smoothing_length = scene.scheme.smoothing_ratio() * scene.spacing;
        Self {
            spacing: scene.spacing,
            smoothing_length,
            support: scene.scheme.kernel().support_ratio() * smoothing_length,
            mass: scene.fluid.density * scene.spacing.powi(scene.dimensions as i32),
        }
    }
}

/// The entity of each particle, by its number.
#[derive(Resource, Clone, Debug, Default)]
pub struct Seats(pub Vec<Entity>);

/// Numbers of the particles in the reservoir; the last is taken first.
#[derive(Resource, Clone, Debug, Default)]
pub struct Stored(pub Vec<u32>);

/// Particles that each inflow zone holds in a steady flow: as many as at the start.
#[derive(Resource, Clone, Debug, Default, PartialEq, Eq)]
pub struct InflowCapacity(pub Vec<u64>);

/// Spawns the particles of a scene and inserts seats, stored particles, what inflow zones hold, and the ledger.
pub fn spawn_particles(world: &mut World, scene: &Scene, seeds: &[ParticleSeed]) {
    let turbulent = scene.scheme.has_stress();
    for insert in [
        World::init_resource::<Seats>,
        World::init_resource::<Stored>,
        World::init_resource::<InflowCapacity>,
        World::init_resource::<Ledger>,
    ] {
        insert(world);
    }
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
        let mut spawn = Spawn { world, tait: scene.fluid.tait(), turbulent, group, seats: &mut seats };
        match group[0].zone {
            Zone::Fluid => spawn.with(|_| Fluid),
            Zone::Wall => spawn.with(|seed| {
                let surface = WallSurface { distance: seed.wall_distance, normal: seed.wall_normal };
                (Wall { part: seed.patch }, surface)
            }),
            Zone::Inflow => spawn.with(|seed| Inflow { inlet: seed.patch }),
            Zone::Outflow => spawn.with(|seed| Outflow { outlet: seed.patch }),
            Zone::Reservoir => spawn.with(|_| Reservoir),
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

/// Particles of one zone on their way into the world: all at once, so that the table has room for them and no more.
struct Spawn<'a> {
    world: &'a mut World,
    tait: Tait,
    turbulent: bool,
    group: &'a [ParticleSeed],
    seats: &'a mut Seats,
}

impl Spawn<'_> {
    /// Spawns them with the role that each has.
    fn with<B: Bundle<Effect: NoBundleEffect>>(
        &mut self,
        role: impl Fn(&ParticleSeed) -> B + Send + Sync + 'static,
    ) {
        let first = self.seats.0.len() as u32;
        let tait = self.tait;
        let state = |(id, seed): (u32, &ParticleSeed)| {
            let bundle = ParticleBundle {
                id: ParticleId(id),
                position: Position(seed.position),
                velocity: Velocity(seed.velocity),
                thermodynamics: Thermodynamics {
                    density: tait.density(seed.pressure),
                    pressure: seed.pressure,
                },
                tracer: Tracer { tag: seed.tag as f32, passages: 0 },
            };
            (bundle, role(seed))
        };
        let particles = (first..).zip(self.group).map(state);
        if self.turbulent {
            let particles = particles.map(|particle| (particle, SpsStress::default()));
            self.seats.0.extend(self.world.spawn_batch(particles));
        } else {
            self.seats.0.extend(self.world.spawn_batch(particles));
        }
    }
}
