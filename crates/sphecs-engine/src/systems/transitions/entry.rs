//! A particle enters a zone: where there is room, with the state of the one that made it enter.

use bevy_ecs::query::Without;
use bevy_ecs::world::World;
use glam::DVec3;

use super::stock::take;
use crate::components::{Inflow, Outflow, Position, Reservoir, Returned, Tracer, Velocity};
use crate::systems::clock::Clock;
use crate::systems::ledger::Ledger;
use crate::systems::neighbours::Grid;
use crate::systems::setup::{InflowCapacity, Seats};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::Row;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_scene::model::Scene;

/// Two particles nearer than this over the spacing would clump: nothing is put there.
const ROOM: f64 = 0.5;

/// A place where a particle enters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Entry {
    /// m.
    pub place: DVec3,
    /// Zone that it enters.
    pub zone: Zone,
    /// Inlet or outlet.
    pub patch: u16,
    /// m/s.
    pub velocity: DVec3,
    /// Pa.
    pub pressure: f64,
    /// Whether the particle that crossed may have brought one here before.
    pub again: bool,
}

/// Whether no particle stands within half a spacing of a place.
fn is_free<R: Real, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    sorted: usize,
    place: DVec3,
    room: f64,
) -> bool {
    let mut free = true;
    // Positions moved since the sort by less than the margin between the room and the support.
    let neighbours = Neighbours::new(&world.resource::<Grid<D>>().0, arrays);
    neighbours.for_each(std::array::from_fn(|axis| place[axis]), |row, _, r_squared| {
        free &= arrays.zone[row] == Zone::Reservoir || r_squared > room * room;
    });
    free && (sorted..arrays.len()).all(|row| arrays.position_of(row).distance_squared(place) > room * room)
}

/// Whether an inflow zone has all its particles, those that came back from the fluid left out.
fn is_full(world: &mut World, inlet: u16) -> bool {
    let mut inflow = world.query_filtered::<&Inflow, Without<Returned>>();
    let present = inflow.iter(world).filter(|inflow| inflow.inlet == inlet).count() as u64;
    present >= world.resource::<InflowCapacity>().0[usize::from(inlet)]
}

/// Puts a particle into its zone, if there is room and one to be had.
pub(super) fn enter<R: Real, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    entry: &Entry,
) {
    let sorted = world.resource::<Grid<D>>().0.starts().last().map_or(0, |&end| end as usize);
    if entry.again && entry.zone == Zone::Inflow && is_full(world, entry.patch) {
        return;
    }
    if entry.again && !is_free(world, arrays, sorted, entry.place, ROOM * scene.spacing) {
        return;
    }
    let Some(id) = take(world, scene) else { return };
    let clock = *world.resource::<Clock>();
    let velocity = match entry.zone {
        Zone::Inflow => {
            let inlet = &scene.inlets[usize::from(entry.patch)];
            inlet.velocity_at(scene.fluid.viscosity, entry.place, clock.time)
        }
        // As its partner at the plane: between the two the column moves as one.
        _ => entry.velocity,
    };
    let tag = scene.initial.tag.value(entry.place.x, entry.place.y, entry.place.z, clock.time);
    let row = Row {
        id,
        zone: entry.zone,
        patch: entry.patch,
        fresh: true,
        position: entry.place,
        velocity,
        velocity_before: velocity,
        density: scene.fluid.tait().density(entry.pressure),
        pressure: entry.pressure,
        ..Row::default()
    };
    arrays.push(&row);
    let mut ledger = world.resource_mut::<Ledger>();
    ledger.by_zone[Zone::Reservoir as usize] -= 1;
    ledger.by_zone[entry.zone as usize] += 1;
    let entity = world.resource::<Seats>().0[id as usize];
    let mut entity = world.entity_mut(entity);
    if let Some(mut tracer) = entity.get_mut::<Tracer>() {
        *tracer = Tracer { tag: tag as f32, passages: tracer.passages + 1 };
    }
    entity.remove::<Reservoir>();
    entity.insert((Position(entry.place), Velocity(velocity)));
    if entry.zone == Zone::Inflow {
        entity.insert(Inflow { inlet: entry.patch });
    } else {
        entity.insert(Outflow { outlet: entry.patch });
    }
}
