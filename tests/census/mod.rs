//! Census of a flow: every particle with its single role, checked against the particle counts.

use std::collections::HashMap;

use sphecs::bevy_ecs::world::{EntityRef, World};
use sphecs::glam::DVec3;
use sphecs::{Simulation, Zone};
use sphecs_core::math::real::Real;
use sphecs_engine::arrays::Arrays;
use sphecs_engine::components::{
    Fluid, Inflow, Outflow, ParticleId, Position, Reservoir, Thermodynamics, Tracer, Velocity, Wall,
};

/// Components of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Particle {
    /// Number.
    pub id: u32,
    /// Zone by its role component.
    pub zone: Zone,
    /// Index of inlet, outlet or wall part; 0 for other particles.
    pub patch: u16,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Velocity one step earlier, m/s; zero in the reservoir.
    pub previous_velocity: DVec3,
    /// True if the next step is a corrective one, as for all particles in the reservoir.
    pub needs_restart: bool,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Passive scalar.
    pub tag: f32,
    /// Number of injections from the reservoir.
    pub passages: u32,
}

/// Previous velocity, and whether the next step is a corrective one, by particle number.
type Leapfrog = HashMap<u32, (DVec3, bool)>;

/// Reads the values that only the arrays have, in any precision and dimension.
fn leapfrog(world: &World) -> Leapfrog {
    fn of<R: Real, const D: usize>(world: &World) -> Option<Leapfrog> {
        let arrays = world.get_resource::<Arrays<R, D>>()?;
        let rows = (0..arrays.len()).map(|row| arrays.row(row));
        Some(rows.map(|row| (row.id, (row.previous_velocity, row.needs_restart))).collect())
    }
    let found = of::<f64, 2>(world).or_else(|| of::<f64, 3>(world));
    found.or_else(|| of::<f32, 2>(world)).or_else(|| of::<f32, 3>(world)).expect("a world has arrays")
}

/// Reads a particle, or returns an inconsistency of its components.
fn read(entity: EntityRef<'_>, id: u32, leapfrog: &Leapfrog) -> Result<Particle, String> {
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
        let (previous_velocity, needs_restart) = leapfrog.get(&id).copied().unwrap_or((DVec3::ZERO, true));
        let (thermodynamics, tracer) = (entity.get::<Thermodynamics>()?, entity.get::<Tracer>()?);
        Some(Particle {
            id,
            zone,
            patch,
            position: entity.get::<Position>()?.0,
            velocity: entity.get::<Velocity>()?.0,
            previous_velocity,
            needs_restart,
            density: thermodynamics.density,
            pressure: thermodynamics.pressure,
            tag: tracer.tag,
            passages: tracer.passages,
        })
    };
    whole().ok_or_else(|| format!("particle {id} lacks a component"))
}

/// Returns all particles in the order of their numbers.
///
/// # Panics
/// If a number is missing or occurs twice, if a particle has no role or two, or if the counts
/// differ.
#[track_caller]
pub(crate) fn census(simulation: &mut Simulation) -> Vec<Particle> {
    let world = simulation.world();
    let leapfrog = leapfrog(world);
    let mut entities = world.try_query::<EntityRef<'_>>().expect("every world has entities");
    let mut particles: Vec<Particle> = entities
        .iter(world)
        .filter_map(|entity| entity.get::<ParticleId>().map(|id| (entity, id.0)))
        .map(|(entity, id)| read(entity, id, &leapfrog).unwrap_or_else(|fault| panic!("{fault}")))
        .collect();
    particles.sort_by_key(|particle| particle.id);
    let step = simulation.clock().step;
    for (number, particle) in particles.iter().enumerate() {
        assert_eq!(particle.id as usize, number, "step {step}: the numbers are not dense");
    }
    let ledger = simulation.ledger();
    let counted = Zone::ALL.map(|zone| of(&particles, zone).count() as u64);
    assert_eq!(counted, ledger.by_zone, "step {step}: the particle counts differ from the components");
    assert!(ledger.balances(), "step {step}: the ledger does not balance: {ledger:?}");
    assert_eq!(
        ledger.total(),
        particles.len() as u64,
        "step {step}: particles that the ledger does not know"
    );
    particles
}

/// Iterates over the particles of a zone.
pub(crate) fn of(particles: &[Particle], zone: Zone) -> impl Iterator<Item = &Particle> {
    particles.iter().filter(move |particle| particle.zone == zone)
}
