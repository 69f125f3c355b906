//! Crossings and outcomes of injections that several ranks tell each other.
//!
//! The leader of each region sends what happened at its openings. All ranks bring it into the order
//! of one rank: that of the cells.

use bevy_ecs::world::World;
use glam::DVec3;

use super::crossing::Crossing;
use super::injection::Injection;
use super::outcome::Outcome;
use crate::resources::pair::Pair;
use crate::systems::boundaries::inflow_columns::InflowColumns;
use crate::systems::boundaries::opening_regions::OpeningRegions;
use crate::systems::boundaries::outlets::Outlets;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// A crossing in a message.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct CrossingMessage {
    point: [f64; 3],
    cell: u32,
    id: u32,
    injections: u32,
    opening: u16,
    patch: u16,
    from: u8,
    zone: u8,
    drains: u8,
    padding: [u8; 5],
}

/// An injection in a message.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct InjectionMessage {
    place: [f64; 3],
    velocity: [f64; 3],
    pressure: f64,
    patch: u16,
    zone: u8,
    returned: u8,
    padding: [u8; 4],
}

impl Crossing {
    /// Returns the zone of the opening that the particle crossed, with its inlet, emitter or
    /// outlet.
    fn crossed(&self) -> (Zone, u16) {
        match self.from {
            Zone::Inflow | Zone::Outflow => (self.from, self.opening),
            _ => (self.zone, self.patch),
        }
    }

    fn message(&self) -> CrossingMessage {
        let Self { id, from, opening, zone, patch, point, drains, injections, cell } = *self;
        CrossingMessage {
            point: point.to_array(),
            cell,
            id,
            injections,
            opening,
            patch,
            from: from as u8,
            zone: zone as u8,
            drains: u8::from(drains),
            padding: [0; 5],
        }
    }

    fn of(message: &CrossingMessage) -> Self {
        let CrossingMessage { point, cell, id, injections, opening, patch, from, zone, drains, .. } =
            *message;
        Self {
            id,
            from: Zone::from_number(from).unwrap_or_default(),
            opening,
            zone: Zone::from_number(zone).unwrap_or_default(),
            patch,
            point: DVec3::from_array(point),
            drains: drains != 0,
            injections,
            cell,
        }
    }
}

impl Injection {
    fn message(&self) -> InjectionMessage {
        let Self { place, zone, patch, velocity, pressure, returned } = *self;
        InjectionMessage {
            place: place.to_array(),
            velocity: velocity.to_array(),
            pressure,
            patch,
            zone: zone as u8,
            returned: u8::from(returned),
            padding: [0; 4],
        }
    }

    fn of(message: &InjectionMessage) -> Self {
        let InjectionMessage { place, velocity, pressure, patch, zone, returned, .. } = *message;
        Self {
            place: DVec3::from_array(place),
            zone: Zone::from_number(zone).unwrap_or_default(),
            patch,
            velocity: DVec3::from_array(velocity),
            pressure,
            returned: returned != 0,
        }
    }
}

/// Gives all ranks the crossings at all openings with the injections that they cause, and the
/// numbers of openings that are read after a step.
pub(super) fn share_crossings<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    (crossings, injections): (&mut Vec<Crossing>, &mut Vec<Injection>),
) {
    let ranks = world.resource::<Pair>().0.ranks.clone();
    if ranks.size() < 2 {
        return;
    }
    let openings = world.resource::<OpeningRegions>();
    let mut own = Vec::new();
    let mut rest = &injections[..];
    for crossing in &*crossings {
        let caused;
        (caused, rest) = rest.split_at(crossing.injections as usize);
        let (zone, patch) = crossing.crossed();
        if openings.leader(zone, patch) == ranks.rank() {
            own.extend_from_slice(bytemuck::bytes_of(&crossing.message()));
            caused.iter().for_each(|one| own.extend_from_slice(bytemuck::bytes_of(&one.message())));
        }
    }
    let lengths = share_numbers::<R, D>(world, scene, own.len());
    if lengths.iter().all(|&length| length == 0) {
        return;
    }
    let all = ranks.messages_of_all(&own, &lengths);
    let mut rest = &all[..];
    let mut found = Vec::new();
    let mut caused: Vec<Injection> = Vec::new();
    while !rest.is_empty() {
        let crossing = Crossing::of(&take(&mut rest));
        found.push((crossing, caused.len()));
        caused.extend((0..crossing.injections).map(|_| Injection::of(&take(&mut rest))));
    }
    // The crossings of a cell are all from one rank, in their order.
    found.sort_by_key(|(crossing, _)| crossing.cell);
    crossings.clear();
    injections.clear();
    for (crossing, first) in found {
        crossings.push(crossing);
        injections.extend_from_slice(&caused[first..first + crossing.injections as usize]);
    }
}

