//! Outcomes of the injections of a step, and of those that wait.

use bevy_ecs::world::World;
use glam::DVec3;

use super::exchange::share_outcomes;
use super::injection::{Injection, place};
use super::refill::WaitingInjections;
use crate::resources::grid::Grid;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::InflowCapacity;
use crate::systems::boundaries::opening_regions::OpeningRegions;
use crate::systems::boundaries::outlets::Outlets;
use crate::systems::boundaries::patch_rows::PatchRows;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::neighbours::Neighbours;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Smallest distance, over the spacing, from an injected particle to the others: closer pairs would
/// clump.
const MIN_DISTANCE: f64 = 0.5;

/// Smallest such distance for an injection that waited: that of a line whose spacing disorder has
/// shortened.
const MIN_DISTANCE_OF_REFILL: f64 = 0.8;

/// Outcome of an injection in a step.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub(super) enum Outcome {
    /// The particle is placed at once.
    Placed,
    /// The particle is placed at the end of its zone, after those that are placed at once.
    Refilled,
    /// Its position is taken.
    Waits,
    /// Its zone is full, or the condition of its outlet expects no backflow.
    Dropped,
}

impl Outcome {
    /// All outcomes in the order of their numbers.
    pub(super) const ALL: [Self; 4] = [Self::Placed, Self::Refilled, Self::Waits, Self::Dropped];
}

/// Outcomes of a step, kept so that finding them allocates nothing.
#[derive(Debug, Default)]
pub(super) struct Outcomes {
    /// Outcomes of the injections, then of those that waited.
    all: Vec<Outcome>,
    /// Injections whose particle is placed.
    accepted: Vec<Injection>,
}

/// Makes injections if their position is free and the reservoir has a particle, and those that
/// waited for a free position.
pub(super) fn inject<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
    injections: &[Injection],
    outcomes: &mut Outcomes,
) {
    let mut waiting = std::mem::take(&mut world.resource_mut::<WaitingInjections>().waiting);
    if injections.is_empty() && waiting.is_empty() {
        return;
    }
    outcomes.find(world, scene, arrays, injections, &waiting);
    share_outcomes(world, injections, &waiting, &mut outcomes.all);
    let (of_injections, of_waiting) = outcomes.all.split_at(injections.len());
    let now = injections.iter().zip(of_injections).filter(|(_, outcome)| **outcome == Outcome::Placed);
    for (injection, _) in now {
        place(world, scene, arrays, injection);
    }
    let later = injections.iter().zip(of_injections).filter(|(_, outcome)| **outcome != Outcome::Placed);
    waiting.extend(later.clone().map(|(injection, _)| *injection));
    let mut outcomes = of_waiting.iter().chain(later.map(|(_, outcome)| outcome)).copied();
    waiting.retain(|injection| {
        let outcome = outcomes.next();
        if outcome == Some(Outcome::Refilled) {
            place(world, scene, arrays, &at_end(scene, injection));
        }
        outcome == Some(Outcome::Waits)
    });
    world.resource_mut::<WaitingInjections>().waiting = waiting;
}

impl Outcomes {
    /// Finds the outcomes at openings of which this rank has the particles.
    fn find<R: PairReal<D>, const D: usize>(
        &mut self,
        world: &World,
        scene: &Scene,
        arrays: &ParticleArrays<R, D>,
        injections: &[Injection],
        waiting: &[Injection],
    ) {
        let Self { all, accepted } = self;
        accepted.clear();
        all.clear();
        all.resize(injections.len(), Outcome::Placed);
        all.resize(injections.len() + waiting.len(), Outcome::Waits);
        let openings = world.resource::<OpeningRegions>();
        let is_here = |injection: &Injection| openings.has(injection.zone, injection.patch);
        let needs = world.resource::<Outlets<R, D>>().needs();
        for (injection, outcome) in injections.iter().zip(&mut *all) {
            if !is_here(injection) {
                continue;
            }
            let is_one_way =
                injection.zone == Zone::Outflow && needs[usize::from(injection.patch)].is_one_way;
            if !injection.returned || is_possible(world, scene, (arrays, accepted), injection) {
                accepted.push(*injection);
            } else {
                *outcome = if is_one_way { Outcome::Dropped } else { Outcome::Waits };
            }
        }
        // Those that waited before come first.
        let (of_injections, of_waiting) = all.split_at_mut(injections.len());
        let deferred =
            injections.iter().zip(of_injections).filter(|(_, outcome)| **outcome == Outcome::Waits);
        for (injection, outcome) in waiting.iter().zip(of_waiting).chain(deferred) {
            if is_here(injection) {
                *outcome = refill(world, scene, (arrays, accepted), injection);
            }
        }
    }
}

