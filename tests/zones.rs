//! Particles change zone as Fig. 1 of Alvarado-Rodríguez et al. (2017) says, and none is lost.

mod census;
mod plug;

use census::{Particle, census, of};
use plug::scene;
use sphecs::components::{ParticleId, Position, Velocity};
use sphecs::glam::DVec3;
use sphecs::particles::zone::Zone;
use sphecs::scene::model::ProbeSight;
use sphecs::simulation::{Simulation, Stop};

/// Spacing of the particles, m.
const SPACING: f64 = 0.01;

/// Rows across the channel.
const ROWS: usize = 8;

/// Speed of the flow, m/s.
const SPEED: f64 = 0.1;

/// Steps until everything that stood in the plug flow has left its last zone.
const THROUGH: usize = 900;

/// A particle before and after a step in which it changed zone.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    before: Particle,
    after: Particle,
}

fn flow(sets: &[(&str, &str)]) -> Simulation {
    Simulation::from_scene(scene(sets))
}

/// One step, and what changed zone in it.
#[track_caller]
fn step(simulation: &mut Simulation, before: &mut Vec<Particle>) -> Vec<Crossing> {
    simulation.step().expect("a step");
    let after = census(simulation);
    let crossings = before
        .iter()
        .zip(&after)
        .filter(|(before, after)| before.zone != after.zone || before.passages != after.passages)
        .map(|(before, after)| Crossing { before: *before, after: *after })
        .collect();
    *before = after;
    crossings
}

fn between(crossings: &[Crossing], from: Zone, to: Zone) -> Vec<Crossing> {
    crossings.iter().copied().filter(|c| c.before.zone == from && c.after.zone == to).collect()
}

/// What came out of the reservoir into a zone; a particle may have been stored in the same step.
fn injected(crossings: &[Crossing], zone: Zone) -> Vec<Crossing> {
    let taken = |c: &&Crossing| c.after.zone == zone && c.after.passages > c.before.passages;
    crossings.iter().filter(taken).copied().collect()
}

/// A channel of no whole number of spacings: its inlet takes a row before its outlet gives one back.
const UNEVEN: [(&str, &str); 2] =
    [("domain", "Box(min: (0.0, 0.0), max: (0.163, 0.08))"), ("outlets.0.at", "(0.163, 0.04)")];

#[test]
fn a_particle_that_crosses_the_inlet_is_followed_by_one_from_the_reservoir() {
    let mut simulation = flow(&[]);
    let inlet = simulation.scene().inlets[0].patch.clone();
    let mut particles = census(&mut simulation);
    let mut entered = 0;
    for _ in 0..200 {
        let crossings = step(&mut simulation, &mut particles);
        let time = simulation.clock().time;
        let crossed = between(&crossings, Zone::Inflow, Zone::Fluid);
        let followed = injected(&crossings, Zone::Inflow);
        assert_eq!(crossed.len(), followed.len(), "each that enters the fluid is followed by one");
        entered += crossed.len() as u64;
        assert_eq!(simulation.ledger().entered, [entered]);
        for Crossing { before, after } in &crossed {
            assert!(inlet.along(after.position) >= 0.0);
            assert_eq!((after.passages, after.tag), (before.passages, before.tag));
            assert!(after.needs_restart, "a leapfrog would start from a velocity that was prescribed");
        }
        for Crossing { before, after } in &followed {
            let leader = after.position + inlet.depth * inlet.towards;
            let led = crossed.iter().any(|c| c.after.position.distance(leader) < 1e-12);
            assert!(led, "particle {} does not stand one zone length behind another", after.id);
            assert_eq!(after.passages, before.passages + 1);
            assert_eq!(after.velocity, DVec3::new(SPEED, 0.0, 0.0));
            // The tag belongs to the place and the time of the entry.
            let tag = after.position.y + 10.0 * time;
            assert!(
                (f64::from(after.tag) - tag).abs() < 1e-7 * (1.0 + tag.abs()),
                "the tag is {}, not {tag}",
                after.tag
            );
        }
    }
    assert!(entered >= 5 * ROWS as u64, "only {entered} particles entered");
}

