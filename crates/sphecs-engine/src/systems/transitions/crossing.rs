//! Particles that cross a plane.

use bevy_ecs::world::World;
use glam::DVec3;

use super::injection::Injection;
use crate::resources::grid::Grid;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::pair::Pair;
use crate::systems::boundaries::inflow_columns::InflowColumns;
use crate::systems::boundaries::patch_rows::PatchRows;
use sphecs_core::boundary::inlet::Feed;
use sphecs_core::boundary::inlet::injection::{InflowLine, is_drained};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::with_lists;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::{Inlet, Patch, Scene};

/// Change of zone that a row has to make.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Change {
    pub row: usize,
    pub zone: Zone,
    pub patch: u16,
}

/// A particle that changed its zone.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Crossing {
    /// Number of the particle.
    pub id: u32,
    /// Zone before, and its inlet, emitter or outlet.
    pub from: Zone,
    pub opening: u16,
    /// Zone after, and the inlet, emitter or outlet that the particle crossed.
    pub zone: Zone,
    pub patch: u16,
    /// Position, m.
    pub point: DVec3,
    /// True if it was the last particle of an inlet that is filled once.
    pub drains: bool,
    /// Number of injections that it causes.
    pub injections: u32,
    /// Cell at the last sort, by which several ranks order what they found.
    pub cell: u32,
}

/// Finds the rows that crossed a plane and changes their zone in the arrays; lists the crossings,
/// in the order of the rows, and their injections.
pub(super) fn find_crossings<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    changes: &mut Vec<Vec<Change>>,
    (crossings, injections): (&mut Vec<Crossing>, &mut Vec<Injection>),
) {
    crossings.clear();
    injections.clear();
    let near = &world.resource::<PatchRows>().near;
    let columns = world.resource::<InflowColumns>();
    let changes = with_lists(near.count(), changes, &|among, due| {
        find_due((scene, columns), arrays, near.rows(among), due);
    });
    for change in changes.iter().flatten() {
        crossings.push(cross(world, scene, arrays, change, injections));
    }
}

/// Changes the zone of a row in the arrays, and lists the injections that this causes.
fn cross<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    change: &Change,
    injections: &mut Vec<Injection>,
) -> Crossing {
    let &Change { row, zone, patch } = change;
    let before = injections.len();
    let mut crossing = Crossing {
        id: arrays.id[row],
        from: arrays.zone[row],
        opening: arrays.patch[row],
        zone,
        patch,
        point: arrays.position_of(row),
        ..Crossing::default()
    };
    match (crossing.from, zone) {
        (Zone::Inflow, Zone::Fluid) => {
            crossing.drains = follow_inflow(world, scene, arrays, change, injections);
        }
        (Zone::Outflow, Zone::Fluid) => injections.push(follow_backflow(scene, arrays, change)),
        _ => {}
    }
    crossing.injections = (injections.len() - before) as u32;
    if world.resource::<Pair>().0.ranks.size() > 1 {
        let starts = world.resource::<Grid<D>>().0.starts();
        crossing.cell = starts.partition_point(|&start| start as usize <= row) as u32 - 1;
    }
    set_zone(arrays, change);
    if matches!(zone, Zone::Wall | Zone::Reservoir) {
        set_real_vector(&mut arrays.velocity, row, DVec3::ZERO);
    }
    crossing
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

/// Lists the injections upstream of an inlet after one of its particles entered the fluid; returns
/// true if an inlet that is filled once, which has none, is drained.
fn follow_inflow<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    change: &Change,
    injections: &mut Vec<Injection>,
) -> bool {
    let patch = change.patch;
    let point = arrays.position_of(change.row);
    let Inlet { patch: inlet, feed, .. } = &scene.inlets[usize::from(patch)];
    if *feed == Feed::Once {
        let places = world.resource::<PatchRows>().inflow_positions(arrays, patch);
        let lengths = (scene.spacing, scene.discretisation.support);
        return is_drained(inlet, lengths, point, places.filter(|at| *at != point));
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
        let returned = world.resource::<InflowParticles>().has_returned(arrays.id[change.row]);
        injections.push(injection(point - inlet.towards * (stretch * inlet.depth), returned));
    }
    false
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

/// Changes the zone of a row in the arrays.
pub(super) fn set_zone<R: PairReal<D>, const D: usize>(arrays: &mut ParticleArrays<R, D>, change: &Change) {
    let row = change.row;
    arrays.zone[row] = change.zone;
    arrays.patch[row] = if change.zone == Zone::Fluid { 0 } else { change.patch };
    arrays.needs_restart[row] = true;
    if change.zone == Zone::Fluid {
        arrays.wall_distance[row] = R::from_f64(f64::INFINITY);
    }
}
