//! Particles change zone: the only place where roles change during a run.
//!
//! - [`entry`]: a particle enters a zone
//! - [`stock`]: where particles that leave go to, and where those that enter come from
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

pub mod entry;
pub mod stock;

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;

use super::boundaries::entrance::{InflowRow, is_drained, is_slantwise};
use super::boundaries::rows::PatchRows;
use super::failure::Failure;
use super::ledger::Ledger;
use super::setup::{SceneInUse, Seats};
use crate::arrays::Arrays;
use crate::components::{Fluid, Inflow, Outflow, Returned};
use entry::{Entry, enter};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part, with_lists};
use sphecs_core::physics::inlet::Feed;
use sphecs_scene::model::{Inlet, Patch, Scene};
use stock::leave;

/// A change of zone that a row is due for.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    row: usize,
    zone: Zone,
    patch: u16,
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
    world.resource_scope(|world, mut arrays: Mut<Arrays<R, D>>| {
        world.resource_scope(|world, mut lists: Mut<TransitionLists>| {
            let TransitionLists { changes, entries } = &mut *lists;
            let near = &world.resource::<PatchRows>().near;
            let changes = with_lists(near.count(), changes, &|among, due| {
                find_due(&scene, &arrays, near.rows(among), due);
            });
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
    let mut arrays = world.resource_mut::<Arrays<R, D>>();
    for axis in 0..D {
        let Some((lower, upper)) = scene.periodic[axis] else { continue };
        let period = upper - lower;
        let column = arrays.position[axis].as_mut_slice();
        for_each_part(0..column.len(), column, &|_, column| {
            for group in column.chunks_mut(GROUP) {
                // A glance without branches: nearly all are inside.
                if group.iter().fold(true, |inside, x| inside & (*x >= lower) & (*x < upper)) {
                    continue;
                }
                for x in group {
                    if *x < lower {
                        *x += period;
                    } else if *x >= upper {
                        *x -= period;
                    }
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
    rows: impl Iterator<Item = usize>,
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
                entries.extend(places.map(|place| Entry {
                    place,
                    zone,
                    patch,
                    velocity,
                    pressure: 0.0,
                    again: false,
                }));
            } else {
                let place = point - inlet.towards * inlet.depth;
                entries.push(Entry { place, zone, patch, velocity, pressure: 0.0, again: returned });
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
                pressure: arrays.pressure[row].to_f64(),
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
        Zone::Fluid => {
            entity.insert(Fluid);
        }
        Zone::Inflow => {
            entity.insert((Inflow { inlet: change.patch }, Returned));
        }
        Zone::Outflow => {
            entity.insert(Outflow { outlet: change.patch });
        }
        Zone::Wall | Zone::Reservoir => {
            set_real_vector(&mut arrays.velocity, row, DVec3::ZERO);
            leave(world, scene, id, point);
        }
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