#[test]
fn the_lattice_of_an_inflow_zone_stays_regular() {
    let mut simulation = flow(&[]);
    let count = simulation.ledger().count(Zone::Inflow);
    for _ in 0..THROUGH {
        simulation.step().expect("a step");
    }
    let particles = census(&mut simulation);
    let phase = |x: f64| (x / SPACING).rem_euclid(1.0);
    let inflow: Vec<&Particle> = of(&particles, Zone::Inflow).collect();
    assert_eq!(inflow.len() as u64, count);
    let first = inflow[0].position;
    for particle in inflow {
        // Each passage rounds a position once or twice in its last digit.
        let off = phase(particle.position.x - first.x + 0.5 * SPACING) - 0.5;
        assert!(off.abs() < 1e-9, "{} is off the lattice by {off} spacings", particle.position);
        let off = phase(particle.position.y) - 0.5;
        assert!(off.abs() < 1e-9, "{} is off its row by {off} spacings", particle.position);
    }
}

#[test]
fn fluid_that_crosses_the_outlet_becomes_outflow_and_is_stored_at_rest_beyond_its_end() {
    let mut simulation = flow(&UNEVEN);
    let outlet = simulation.scene().outlets[0].patch.clone();
    let density = simulation.scene().fluid.density;
    let mut particles = census(&mut simulation);
    let (mut left, mut stored) = (0, 0);
    for _ in 0..200 {
        let crossings = step(&mut simulation, &mut particles);
        for Crossing { before, after } in between(&crossings, Zone::Fluid, Zone::Outflow) {
            left += 1;
            assert!(outlet.along(before.position) < 0.0 && outlet.along(after.position) >= 0.0);
            assert_eq!((after.patch, after.passages), (0, before.passages));
        }
        for Crossing { before, after } in between(&crossings, Zone::Outflow, Zone::Reservoir) {
            stored += 1;
            assert!(outlet.along(before.position) <= outlet.depth);
            assert_eq!([after.velocity, after.previous_velocity], [DVec3::ZERO; 2]);
            assert_eq!((after.density, after.pressure), (density, 0.0));
        }
        assert_eq!(simulation.ledger().left, [left]);
    }
    assert!(left >= 5 * ROWS as u64 && stored >= 5 * ROWS as u64, "{left} left, {stored} were stored");
}

#[test]
fn particles_go_round_and_a_plug_keeps_its_speed() {
    // With c0 = 1 m/s 200 steps are nine spacings: a column then reaches the end of its zone exactly at the end of a step, and
    // rounding decides which of its particles leave first. The others, alone at the edge, are shifted sideways.
    let mut simulation = flow(&[("fluid.sound_speed", "1.0123")]);
    for _ in 0..THROUGH {
        simulation.step().expect("a step");
    }
    let particles = census(&mut simulation);
    let ledger = simulation.ledger();
    assert_eq!((ledger.grown, ledger.created, ledger.deleted), (0, 0, 0));
    assert!(of(&particles, Zone::Fluid).all(|particle| particle.passages > 0), "some never left");
    for particle in of(&particles, Zone::Fluid) {
        // The lattice is even, so no force is larger than the rounding of its sums: 1e-16 c0²/Δ, over 4 s.
        let off = (particle.velocity - DVec3::new(SPEED, 0.0, 0.0)).length() / SPEED;
        assert!(off < 1e-9, "particle {} moves with {}", particle.id, particle.velocity);
    }
}

