//! Changes of zone; no other system changes the role of a particle.
//!
//! - `emission`: particles that cross the surfaces of emitters
//! - `injection`: injection of a particle into a zone
//! - `refill`: injections that wait for a free position
//! - `reservoir`: storage and creation of particles
//!
//! ```text
//! Inflow → Fluid       across the inlet plane; a stored particle is injected upstream
//! Fluid → Inflow       back across the inlet plane
//! Inflow → Reservoir   beyond the upstream end of the zone
//! Fluid → Outflow      across the outlet plane
//! Outflow → Fluid      back across the outlet plane; a stored particle is injected at x + L n
//! Outflow → Reservoir  beyond the downstream end of the zone, with zero velocity
//! ```
//!
//! The transitions are those of Alvarado-Rodríguez et al. (2017), Fig. 1 and Sec. 4, who do not
//! treat backflow. A particle that oscillates across a plane would inject a particle at each
//! crossing (test `oscillation_across_a_plane_injects_once`). For a particle that returned, an
//! injection therefore needs a free position within half a spacing. At an inlet the zone must also
//! have lost particles at its upstream end. All other crossings always inject, since an omitted
//! injection would leave a permanent gap in the zone. At an outlet that expects backflow an
//! injection waits until its position is free. An oblique inlet keeps its lines of particles
//! as long as its zone. An inlet that is filled once injects nothing, and the run stops when it is
//! drained.

mod emission;
pub(crate) mod injection;
pub(crate) mod refill;
pub(crate) mod reservoir;

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;
use glam::DVec3;

use super::boundaries::inflow_columns::InflowColumns;
use super::boundaries::patch_rows::PatchRows;
use super::divergence::Failure;
use crate::arrays::Arrays;
use crate::components::{Fluid, Inflow, Outflow};
use crate::resources::entity_index::EntityIndex;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::Ledger;
use crate::resources::scene::ActiveScene;
use emission::emit;
use injection::{Injection, inject};
use refill::{defer, refill};
use reservoir::store;
use sphecs_core::boundary::inlet::Feed;
use sphecs_core::boundary::inlet::injection::{InflowLine, is_drained};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part, with_lists};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::{Inlet, Patch, Scene};

/// Change of zone that a row has to make.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Change {
    row: usize,
    zone: Zone,
    patch: u16,
}

/// Lists of a transition, reused from step to step.
#[derive(Resource, Debug, Default)]
pub struct TransitionLists {
    /// Changes of each part of the rows.
    changes: Vec<Vec<Change>>,
    injections: Vec<Injection>,
}

/// Finds the rows that crossed a plane, and changes their roles in components and arrays.
pub(crate) fn transition<R: PairReal<D>, const D: usize>(world: &mut World) {
    let scene = world.resource::<ActiveScene>().0.clone();
    if scene.source_count() == 0 && scene.outlets.is_empty() {
        wrap_periodic::<R, D>(world, &scene);
        return;
    }
    world.resource_scope(|world, mut arrays: Mut<Arrays<R, D>>| {
        world.resource_scope(|world, mut lists: Mut<TransitionLists>| {
            let TransitionLists { changes, injections } = &mut *lists;
            let near = &world.resource::<PatchRows>().near;
            let columns = world.resource::<InflowColumns>();
            let changes = with_lists(near.count(), changes, &|among, due| {
                find_due((&scene, columns), &arrays, near.rows(among), due);
            });
            for change in changes.iter().flatten() {
                apply(world, &scene, &mut arrays, change, injections);
            }
            for injection in injections.drain(..) {
                if !inject(world, &scene, &mut arrays, &injection) {
                    defer::<R, D>(world, injection);
                }
            }
            refill(world, &scene, &mut arrays);
            emit(world, &scene, &mut arrays);
        });
    });
    wrap_periodic::<R, D>(world, &scene);
}

