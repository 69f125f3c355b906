//! Changes of zone; no other system changes the role of a particle.
//!
//! - `crossing`: particles that cross a plane
//! - `emission`: particles that cross the surfaces of emitters
//! - `exchange`: crossings and outcomes that several ranks tell each other
//! - `injection`: injection of a particle into a zone
//! - `outcome`: outcomes of the injections of a step
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
//!
//! Of several ranks, the members of a region find what happens at its openings. All ranks count it,
//! in the order of one rank: numbers of particles and the reservoir are the same on all of them.

mod crossing;
mod emission;
mod exchange;
pub(crate) mod injection;
mod outcome;
pub(crate) mod refill;
pub(crate) mod reservoir;

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;

use super::divergence::Failure;
use crate::arrays::Arrays;
use crate::components::{Fluid, Inflow, Outflow};
use crate::resources::entity_index::EntityIndex;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::Ledger;
use crate::resources::scene::ActiveScene;
use crossing::{Change, Crossing, find_crossings};
use emission::emit;
use exchange::share_crossings;
use injection::Injection;
use outcome::{Outcomes, inject};
use reservoir::store;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::{GROUP, for_each_part};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Lists of a transition, reused from step to step.
#[derive(Resource, Debug, Default)]
pub struct TransitionLists {
    /// Changes of each part of the rows.
    changes: Vec<Vec<Change>>,
    crossings: Vec<Crossing>,
    injections: Vec<Injection>,
    outcomes: Outcomes,
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
            let TransitionLists { changes, crossings, injections, outcomes } = &mut *lists;
            find_crossings(world, &scene, &mut arrays, changes, (crossings, injections));
            share_crossings::<R, D>(world, &scene, (crossings, injections));
            for crossing in &*crossings {
                record(world, &scene, crossing);
            }
            inject(world, &scene, &mut arrays, injections, outcomes);
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

/// Changes the zone of a particle in the particle counts and the components.
fn record(world: &mut World, scene: &Scene, crossing: &Crossing) {
    count_crossing(&mut world.resource_mut::<Ledger>(), crossing);
    if crossing.drains {
        world.resource_mut::<Failure>().drained = Some(crossing.patch);
    }
    change_role(world, crossing);
    if matches!(crossing.zone, Zone::Wall | Zone::Reservoir) {
        store(world, scene, crossing.id, crossing.point);
    }
}

/// Counts a change of zone.
fn count_crossing(ledger: &mut Ledger, crossing: &Crossing) {
    let Crossing { from, zone, .. } = *crossing;
    ledger.by_zone[from as usize] -= 1;
    ledger.by_zone[zone as usize] += 1;
    let patch = usize::from(crossing.patch);
    match (from, zone) {
        (Zone::Inflow, Zone::Fluid) => ledger.entered[patch] += 1,
        (Zone::Outflow, Zone::Fluid) => ledger.left_back[patch] += 1,
        (_, Zone::Inflow) => ledger.entered_back[patch] += 1,
        (_, Zone::Outflow) => ledger.left[patch] += 1,
        _ => {}
    }
}

/// Changes the role of a particle in its components, except for the role of a stored particle.
fn change_role(world: &mut World, crossing: &Crossing) {
    let Crossing { id, from, opening, zone, patch, .. } = *crossing;
    let mut inflow = world.resource_mut::<InflowParticles>();
    if from == Zone::Inflow {
        inflow.remove(id, opening);
    }
    if zone == Zone::Inflow {
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
    match zone {
        Zone::Fluid => entity.insert(Fluid),
        Zone::Inflow => entity.insert(Inflow { inlet: patch }),
        Zone::Outflow => entity.insert(Outflow { outlet: patch }),
        Zone::Wall | Zone::Reservoir => &mut entity,
    };
}
