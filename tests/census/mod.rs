//! A flow as a caller sees it: every particle with its one role, checked against the ledger.

use sphecs::bevy_ecs::world::EntityRef;
use sphecs::glam::DVec3;
use sphecs::particles::components::{
    Acceleration, Density, Fluid, Fresh, Inflow, Outflow, ParticleId, Passage, Position, Pressure,
    PreviousVelocity, Reservoir, Tag, Velocity, Wall,
};
use sphecs::particles::zone::Zone;
use sphecs::simulation::Simulation;

/// The components of one particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Particle {
    /// Number.
    pub id: u32,
    /// Zone by its role component.
    pub zone: Zone,
    /// Index of inlet, outlet or wall part; 0 for others.
    pub patch: u16,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Velocity one step earlier, m/s.
    pub velocity_before: DVec3,
    /// Rate of change of velocity, m/s².
    pub acceleration: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Passive scalar.
    pub tag: f64,
    /// Injections from the reservoir.
    pub passage: u32,
    /// Plain step next.
    pub fresh: bool,
}

/// Everything that a particle has, or what is wrong with it.
fn read(entity: EntityRef<'_>, id: u32) -> Result<Particle, String> {
    let roles = [
        entity.get::<Fluid>().map(|_| (Zone::Fluid, 0)),
        entity.get::<Wall>().map(|wall| (Zone::Wall, wall.part)),
        entity.get::<Inflow>().map(|inflow| (Zone::Inflow, inflow.inlet)),
        entity.get::<Outflow>().map(|outflow| (Zone::Outflow, outflow.outlet)),
        entity.get::<Reservoir>().map(|_| (Zone::Reservoir, 0)),
    ];
    let [(zone, patch)] = roles.into_iter().flatten().collect::<Vec<_>>()[..] else {
        return Err(format!("particle {id} has not one role but {roles:?}"));
    };
    let whole = || {
        Some(Particle {
            id,
            zone,
            patch,
            position: entity.get::<Position>()?.0,
            velocity: entity.get::<Velocity>()?.0,
            velocity_before: entity.get::<PreviousVelocity>()?.0,
            acceleration: entity.get::<Acceleration>()?.0,
            density: entity.get::<Density>()?.0,
            pressure: entity.get::<Pressure>()?.0,
            tag: entity.get::<Tag>()?.0,
            passage: entity.get::<Passage>()?.0,
            fresh: entity.get::<Fresh>()?.0,
        })
    };
    whole().ok_or_else(|| format!("particle {id} lacks a component"))
}

/// All particles in the order of their numbers.
///
/// # Panics
/// If a number is missing or given twice, a particle has no role or two, or the ledger counts otherwise.
#[track_caller]
pub fn census(simulation: &mut Simulation) -> Vec<Particle> {
    let world = simulation.world();
    let mut entities = world.try_query::<EntityRef<'_>>().expect("every world has entities");
    let mut particles: Vec<Particle> = entities
        .iter(world)
        .filter_map(|entity| entity.get::<ParticleId>().map(|id| (entity, id.0)))
        .map(|(entity, id)| read(entity, id).unwrap_or_else(|fault| panic!("{fault}")))
        .collect();
    particles.sort_by_key(|particle| particle.id);
    let step = simulation.clock().step;
    for (number, particle) in particles.iter().enumerate() {
        assert_eq!(particle.id as usize, number, "step {step}: the numbers are not dense");
    }
    let ledger = simulation.ledger();
    let counted = Zone::ALL.map(|zone| of(&particles, zone).count() as u64);
    assert_eq!(counted, ledger.by_zone, "step {step}: the ledger counts otherwise than the components");
    assert!(ledger.balances(), "step {step}: the ledger does not balance: {ledger:?}");
    assert_eq!(
        ledger.total(),
        particles.len() as u64,
        "step {step}: particles that the ledger does not know"
    );
    particles
}

/// The particles of a zone.
pub fn of(particles: &[Particle], zone: Zone) -> impl Iterator<Item = &Particle> {
    particles.iter().filter(move |particle| particle.zone == zone)
}
