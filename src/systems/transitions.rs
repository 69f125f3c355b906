//! Particles change zone: the only place where roles change during a run.
//!
//! ```text
//! Inflow → Fluid       across the inlet plane; a stored particle enters upstream (`boundaries/entrance.rs`)
//! Fluid → Inflow       back across the inlet plane
//! Inflow → Reservoir   beyond the upstream end of the zone
//! Fluid → Outflow      across the outlet plane
//! Outflow → Fluid      back across the outlet plane; a stored particle enters at x + L n
//! Outflow → Reservoir  beyond the downstream end of the zone, with zero velocity
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Fig. 1 and Sec. 4; backflow is not in their text. A particle that
//! trembles on a plane would fill its zone anew at each return (test `trembling_on_a_plane_adds_nothing`), so for one
//! that came back a stored one enters only where none stands within half a spacing, and at an inlet only if its zone
//! has lost particles at its upstream end. For all others one enters always, whoever slides past: each refusal would
//! leave a hole in its row for ever. A slantwise inlet keeps its rows as long as its zone, whatever crosses; at one that
//! is filled once nothing enters, and the run stops when it is drained.

use std::ops::Range;

use bevy_ecs::bundle::Bundle;
use bevy_ecs::change_detection::Mut;
use bevy_ecs::query::Without;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;

use super::boundaries::entrance::{InflowRow, is_drained, is_slantwise};
use super::boundaries::inlets::inlet_velocity;
use super::boundaries::rows::PatchRows;
use super::clock::Clock;
use super::failure::Failure;
use super::ledger::Ledger;
use super::neighbours::Grid;
use super::setup::{InflowCapacity, SceneInUse, Seats, Stored};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::components::{
    Fluid, Inflow, Outflow, ParticleId, Position, Reservoir, Returned, SpsStress, Thermodynamics, Tracer,
    Velocity,
};
use crate::particles::rows::{Row, set_real_vector};
use crate::particles::zone::Zone;
use crate::pass::blocks::{for_each_part, with_lists};
use crate::pass::neighbours::Neighbours;
use crate::physics::inlet::Feed;
use crate::scene::model::{Inlet, Patch, Scene, WhenEmpty};

/// Two particles nearer than this over the spacing would clump: nothing is put there.
const ROOM: f64 = 0.5;

/// A change of zone that a row is due for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    row: usize,
    zone: Zone,
    patch: u16,
}

/// A place where a stored particle enters.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Entry {
    place: DVec3,
    zone: Zone,
    patch: u16,
    velocity: DVec3,
    /// Whether the particle that crossed may have brought one here before.
    again: bool,
}

/// The lists of a transition, kept from step to step.
#[derive(Resource, Debug, Default)]
pub struct TransitionLists {
    /// Changes due in each part of the rows.
    changes: Vec<Vec<Change>>,
    entries: Vec<Entry>,
}

/// Finds the rows that crossed a plane, and changes their roles in both homes of the state.
pub fn transition<R: Real, const D: usize>(world: &mut World) {
    let scene = world.resource::<SceneInUse>().0.clone();
    if scene.inlets.is_empty() && scene.outlets.is_empty() {
        wrap_periodic::<R, D>(world, &scene);
        return;
    }
    world.resource_scope(|world, mut arrays: Mut<ParticleArrays<R, D>>| {
        world.resource_scope(|world, mut lists: Mut<TransitionLists>| {
            let TransitionLists { changes, entries } = &mut *lists;
            let changes =
                with_lists(arrays.len(), changes, &|rows, due| find_due(&scene, &arrays, rows, due));
            for change in changes.iter().flatten() {
                apply(world, &scene, &mut arrays, change, entries);
            }
            for entry in entries.drain(..) {
                enter(world, &scene, &mut arrays, &entry);
            }
        });
    });
    wrap_periodic::<R, D>(world, &scene);
}

fn wrap_periodic<R: Real, const D: usize>(world: &mut World, scene: &Scene) {
    let mut arrays = world.resource_mut::<ParticleArrays<R, D>>();
    for axis in 0..D {
        let Some((lower, upper)) = scene.periodic[axis] else { continue };
        let period = upper - lower;
        let column = arrays.position[axis].as_mut_slice();
        for_each_part(0..column.len(), column, &|_, column| {
            for x in column {
                if *x < lower {
                    *x += period;
                } else if *x >= upper {
                    *x -= period;
                }
            }
        });
    }
}

