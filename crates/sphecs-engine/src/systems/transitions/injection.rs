//! Injection of a particle into a zone.

use bevy_ecs::world::World;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::reservoir::take_particle;
use crate::components::{Inflow, Outflow, Position, Reservoir, Tracer, Velocity};
use crate::resources::clock::Clock;
use crate::resources::entity_index::EntityIndex;
use crate::resources::grid::Grid;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::{InflowCapacity, Ledger};
use crate::resources::particle_details::ParticleDetails;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Smallest distance, over the spacing, from an injected particle to the others: closer pairs would
/// clump.
const MIN_DISTANCE: f64 = 0.5;

/// Injection of a particle.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
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

/// Injects a particle if its position is free and the reservoir has a particle; returns false if
/// the position is not free.
pub(super) fn inject<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    injection: &Injection,
) -> bool {
    if injection.returned && !is_possible(world, scene, arrays, injection) {
        return false;
    }
    place(world, scene, arrays, injection);
    true
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

/// Returns true if the position of an injection is free and, at an inlet, the zone has lost
/// particles.
fn is_possible<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    injection: &Injection,
) -> bool {
    if injection.zone == Zone::Inflow && is_full(world, injection.patch) {
        return false;
    }
    is_free(world, arrays, injection.place, MIN_DISTANCE * scene.spacing)
}

/// Returns true if no particle is within `distance`, m, of a position.
pub(super) fn is_free<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    place: DVec3,
    distance: f64,
) -> bool {
    // Rows from here on were added after the last sort.
    let sorted = world.resource::<Grid<D>>().0.starts().last().map_or(0, |&end| end as usize);
    let mut free = true;
    // Since the sort, positions changed by less than the difference of the support and `distance`.
    let neighbours = Neighbours::new(&world.resource::<Grid<D>>().0, arrays);
    neighbours.for_each(std::array::from_fn(|axis| place[axis]), |row, _, r_squared| {
        free &= arrays.zone[row] == Zone::Reservoir || r_squared > distance * distance;
    });
    free && (sorted..arrays.len())
        .all(|row| arrays.position_of(row).distance_squared(place) > distance * distance)
}

/// Returns true if an inflow zone has all its particles, not counting those that returned from the
/// fluid.
fn is_full(world: &World, inlet: u16) -> bool {
    world.resource::<InflowParticles>().others(inlet)
        >= world.resource::<InflowCapacity>().0[usize::from(inlet)]
}