/// A flow from the outlet to the inlet with an outlet's condition.
#[track_caller]
fn check_backflow(scheme: &str, condition: &str) {
    const BACK: f64 = 0.03;
    let sets = [("constants.u", "-0.03"), ("scheme", scheme), ("outlets.0.condition", condition)];
    let mut simulation = flow(&sets);
    let inlet = simulation.scene().inlets[0].patch.clone();
    let outlet = simulation.scene().outlets[0].patch.clone();
    let mut particles = census(&mut simulation);
    let start = simulation.ledger().by_zone;
    let (mut out, mut back, mut stored) = (0, 0, 0);
    for _ in 0..THROUGH {
        let crossings = step(&mut simulation, &mut particles);
        for Crossing { after, .. } in between(&crossings, Zone::Fluid, Zone::Inflow) {
            out += 1;
            assert!(inlet.along(after.position) < 0.0, "{condition}");
        }
        let crossed = between(&crossings, Zone::Outflow, Zone::Fluid);
        back += crossed.len() as u64;
        for Crossing { before, after } in injected(&crossings, Zone::Outflow) {
            let leader = after.position - outlet.depth * outlet.towards;
            let led = crossed.iter().any(|c| c.after.position.distance(leader) < 1e-12);
            assert!(led, "{condition}: {} does not stand one zone length behind another", after.id);
            assert_eq!(after.passages, before.passages + 1);
        }
        // What was stored may be taken out in the same step.
        let taken = injected(&crossings, Zone::Outflow).into_iter().filter(|c| c.before.zone == Zone::Inflow);
        stored += (between(&crossings, Zone::Inflow, Zone::Reservoir).len() + taken.count()) as u64;
        let ledger = simulation.ledger();
        assert_eq!((&ledger.entered_back[..], &ledger.left_back[..]), (&[out][..], &[back][..]));
        assert_eq!((ledger.entered[0], ledger.left[0]), (0, 0), "{condition}: nothing goes forwards");
    }
    // A row is under way at each plane, and one more where the start is seen as a wave.
    let rows = ROWS as u64;
    let passed = (simulation.clock().time * BACK / SPACING) as u64 * rows;
    for (count, what) in [(out, "left"), (back, "entered"), (stored, "were stored")] {
        assert!(count.abs_diff(passed) <= 2 * rows, "{condition}: {count} {what}, not {passed}");
    }
    for (zone, (&now, before)) in Zone::ALL.iter().zip(simulation.ledger().by_zone.iter().zip(start)) {
        assert!(now.abs_diff(before) <= rows, "{condition}: {} from {before} to {now}", zone.name());
    }
}

#[test]
fn a_flow_backwards_is_fed_by_the_outlet_and_goes_to_the_reservoir() {
    for scheme in ["Wcsph()", "EdacTvf()"] {
        for condition in [
            "WaveEquation()",
            "WaveEquation(pressure: Reference(0.0))",
            "Orlanski()",
            "DoNothing",
            "ModifiedDoNothing()",
            "Mirror()",
            "Characteristic(velocity: -0.03, pressure: 0.0)",
            "Hybrid()",
        ] {
            check_backflow(scheme, condition);
        }
    }
}

/// Puts the particles back where they stood, at rest, and one of them elsewhere. What entered since stays.
fn put(simulation: &mut Simulation, stood: &[Particle], id: u32, place: DVec3) {
    let world = simulation.world_mut();
    let mut state = world.query::<(&ParticleId, &mut Position, &mut Velocity)>();
    for (number, mut position, mut velocity) in state.iter_mut(world) {
        if stood[number.0 as usize].zone == Zone::Reservoir {
            continue;
        }
        position.0 = if number.0 == id { place } else { stood[number.0 as usize].position };
        velocity.0 = DVec3::ZERO;
    }
}

/// Moves the particle of `zone` that stands nearest to `plane` over it and back, again and again, and counts what
/// entered: all of it at the first turn.
#[track_caller]
fn check_trembling(zone: Zone, plane: f64, enters: u64) {
    let mut simulation = flow(&[("constants.u", "0.0")]);
    let stood = census(&mut simulation);
    let distance = |particle: &Particle| (particle.position.x - plane).abs();
    let near = of(&stood, zone).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a particle");
    let start = simulation.ledger().by_zone;
    let mut crossed = 0;
    for turn in 0..20 {
        let side = if turn % 2 == 0 { 1.0 } else { -1.0 };
        // Far enough that the push of the neighbours does not take it back over the plane in this step.
        let place = near.position.with_x(plane + side * 0.2 * SPACING);
        put(&mut simulation, &stood, near.id, place);
        simulation.step().expect("a step");
        census(&mut simulation);
        let ledger = simulation.ledger();
        crossed = ledger.entered[0] + ledger.entered_back[0] + ledger.left[0] + ledger.left_back[0];
        let reservoir = Zone::Reservoir as usize;
        let entered = start[reservoir] - ledger.by_zone[reservoir];
        assert_eq!(entered, enters, "turn {turn} of a particle of {}", zone.name());
    }
    assert!(crossed >= 19, "the particle crossed {crossed} times only");
}