/// Whether a point beyond a patch's plane went through the opening and stands in front of its zone or in it.
fn through(patch: &Patch, point: DVec3, spacing: f64, beyond: f64) -> bool {
    beyond < patch.depth && patch.covers(point, spacing)
}

/// Lists those of the rows that are due for a change, in their order.
fn find_due<R: Real, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    rows: Range<usize>,
    due: &mut Vec<Change>,
) {
    due.clear();
    for row in rows {
        if let Some((zone, patch)) = due_change(scene, arrays, row) {
            due.push(Change { row, zone, patch });
        }
    }
}

#[inline]
fn due_change<R: Real, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> Option<(Zone, u16)> {
    let patch = arrays.patch[row];
    let point = arrays.position_of(row);
    match arrays.zone[row] {
        Zone::Wall | Zone::Reservoir => None,
        Zone::Fluid => {
            let back = scene.inlets.iter().position(|inlet| {
                let along = inlet.patch.along(point);
                along < 0.0 && through(&inlet.patch, point, scene.spacing, -along)
            });
            let out = scene.outlets.iter().position(|outlet| {
                let along = outlet.patch.along(point);
                along >= 0.0 && through(&outlet.patch, point, scene.spacing, along)
            });
            match (back, out) {
                (Some(inlet), _) => Some((Zone::Inflow, inlet as u16)),
                (_, Some(outlet)) => Some((Zone::Outflow, outlet as u16)),
                _ => None,
            }
        }
        Zone::Inflow => {
            let inlet = &scene.inlets[usize::from(patch)].patch;
            let along = inlet.along(point);
            if along >= 0.0 {
                Some((Zone::Fluid, patch))
            } else if along < -inlet.depth {
                Some((Zone::Reservoir, patch))
            } else {
                None
            }
        }
        Zone::Outflow => {
            let outlet = &scene.outlets[usize::from(patch)].patch;
            let along = outlet.along(point);
            if along < 0.0 {
                Some((Zone::Fluid, patch))
            } else if along > outlet.depth {
                Some((Zone::Reservoir, patch))
            } else {
                None
            }
        }
    }
}

fn apply<R: Real, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    change: &Change,
    entries: &mut Vec<Entry>,
) {
    let row = change.row;
    let (from, id) = (arrays.zone[row], arrays.id[row]);
    let point = arrays.position_of(row);
    let patch = usize::from(change.patch);
    let seat = world.resource::<Seats>().0[id as usize];
    let returned = world.entity(seat).contains::<Returned>();
    let mut ledger = world.resource_mut::<Ledger>();
    ledger.by_zone[from as usize] -= 1;
    ledger.by_zone[change.zone as usize] += 1;
    match (from, change.zone) {
        (Zone::Inflow, Zone::Fluid) => {
            ledger.entered[patch] += 1;
            let Inlet { patch: inlet, feed, .. } = &scene.inlets[patch];
            let (velocity, zone, patch) = (arrays.velocity_of(row), Zone::Inflow, change.patch);
            if *feed == Feed::Once {
                let places = world.resource::<PatchRows>().inflow_places(arrays, patch);
                if is_drained(inlet, scene, point, places.filter(|at| *at != point)) {
                    world.resource_mut::<Failure>().drained = Some(patch);
                }
            } else if is_slantwise(inlet) {
                // The row that crossed is no longer in its zone.
                arrays.zone[row] = Zone::Fluid;
                let behind = InflowRow::of(inlet, point, scene.spacing);
                let last = last_of_row(world, arrays, entries, patch, |at| {
                    behind.holds(inlet, at).then(|| inlet.along(at))
                });
                let last = last.unwrap_or(inlet.along(point));
                let places = behind.vacancies(inlet, last);
                entries.extend(places.map(|place| Entry { place, zone, patch, velocity, again: false }));
            } else {
                let place = point - inlet.towards * inlet.depth;
                entries.push(Entry { place, zone, patch, velocity, again: returned });
            }
        }
        (Zone::Outflow, Zone::Fluid) => {
            ledger.left_back[patch] += 1;
            let outlet = &scene.outlets[patch].patch;
            entries.push(Entry {
                place: point + outlet.towards * outlet.depth,
                zone: Zone::Outflow,
                patch: change.patch,
                velocity: arrays.velocity_of(row),
                again: true,
            });
        }
        (_, Zone::Inflow) => ledger.entered_back[patch] += 1,
        (_, Zone::Outflow) => ledger.left[patch] += 1,
        _ => {}
    }
    arrays.zone[row] = change.zone;
    arrays.patch[row] = if change.zone == Zone::Fluid { 0 } else { change.patch };
    arrays.fresh[row] = true;
    if change.zone == Zone::Fluid {
        arrays.wall_distance[row] = R::from_f64(f64::INFINITY);
    }
    let mut entity = world.entity_mut(seat);
    match from {
        Zone::Fluid => entity.remove::<Fluid>(),
        Zone::Inflow => entity.remove::<(Inflow, Returned)>(),
        Zone::Outflow => entity.remove::<Outflow>(),
        Zone::Wall | Zone::Reservoir => &mut entity,
    };
    match change.zone {
        Zone::Fluid => entity.insert(Fluid),
        Zone::Inflow => entity.insert((Inflow { inlet: change.patch }, Returned)),
        Zone::Outflow => entity.insert(Outflow { outlet: change.patch }),
        // The arrays drop the row at the next sort. What its components still hold depends on who looked last.
        Zone::Wall | Zone::Reservoir => entity.insert((stored(scene, id, point), Reservoir)),
    };
    if change.zone == Zone::Reservoir {
        if let Some(mut stress) = entity.get_mut::<SpsStress>() {
            *stress = SpsStress::default();
        }
        set_real_vector(&mut arrays.velocity, row, DVec3::ZERO);
        world.resource_mut::<Stored>().0.push(id);
    }
}