/// Returns an injection at the far end of its zone: the zone has moved since it was listed, but not
/// its end.
fn at_end(scene: &Scene, injection: &Injection) -> Injection {
    let patch = usize::from(injection.patch);
    let (opening, end) = if injection.zone == Zone::Inflow {
        let opening = &scene.inlets[patch].patch;
        (opening, -opening.depth)
    } else {
        let opening = &scene.outlets[patch].patch;
        (opening, opening.depth)
    };
    let place = injection.place + opening.towards * (end - opening.along(injection.place));
    Injection { place, ..*injection }
}

/// Finds the outcome of an injection that waits, and lists it if its particle is placed.
fn refill<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    (arrays, accepted): (&ParticleArrays<R, D>, &mut Vec<Injection>),
    injection: &Injection,
) -> Outcome {
    let patch = usize::from(injection.patch);
    let full = match injection.zone {
        Zone::Inflow => world.resource::<InflowCapacity>().0[patch],
        _ => world.resource::<WaitingInjections>().capacity[patch],
    };
    if present(world, arrays, injection) + count(accepted, injection) >= full {
        return Outcome::Dropped;
    }
    let injection = at_end(scene, injection);
    if !is_free(world, (arrays, accepted), injection.place, MIN_DISTANCE_OF_REFILL * scene.spacing) {
        return Outcome::Waits;
    }
    accepted.push(injection);
    Outcome::Refilled
}

/// Returns the number of particles that the zone of an injection had before it. A particle that
/// left the fluid in this step is counted from the next sort on.
fn present<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    injection: &Injection,
) -> u64 {
    let rows = world.resource::<PatchRows>();
    let of_zone = if injection.zone == Zone::Inflow { &rows.inflow } else { &rows.outflow };
    let rows = of_zone[usize::from(injection.patch)].iter().map(|&row| row as usize);
    let is_of_zone = |&row: &usize| {
        let (zone, patch) = (arrays.zone[row], arrays.patch[row]);
        (zone, patch) == (injection.zone, injection.patch)
    };
    rows.filter(is_of_zone).count() as u64
}

/// Returns the number of injections into the zone of another one.
fn count(accepted: &[Injection], injection: &Injection) -> u64 {
    let same = |other: &&Injection| (other.zone, other.patch) == (injection.zone, injection.patch);
    accepted.iter().filter(same).count() as u64
}

/// Returns true if the position of an injection is free and, at an inlet, the zone has lost
/// particles.
fn is_possible<R: PairReal<D>, const D: usize>(
    world: &World,
    scene: &Scene,
    (arrays, accepted): (&ParticleArrays<R, D>, &[Injection]),
    injection: &Injection,
) -> bool {
    if injection.zone == Zone::Inflow {
        // Those that returned from the fluid do not count.
        let others = world.resource::<InflowParticles>().others(injection.patch);
        let full = world.resource::<InflowCapacity>().0[usize::from(injection.patch)];
        if others + count(accepted, injection) >= full {
            return false;
        }
    }
    is_free(world, (arrays, accepted), injection.place, MIN_DISTANCE * scene.spacing)
}

/// Returns true if no particle is within `distance`, m, of a position, nor will be by an injection.
fn is_free<R: PairReal<D>, const D: usize>(
    world: &World,
    (arrays, accepted): (&ParticleArrays<R, D>, &[Injection]),
    place: DVec3,
    distance: f64,
) -> bool {
    let mut free = true;
    // Since the sort, positions changed by less than the difference of the support and `distance`.
    let neighbours = Neighbours::new(&world.resource::<Grid<D>>().0, arrays);
    neighbours.for_each(std::array::from_fn(|axis| place[axis]), |row, _, r_squared| {
        free &= arrays.zone[row] == Zone::Reservoir || r_squared > distance * distance;
    });
    free && accepted.iter().all(|other| other.place.distance_squared(place) > distance * distance)
}
