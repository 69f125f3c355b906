//! Changes of zone as in Fig. 1 of Alvarado-Rodríguez et al. (2017), without loss of particles.

mod census;
mod common;
mod plug;

use census::{Particle, census, of};
use plug::scene;
use sphecs::Zone;
use sphecs::glam::DVec3;
use sphecs_engine::components::{ParticleId, Position, Velocity};
use sphecs_engine::simulation::{Simulation, Stop};
use sphecs_scene::model::ProbeSight;

/// Spacing of the particles, m.
const SPACING: f64 = 0.01;

/// Particles across the channel.
const ROWS: usize = 8;

/// Speed of the flow, m/s.
const SPEED: f64 = 0.1;

/// Steps until all initial particles have been stored.
const THROUGH: usize = 900;

/// Particle before and after a step in which it changed zone.
#[derive(Clone, Copy, Debug)]
struct Crossing {
    before: Particle,
    after: Particle,
}

fn flow(sets: &[(&str, &str)]) -> Simulation {
    common::simulation(scene(sets))
}

/// Takes a step and returns the particles that changed zone.
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

/// Returns the particles injected into a zone, which may have been stored in the same step.
fn injected(crossings: &[Crossing], zone: Zone) -> Vec<Crossing> {
    let taken = |c: &&Crossing| c.after.zone == zone && c.after.passages > c.before.passages;
    crossings.iter().filter(taken).copied().collect()
}

/// Channel whose length is not a multiple of the spacing: a column enters before one is stored.
const UNEVEN: [(&str, &str); 2] =
    [("domain", "Box(min: (0.0, 0.0), max: (0.163, 0.08))"), ("outlets.0.at", "(0.163, 0.04)")];