/// The least of `along` over the inflow particles of an inlet, those among the entries to come included.
fn last_of_row<R: Real, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    entries: &[Entry],
    inlet: u16,
    along: impl Fn(DVec3) -> Option<f64>,
) -> Option<f64> {
    let coming = entries.iter().filter(|entry| entry.zone == Zone::Inflow && entry.patch == inlet);
    let places =
        world.resource::<PatchRows>().inflow_places(arrays, inlet).chain(coming.map(|entry| entry.place));
    places.filter_map(along).min_by(f64::total_cmp)
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

fn enter<R: Real, const D: usize>(
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
    let Some(id) = take_stored(world, scene) else { return };
    let clock = *world.resource::<Clock>();
    let (velocity, pressure) = match entry.zone {
        Zone::Inflow => {
            let inlet = &scene.inlets[usize::from(entry.patch)];
            (inlet_velocity(inlet, scene.fluid.viscosity, entry.place, clock.time), 0.0)
        }
        // As its partner at the plane: between the two the column moves as one.
        _ => (entry.velocity, 0.0),
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
        density: scene.fluid.tait().density(pressure),
        pressure,
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

/// State of a particle at rest in the reservoir, but for what it keeps: tag and passages.
fn stored(scene: &Scene, id: u32, position: DVec3) -> impl Bundle {
    (
        ParticleId(id),
        Position(position),
        Velocity(DVec3::ZERO),
        Thermodynamics { density: scene.fluid.density, pressure: 0.0 },
    )
}

/// The number of a stored particle, or of a new one if the reservoir is empty and may grow.
fn take_stored(world: &mut World, scene: &Scene) -> Option<u32> {
    if let Some(id) = world.resource_mut::<Stored>().0.pop() {
        return Some(id);
    }
    if scene.reservoir.when_empty == WhenEmpty::Stop {
        world.resource_mut::<Failure>().reservoir_empty = true;
        return None;
    }
    let id = world.resource::<Seats>().0.len() as u32;
    let mut entity = world.spawn((stored(scene, id, DVec3::ZERO), Tracer::default(), Reservoir));
    if scene.scheme.has_stress() {
        entity.insert(SpsStress::default());
    }
    let entity = entity.id();
    world.resource_mut::<Seats>().0.push(entity);
    let mut ledger = world.resource_mut::<Ledger>();
    ledger.grown += 1;
    ledger.by_zone[Zone::Reservoir as usize] += 1;
    Some(id)
}
