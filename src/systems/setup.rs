//! From a scene to a world: resources, particles as entities, and figures that every system needs.

use std::sync::Arc;

use bevy_ecs::entity::Entity;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;

use super::ledger::Ledger;
use crate::particles::components::{
    Acceleration, Density, Fluid, Fresh, Inflow, Outflow, ParticleBundle, ParticleId, Passage, Position,
    Pressure, PreviousVelocity, Reservoir, SpsStress, Tag, Velocity, Wall, WallSurface,
};
use crate::particles::zone::Zone;
use crate::physics::viscosity::Viscosity;
use crate::scene::model::{ParticleSeed, Scene};

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
        let smoothing_length = scene.scheme.smoothing_ratio * scene.spacing;
        Self {
            spacing: scene.spacing,
            smoothing_length,
            support: scene.scheme.kernel.support_ratio() * smoothing_length,
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
    let tait = scene.fluid.tait();
    let turbulent = matches!(scene.scheme.viscosity, Viscosity::Sps { .. });
    let mut seats = Seats::default();
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
    for (number, seed) in seeds.iter().enumerate() {
        let id = number as u32;
        let state = ParticleBundle {
            id: ParticleId(id),
            position: Position(seed.position),
            velocity: Velocity(seed.velocity),
            previous_velocity: PreviousVelocity(seed.velocity),
            acceleration: Acceleration(DVec3::ZERO),
            density: Density(tait.density(seed.pressure)),
            pressure: Pressure(seed.pressure),
            tag: Tag(seed.tag),
            passage: Passage(0),
            fresh: Fresh(true),
        };
        let mut entity = world.spawn(state);
        if turbulent {
            entity.insert(SpsStress::default());
        }
        match seed.zone {
            Zone::Fluid => entity.insert(Fluid),
            Zone::Wall => entity.insert((
                Wall { part: seed.patch },
                WallSurface { distance: seed.wall_distance, normal: seed.wall_normal },
            )),
            Zone::Inflow => entity.insert(Inflow { inlet: seed.patch }),
            Zone::Outflow => entity.insert(Outflow { outlet: seed.patch }),
            Zone::Reservoir => entity.insert(Reservoir),
        };
        match seed.zone {
            Zone::Reservoir => stored.0.push(id),
            Zone::Inflow => capacity.0[usize::from(seed.patch)] += 1,
            Zone::Fluid | Zone::Wall | Zone::Outflow => {}
        }
        ledger.by_zone[seed.zone as usize] += 1;
        seats.0.push(entity.id());
    }
    world.insert_resource(seats);
    world.insert_resource(stored);
    world.insert_resource(capacity);
    world.insert_resource(ledger);
}