/// Takes a value from the beginning of a message.
fn take<T: bytemuck::Pod>(rest: &mut &[u8]) -> T {
    let (value, after) = rest.split_at(size_of::<T>());
    *rest = after;
    bytemuck::pod_read_unaligned(value)
}

/// Gives all ranks the flow next to the outlets and the compression of the inflow zones from the
/// leaders of their regions. Tells the others the length of a message, and returns those of all.
fn share_numbers<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    length: usize,
) -> Vec<usize> {
    let ranks = world.resource::<Pair>().0.ranks.clone();
    let outlets = &world.resource::<Outlets<R, D>>().all;
    let mut own = vec![[length as f64, 0.0]];
    own.extend(outlets.iter().map(|outlet| [outlet.adjacent.velocity, outlet.adjacent.pressure]));
    let columns = world.resource::<InflowColumns>();
    own.extend((0..scene.source_count()).map(|source| columns.numbers(source)));
    let all = ranks.values_of_all(&own);
    let openings = world.resource::<OpeningRegions>();
    let of = |leader: usize, at: usize| all[leader * own.len() + at];
    let before = 1 + outlets.len();
    let flows: Vec<[f64; 2]> =
        (0..outlets.len()).map(|outlet| of(openings.leader_of_outlet(outlet), 1 + outlet)).collect();
    let sources = 0..scene.source_count();
    let columns: Vec<[f64; 2]> =
        sources.map(|source| of(openings.leader_of_source(source), before + source)).collect();
    for (outlet, [velocity, pressure]) in world.resource_mut::<Outlets<R, D>>().all.iter_mut().zip(flows) {
        (outlet.adjacent.velocity, outlet.adjacent.pressure) = (velocity, pressure);
    }
    let mut own_columns = world.resource_mut::<InflowColumns>();
    columns.into_iter().enumerate().for_each(|(source, numbers)| own_columns.set_numbers(source, numbers));
    all.chunks_exact(own.len()).map(|numbers| numbers[0][0] as usize).collect()
}

/// Gives all ranks the outcomes of the injections and of those that waited.
pub(super) fn share_outcomes(
    world: &World,
    injections: &[Injection],
    waiting: &[Injection],
    outcomes: &mut [Outcome],
) {
    let ranks = &world.resource::<Pair>().0.ranks;
    if ranks.size() < 2 {
        return;
    }
    // All others are placed in any case.
    let is_open = |at: usize| at >= injections.len() || injections[at].returned;
    let openings = world.resource::<OpeningRegions>();
    let open: Vec<(usize, usize)> = (injections.iter().chain(waiting).enumerate())
        .filter(|(at, _)| is_open(*at))
        .map(|(at, injection)| (at, openings.leader(injection.zone, injection.patch)))
        .collect();
    if open.is_empty() {
        return;
    }
    let mut lengths = vec![0; ranks.size()];
    open.iter().for_each(|&(_, leader)| lengths[leader] += 1);
    let own = open.iter().filter(|(_, leader)| *leader == ranks.rank());
    let own: Vec<u8> = own.map(|&(at, _)| outcomes[at] as u8).collect();
    let all = ranks.messages_of_all(&own, &lengths);
    let mut next: Vec<usize> =
        lengths.iter().scan(0, |end, length| Some(std::mem::replace(end, *end + length))).collect();
    for (at, leader) in open {
        outcomes[at] = Outcome::ALL[usize::from(all[next[leader]])];
        next[leader] += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_are_read_as_they_were_written() {
        let crossing = Crossing {
            id: 7,
            from: Zone::Inflow,
            opening: 3,
            zone: Zone::Fluid,
            patch: 2,
            point: DVec3::new(1.0, -2.0, 0.1),
            drains: true,
            injections: 2,
            cell: 90_000,
        };
        let injection = Injection {
            place: DVec3::new(0.3, 0.2, -0.1),
            zone: Zone::Outflow,
            patch: 1,
            velocity: DVec3::new(-1.0, 0.5, 0.25),
            pressure: -3.5,
            returned: true,
        };
        let mut message = bytemuck::bytes_of(&crossing.message()).to_vec();
        message.extend_from_slice(bytemuck::bytes_of(&injection.message()));
        let mut rest = &message[..];
        assert_eq!(Crossing::of(&take(&mut rest)), crossing);
        assert_eq!(Injection::of(&take(&mut rest)), injection);
        assert!(rest.is_empty());
        assert_eq!(crossing.crossed(), (Zone::Inflow, 3));
        let back = Crossing { from: Zone::Fluid, opening: 0, zone: Zone::Inflow, ..crossing };
        assert_eq!(back.crossed(), (Zone::Inflow, 2));
    }

    #[test]
    fn outcomes_are_known_by_their_numbers() {
        for outcome in Outcome::ALL {
            assert_eq!(Outcome::ALL[outcome as usize], outcome);
        }
    }
}
