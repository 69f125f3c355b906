//! Injection of a particle into a zone.

use bevy_ecs::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::reservoir::take_particle;
use crate::components::{Inflow, Outflow, Position, Reservoir, Tracer, Velocity};
use crate::resources::clock::Clock;
use crate::resources::entity_index::EntityIndex;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::Ledger;
use crate::resources::particle_details::ParticleDetails;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Injection of a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Injection {
    /// Position, m.
    pub place: DVec3,
    /// Zone.
    pub zone: Zone,
    /// Index of the inlet, emitter or outlet.
    pub patch: u16,
    /// Velocity of the particle that crossed the plane, or the prescribed one of an emitter, m/s.
    pub velocity: DVec3,
    /// Pressure of the particle that crossed the plane, Pa.
    pub pressure: f64,
    /// True if the particle that crossed had returned from the fluid, so that one may have been
    /// injected here before.
    pub returned: bool,
}

/// Injects a particle if the reservoir has one, and returns its number.
pub(super) fn place<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    injection: &Injection,
) -> Option<u32> {
    let id = take_particle(world, scene)?;
    let &Injection { place, zone, patch, pressure, .. } = injection;
    let time = world.resource::<Clock>().time;
    let inlet = scene.inlets.get(usize::from(patch)).filter(|_| zone == Zone::Inflow);
    let velocity = match inlet {
        Some(inlet) => inlet.velocity_at(scene.fluid.viscosity, place, time),
        // In an outflow zone the injected particle has the velocity of the one at the plane, as
        // have the particles between.
        None => injection.velocity,
    };
    arrays.push(&ParticleRow {
        id,
        zone,
        patch,
        needs_restart: true,
        position: place,
        velocity,
        previous_velocity: velocity,
        density: scene.fluid.tait().density(pressure),
        pressure,
        ..ParticleRow::default()
    });
    let mut ledger = world.resource_mut::<Ledger>();
    ledger.by_zone[Zone::Reservoir as usize] -= 1;
    ledger.by_zone[zone as usize] += 1;
    if zone == Zone::Inflow {
        world.resource_mut::<InflowParticles>().inject(patch);
    }
    let tag = scene.initial.tag.value(place.x, place.y, place.z, time) as f32;
    if let Some(mut details) = world.get_resource_mut::<ParticleDetails>() {
        details.inject(id, tag);
    }
    let Some(entity) = world.resource::<EntityIndex>().get(id) else { return Some(id) };
    let mut entity = world.entity_mut(entity);
    if let Some(mut tracer) = entity.get_mut::<Tracer>() {
        *tracer = Tracer { tag, passages: tracer.passages + 1 };
    }
    entity.remove::<Reservoir>();
    entity.insert((Position(place), Velocity(velocity)));
    if zone == Zone::Inflow {
        entity.insert(Inflow { inlet: patch });
    } else {
        entity.insert(Outflow { outlet: patch });
    }
    Some(id)
}