#[test]
fn trembling_on_a_plane_adds_nothing() {
    // The first crossing of an inflow particle is no return: it is followed.
    check_trembling(Zone::Inflow, 0.0, 1);
    check_trembling(Zone::Fluid, 0.0, 0);
    check_trembling(Zone::Fluid, 0.16, 0);
    check_trembling(Zone::Outflow, 0.16, 0);
}

#[test]
fn an_empty_reservoir_grows_by_what_it_lacks_and_is_counted() {
    let mut simulation = flow(&[UNEVEN[0], UNEVEN[1], ("reservoir.particles", "0")]);
    let initial = simulation.ledger().initial;
    assert_eq!(simulation.ledger().count(Zone::Reservoir), 0);
    for _ in 0..THROUGH / 10 {
        for _ in 0..10 {
            simulation.step().expect("a step");
        }
        let count = census(&mut simulation).len() as u64;
        let ledger = simulation.ledger();
        assert_eq!(count, initial + ledger.grown);
    }
    // Afterwards a row comes back before the next is asked for.
    let grown = simulation.ledger().grown;
    assert!(grown > 0 && grown <= 2 * ROWS as u64, "the reservoir grew {grown} particles");
}

#[test]
fn an_empty_reservoir_stops_a_run_that_must_not_grow() {
    let stop = ("reservoir", "(particles: 0, when_empty: Stop)");
    let mut simulation = flow(&[UNEVEN[0], UNEVEN[1], stop]);
    let stop = (0..THROUGH).find_map(|_| simulation.step().err()).expect("a stop");
    let clock = simulation.clock();
    assert!(
        matches!(stop, Stop::ReservoirEmpty { step, time } if (step, time) == (clock.step, clock.time)),
        "{stop}"
    );
    census(&mut simulation);
    assert_eq!(simulation.ledger().grown, 0);
}

#[test]
fn an_inlet_that_is_filled_once_is_drained_as_by_a_piston() {
    // 16 layers, a support of three: the run goes on while more than that is left.
    let once = [("inlets.0.feed", "Once"), ("inlets.0.depth", "0.16"), ("reservoir.particles", "0")];
    let mut simulation = flow(&once);
    let stop = (0..2 * THROUGH).find_map(|_| simulation.step().err()).expect("a stop");
    let time = simulation.clock().time;
    assert!(matches!(&stop, Stop::Drained { inlet, .. } if inlet == "inlet 0"), "{stop}");
    let drained = (0.16 - 0.03) / SPEED;
    assert!((time - drained).abs() < SPACING / SPEED, "{time} s, {drained} s");
    let particles = census(&mut simulation);
    assert!(particles.iter().all(|particle| particle.passages == 0), "nothing has entered");
    let ledger = simulation.ledger();
    assert_eq!((ledger.grown, ledger.initial), (0, particles.len() as u64));
    assert!(ledger.count(Zone::Inflow) <= 3 * ROWS as u64, "{}", ledger.count(Zone::Inflow));
}

/// Four spacings behind the outlet's plane, where the support of the fluid has ended.
#[test]
fn a_probe_looks_into_a_zone_only_where_it_is_asked_to() {
    let mut simulation = flow(&[]);
    let point = DVec3::new(0.2, 0.04, 0.0);
    let seen = simulation.sample_seeing(&[(point, ProbeSight::Fluid), (point, ProbeSight::Flow)]);
    assert!(seen[0].is_none(), "{seen:?}");
    let velocity = seen[1].expect("outflow particles").velocity;
    assert!((velocity - DVec3::X * SPEED).length() < 1e-9, "{velocity} m/s");
}