/// Moves rows that left the domain in a periodic direction by one period.
fn wrap_periodic<R: PairReal<D>, const D: usize>(world: &mut World, scene: &Scene) {
    let mut arrays = world.resource_mut::<Arrays<R, D>>();
    for axis in 0..D {
        let Some((lower, upper)) = scene.periodic[axis] else { continue };
        let period = upper - lower;
        let column = arrays.position[axis].as_mut_slice();
        for_each_part(0..column.len(), column, &|_, column| {
            for group in column.chunks_mut(GROUP) {
                // Nearly all rows are inside; this check confirms it without branches.
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

/// Returns true if a point at the distance `beyond`, m, behind the plane of a patch is in its zone
/// or in front of it.
fn is_through(patch: &Patch, point: DVec3, spacing: f64, beyond: f64) -> bool {
    beyond < patch.depth && patch.covers(point, spacing)
}

/// Lists the rows that have to change zone, in their order.
fn find_due<R: PairReal<D>, const D: usize>(
    (scene, columns): (&Scene, &InflowColumns),
    arrays: &ParticleArrays<R, D>,
    rows: impl Iterator<Item = usize>,
    due: &mut Vec<Change>,
) {
    due.clear();
    for row in rows {
        if let Some((zone, patch)) = due_change((scene, columns), arrays, row) {
            due.push(Change { row, zone, patch });
        }
    }
}

/// Returns the zone and the patch that a row has to change to.
#[inline]
fn due_change<R: PairReal<D>, const D: usize>(
    (scene, columns): (&Scene, &InflowColumns),
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
                along < 0.0 && is_through(&inlet.patch, point, scene.spacing, -along)
            });
            let out = scene.outlets.iter().position(|outlet| {
                let along = outlet.patch.along(point);
                along >= 0.0 && is_through(&outlet.patch, point, scene.spacing, along)
            });
            match (back, out) {
                (Some(inlet), _) => Some((Zone::Inflow, inlet as u16)),
                (_, Some(outlet)) => Some((Zone::Outflow, outlet as u16)),
                _ => None,
            }
        }
        Zone::Inflow => {
            // Those of an emitter cross in the order of their columns: see `emission`.
            let inlet = &scene.inlets.get(usize::from(patch))?.patch;
            let along = inlet.along(point);
            if along >= 0.0 {
                Some((Zone::Fluid, patch))
            } else if along < -columns.stretch(usize::from(patch)) * inlet.depth {
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

/// Changes the zone of a row in the particle counts, the arrays and the components.
fn apply<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    change: &Change,
    injections: &mut Vec<Injection>,
) {
    let row = change.row;
    let (from, id) = (arrays.zone[row], arrays.id[row]);
    let point = arrays.position_of(row);
    count_crossing(&mut world.resource_mut::<Ledger>(), from, change);
    match (from, change.zone) {
        (Zone::Inflow, Zone::Fluid) => {
            let returned = world.resource::<InflowParticles>().has_returned(id);
            follow_inflow(world, scene, arrays, change, returned, injections);
        }
        (Zone::Outflow, Zone::Fluid) => injections.push(follow_backflow(scene, arrays, change)),
        _ => {}
    }
    let patch = arrays.patch[row];
    set_zone(arrays, change);
    change_role(world, id, (from, patch), change);
    if matches!(change.zone, Zone::Wall | Zone::Reservoir) {
        set_real_vector(&mut arrays.velocity, row, DVec3::ZERO);
        store(world, scene, id, point);
    }
}

/// Counts a change of zone.
fn count_crossing(ledger: &mut Ledger, from: Zone, change: &Change) {
    ledger.by_zone[from as usize] -= 1;
    ledger.by_zone[change.zone as usize] += 1;
    let patch = usize::from(change.patch);
    match (from, change.zone) {
        (Zone::Inflow, Zone::Fluid) => ledger.entered[patch] += 1,
        (Zone::Outflow, Zone::Fluid) => ledger.left_back[patch] += 1,
        (_, Zone::Inflow) => ledger.entered_back[patch] += 1,
        (_, Zone::Outflow) => ledger.left[patch] += 1,
        _ => {}
    }
}

/// Lists the injections upstream of an inlet after one of its particles entered the fluid.
///
/// At an inlet that is filled once, records instead whether it is drained.
fn follow_inflow<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    change: &Change,
    returned: bool,
    injections: &mut Vec<Injection>,
) {
    let patch = change.patch;
    let point = arrays.position_of(change.row);
    let Inlet { patch: inlet, feed, .. } = &scene.inlets[usize::from(patch)];
    if *feed == Feed::Once {
        let places = world.resource::<PatchRows>().inflow_positions(arrays, patch);
        let lengths = (scene.spacing, scene.discretisation.support);
        if is_drained(inlet, lengths, point, places.filter(|at| *at != point)) {
            world.resource_mut::<Failure>().drained = Some(patch);
        }
        return;
    }
    let velocity = arrays.velocity_of(change.row);
    let stretch = world.resource::<InflowColumns>().stretch(usize::from(patch));
    let injection = |place: DVec3, returned: bool| Injection {
        place,
        zone: Zone::Inflow,
        patch,
        velocity,
        pressure: 0.0,
        returned,
    };
    if scene.layout.fill.is_oblique(inlet.towards) {
        // The particle that crossed no longer counts in its line.
        arrays.zone[change.row] = Zone::Fluid;
        let line = InflowLine::of(inlet, point, scene.spacing);
        let last = last_upstream(world, arrays, injections, patch, |at| {
            line.holds(inlet, at).then(|| inlet.along(at))
        });
        let last = last.unwrap_or(inlet.along(point));
        injections.extend(line.vacancies(inlet, last, stretch).map(|place| injection(place, false)));
    } else {
        injections.push(injection(point - inlet.towards * (stretch * inlet.depth), returned));
    }
}

/// Returns the injection at the downstream end of an outflow zone after one of its particles
/// entered the fluid. Under `Wcsph` the length of the zone belongs to its density.
fn follow_backflow<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    change: &Change,
) -> Injection {
    let outlet = &scene.outlets[usize::from(change.patch)].patch;
    let stretch = match scene.scheme.wcsph() {
        Some(_) => scene.fluid.density / arrays.density[change.row].to_f64(),
        None => 1.0,
    };
    Injection {
        place: arrays.position_of(change.row) + outlet.towards * (stretch * outlet.depth),
        zone: Zone::Outflow,
        patch: change.patch,
        velocity: arrays.velocity_of(change.row),
        pressure: arrays.pressure[change.row].to_f64(),
        returned: true,
    }
}

/// Changes the zone of a row in the arrays.
fn set_zone<R: PairReal<D>, const D: usize>(arrays: &mut ParticleArrays<R, D>, change: &Change) {
    let row = change.row;
    arrays.zone[row] = change.zone;
    arrays.patch[row] = if change.zone == Zone::Fluid { 0 } else { change.patch };
    arrays.needs_restart[row] = true;
    if change.zone == Zone::Fluid {
        arrays.wall_distance[row] = R::from_f64(f64::INFINITY);
    }
}

/// Changes the role of a particle, which it had with an opening, in its components, except for the
/// role of a stored particle.
fn change_role(world: &mut World, id: u32, (from, opening): (Zone, u16), change: &Change) {
    let mut inflow = world.resource_mut::<InflowParticles>();
    if from == Zone::Inflow {
        inflow.remove(id, opening);
    }
    if change.zone == Zone::Inflow {
        inflow.add_returned(id);
    }
    let Some(entity) = world.resource::<EntityIndex>().get(id) else { return };
    let mut entity = world.entity_mut(entity);
    match from {
        Zone::Fluid => entity.remove::<Fluid>(),
        Zone::Inflow => entity.remove::<Inflow>(),
        Zone::Outflow => entity.remove::<Outflow>(),
        Zone::Wall | Zone::Reservoir => &mut entity,
    };
    match change.zone {
        Zone::Fluid => entity.insert(Fluid),
        Zone::Inflow => entity.insert(Inflow { inlet: change.patch }),
        Zone::Outflow => entity.insert(Outflow { outlet: change.patch }),
        Zone::Wall | Zone::Reservoir => &mut entity,
    };
}

/// Returns the smallest `along` of the inflow particles of an inlet, pending injections included.
fn last_upstream<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    injections: &[Injection],
    inlet: u16,
    along: impl Fn(DVec3) -> Option<f64>,
) -> Option<f64> {
    let pending = injections.iter().filter(|entry| entry.zone == Zone::Inflow && entry.patch == inlet);
    let places =
        world.resource::<PatchRows>().inflow_positions(arrays, inlet).chain(pending.map(|entry| entry.place));
    places.filter_map(along).min_by(f64::total_cmp)
}