#[test]
fn each_particle_through_the_inlet_is_followed_by_one_from_the_reservoir() {
    let mut simulation = flow(&[]);
    let inlet = simulation.scene().inlets[0].patch.clone();
    let mut particles = census(&mut simulation);
    let mut entered = 0;
    for _ in 0..200 {
        let in_zone: Vec<usize> =
            (0..particles.len()).filter(|&id| particles[id].zone == Zone::Inflow).collect();
        let crossings = step(&mut simulation, &mut particles);
        let time = simulation.clock().time;
        // The rows of the zone have the distance that belongs to its mean density.
        let mean = in_zone.iter().map(|&id| particles[id].density).sum::<f64>() / in_zone.len() as f64;
        let depth = inlet.depth * simulation.scene().fluid.density / mean;
        let crossed = between(&crossings, Zone::Inflow, Zone::Fluid);
        let followed = injected(&crossings, Zone::Inflow);
        assert_eq!(crossed.len(), followed.len(), "each particle that enters the fluid is followed by one");
        entered += crossed.len() as u64;
        assert_eq!(simulation.ledger().entered, [entered]);
        for Crossing { before, after } in &crossed {
            assert!(inlet.along(after.position) >= 0.0);
            assert_eq!((after.passages, after.tag), (before.passages, before.tag));
            assert!(after.needs_restart, "its previous velocity is a prescribed one");
        }
        for Crossing { before, after } in &followed {
            let leader = after.position + depth * inlet.towards;
            let led = crossed.iter().any(|c| c.after.position.distance(leader) < 1e-9 * SPACING);
            assert!(led, "particle {} is not one zone length behind another", after.id);
            assert_eq!(after.passages, before.passages + 1);
            assert_eq!(after.velocity, DVec3::new(SPEED, 0.0, 0.0));
            // The tag is that of the position and the time of the injection.
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
fn lattice_of_an_inflow_zone_stays_regular() {
    let mut simulation = flow(&[]);
    let count = simulation.ledger().count(Zone::Inflow);
    for _ in 0..THROUGH {
        simulation.step().expect("a step");
    }
    let particles = census(&mut simulation);
    let inflow: Vec<&Particle> = of(&particles, Zone::Inflow).collect();
    assert_eq!(inflow.len() as u64, count);
    let ends = inflow
        .iter()
        .map(|particle| particle.position.x)
        .fold((0.0_f64, -1.0_f64), |(low, high), x| (low.min(x), high.max(x)));
    let columns = inflow.len() / ROWS;
    let pitch = (ends.1 - ends.0) / (columns - 1) as f64;
    assert!(
        (pitch / SPACING - 1.0).abs() < 1e-3,
        "the sound of the start compresses little, not to {pitch} m"
    );
    let phase = |x: f64| x.rem_euclid(1.0);
    for particle in inflow {
        // Each passage rounds the last digit of a position once or twice.
        let off = phase((particle.position.x - ends.0) / pitch + 0.5) - 0.5;
        assert!(off.abs() < 1e-9, "{} is off the lattice by {off} spacings", particle.position);
        let off = phase(particle.position.y / SPACING) - 0.5;
        assert!(off.abs() < 1e-9, "{} is off its line by {off} spacings", particle.position);
    }
}

#[test]
fn fluid_beyond_the_outlet_becomes_outflow_and_is_stored_at_rest_beyond_the_zone() {
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
fn plug_flow_keeps_its_speed_while_particles_circulate() {
    // With c0 = 1 m/s 200 steps are nine spacings: a column then reaches the end of its zone
    // exactly at the end of a step, and rounding determines which of its particles are stored
    // first. The others are then shifted sideways.
    let mut simulation = flow(&[("fluid.sound_speed", "1.0123")]);
    for _ in 0..THROUGH {
        simulation.step().expect("a step");
    }
    let particles = census(&mut simulation);
    let ledger = simulation.ledger();
    assert_eq!((ledger.grown, ledger.created, ledger.deleted), (0, 0, 0));
    assert!(of(&particles, Zone::Fluid).all(|particle| particle.passages > 0), "some were never injected");
    for particle in of(&particles, Zone::Fluid) {
        // On a regular lattice no force exceeds the rounding of its sum: 1e-16 c0²/Δ, over 4 s.
        let off = (particle.velocity - DVec3::new(SPEED, 0.0, 0.0)).length() / SPEED;
        assert!(off < 1e-9, "particle {} moves with {}", particle.id, particle.velocity);
    }
}

/// Checks a flow from the outlet to the inlet with an outlet condition.
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
            // Under `Wcsph` the length of the zone belongs to the density of the particle that
            // entered, which hardly changes from a step to the next.
            let is_compressible = scheme == "Wcsph()";
            let off = |c: &Crossing| {
                let stretch = match is_compressible {
                    true => simulation.scene().fluid.density / c.before.density,
                    false => 1.0,
                };
                c.after.position.distance(after.position - stretch * outlet.depth * outlet.towards)
            };
            let off = crossed.iter().map(off).fold(f64::INFINITY, f64::min);
            let within = if is_compressible { 1e-3 * SPACING } else { 1e-12 };
            assert!(off < within, "{condition}: {} is {off} m off its place behind another", after.id);
            assert_eq!(after.passages, before.passages + 1);
        }
        // A stored particle may be injected in the same step.
        let taken = injected(&crossings, Zone::Outflow).into_iter().filter(|c| c.before.zone == Zone::Inflow);
        stored += (between(&crossings, Zone::Inflow, Zone::Reservoir).len() + taken.count()) as u64;
        let ledger = simulation.ledger();
        assert_eq!((&ledger.entered_back[..], &ledger.left_back[..]), (&[out][..], &[back][..]));
        assert_eq!((ledger.entered[0], ledger.left[0]), (0, 0), "{condition}: no forward flow");
    }
    // One column may be incomplete at each plane, and one more if the start is treated as a wave.
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
fn backflow_is_injected_at_the_outlet_and_stored_at_the_inlet() {
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

/// Resets the particles to earlier positions at rest, except one. Particles injected since then
/// stay.
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

/// Moves the particle of `zone` nearest to `plane` across it and back repeatedly, and counts the
/// injections, all of which must be at the first crossing.
#[track_caller]
fn check_oscillation(zone: Zone, plane: f64, enters: u64) {
    let mut simulation = flow(&[("constants.u", "0.0")]);
    let stood = census(&mut simulation);
    let distance = |particle: &Particle| (particle.position.x - plane).abs();
    let near = of(&stood, zone).min_by(|a, b| distance(a).total_cmp(&distance(b))).expect("a particle");
    let start = simulation.ledger().by_zone;
    let mut crossed = 0;
    for turn in 0..20 {
        let side = if turn % 2 == 0 { 1.0 } else { -1.0 };
        // Far enough that the neighbours do not push it back across the plane in this step.
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
fn oscillation_across_a_plane_injects_once() {
    // The first crossing of an inflow particle injects one, as it has not returned from the fluid.
    check_oscillation(Zone::Inflow, 0.0, 1);
    check_oscillation(Zone::Fluid, 0.0, 0);
    check_oscillation(Zone::Fluid, 0.16, 0);
    check_oscillation(Zone::Outflow, 0.16, 0);
}

#[test]
fn empty_reservoir_grows_by_the_missing_particles() {
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
    // Afterwards a column is stored before the next is injected.
    let grown = simulation.ledger().grown;
    assert!(grown > 0 && grown <= 2 * ROWS as u64, "the reservoir grew {grown} particles");
}

#[test]
fn empty_reservoir_stops_a_scene_that_demands_it() {
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
fn inlet_that_is_filled_once_drains_at_the_inflow_speed() {
    // The run continues while more than the support of three of the 16 layers is left.
    let once = [("inlets.0.feed", "Once"), ("inlets.0.depth", "0.16"), ("reservoir.particles", "0")];
    let mut simulation = flow(&once);
    let stop = (0..2 * THROUGH).find_map(|_| simulation.step().err()).expect("a stop");
    let time = simulation.clock().time;
    assert!(matches!(&stop, Stop::Drained { inlet, .. } if inlet == "inlet 0"), "{stop}");
    let drained = (0.16 - 0.03) / SPEED;
    assert!((time - drained).abs() < SPACING / SPEED, "{time} s, {drained} s");
    let particles = census(&mut simulation);
    assert!(particles.iter().all(|particle| particle.passages == 0), "nothing is injected");
    let ledger = simulation.ledger();
    assert_eq!((ledger.grown, ledger.initial), (0, particles.len() as u64));
    assert!(ledger.count(Zone::Inflow) <= 3 * ROWS as u64, "{}", ledger.count(Zone::Inflow));
}

/// The point is four spacings beyond the plane of the outlet, outside the support of the fluid.
#[test]
fn probe_samples_a_zone_only_on_request() {
    let mut simulation = flow(&[]);
    let point = DVec3::new(0.2, 0.04, 0.0);
    let seen = simulation.sample_seeing(&[(point, ProbeSight::Fluid), (point, ProbeSight::Flow)]);
    assert!(seen[0].is_none(), "{seen:?}");
    let velocity = seen[1].expect("outflow particles").velocity;
    assert!((velocity - DVec3::X * SPEED).length() < 1e-9, "{velocity} m/s");
}
