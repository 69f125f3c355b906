//! A run gives the same bits for any number of threads, and whoever looks at it meanwhile.

mod census;
mod shipped;

use std::path::Path;

use census::{Particle, census};
use rayon::ThreadPoolBuilder;
use shipped::shipped;
use sphecs::glam::DVec3;
use sphecs::scene::{load_smoke, load_str};
use sphecs::simulation::Simulation;

/// Steps of each run: particles change zone, and plain steps come round, several times.
const STEPS: usize = 500;

/// Steps of the runs that somebody looks at.
const LOOKED_AT: usize = 100;

fn simulation(path: &Path) -> Simulation {
    Simulation::from_scene(load_smoke(path, &[]).expect("a shipped scene reads"))
}

/// Every bit of a particle: `==` would take -0 for 0.
fn bits(particle: &Particle) -> [u64; 17] {
    let vectors = [particle.position, particle.velocity, particle.previous_velocity];
    let vectors = vectors.map(|v| v.to_array().map(f64::to_bits));
    let [density, pressure] = [particle.density, particle.pressure].map(f64::to_bits);
    let [zone, patch] = [particle.zone as u64, u64::from(particle.patch)];
    let [passages, needs_restart] = [u64::from(particle.passages), u64::from(particle.needs_restart)];
    let tag = u64::from(particle.tag.to_bits());
    let scalars = [density, pressure, tag, zone, patch, passages, needs_restart, u64::from(particle.id)];
    let mut all = [0; 17];
    for (to, from) in all.iter_mut().zip(vectors.as_flattened().iter().chain(&scalars)) {
        *to = *from;
    }
    all
}

/// The first particle of which a bit differs, with both of its states.
fn difference(one: &mut Simulation, other: &mut Simulation) -> Option<String> {
    let (a, b) = (one.clock(), other.clock());
    if (a.time.to_bits(), a.step) != (b.time.to_bits(), b.step) {
        return Some(format!("{a:?} against {b:?}"));
    }
    let (a, b) = (census(one), census(other));
    if a.len() != b.len() {
        return Some(format!("{} particles against {}", a.len(), b.len()));
    }
    a.iter().zip(&b).find(|(a, b)| bits(a) != bits(b)).map(|(a, b)| format!("{a:?}\nagainst {b:?}"))
}

#[test]
fn the_number_of_threads_changes_no_bit() {
    let pools = [1, 2, 3].map(|threads| {
        ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads")
    });
    for path in shipped() {
        let mut runs = [(); 3].map(|()| simulation(&path));
        for (run, pool) in runs.iter_mut().zip(&pools) {
            pool.install(|| (0..STEPS).for_each(|_| run.step().expect("a step")));
        }
        let [one, others @ ..] = &mut runs;
        for (other, threads) in others.iter_mut().zip(2..) {
            let found = difference(one, other);
            assert_eq!(found, None, "{}: 1 thread against {threads}", path.display());
        }
    }
}

/// More rows than several threads would share out among themselves: inlet, outlet, walls, a force that is a formula.
const CHANNEL: &str = r#"Scene(
    title: "Channel", dimensions: 2, spacing: 0.005, smoke: 0.01,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
    scheme: Wcsph(smoothing_ratio: 1.5),
    domain: Box(min: (0.0, -0.15), max: (1.2, 0.15)),
    body_force: ("0.1*cos(y)", "0"),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal("min(20*t, 1)*(1 - 40*y^2)"))],
    outlets: [(at: (1.2, 0.0), towards: (1.0, 0.0), condition: WaveEquation())],
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// The shipped scenes at their smoke spacings have few rows to share out.
#[test]
fn the_number_of_threads_changes_no_bit_where_rows_are_many() {
    same_for_threads(&[]);
    same_for_threads(&[("outlets.0.condition", "Hybrid()"), ("scheme", "EdacTvf()")]);
    same_for_threads(&[("outlets.0.condition", "Mirror()")]);
}

#[track_caller]
fn same_for_threads(sets: &[(&str, &str)]) {
    let sets: Vec<(String, String)> =
        sets.iter().map(|(path, value)| ((*path).to_owned(), (*value).to_owned())).collect();
    let mut runs = [1, 3].map(|threads| {
        let scene = load_str("channel", CHANNEL, &sets).unwrap_or_else(|faults| panic!("{faults}"));
        let mut run = Simulation::from_scene(scene);
        let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool of a few threads");
        pool.install(|| (0..160).for_each(|_| run.step().expect("a step")));
        assert!(run.ledger().entered[0] > 0, "particles must have crossed the inlet");
        assert!(run.ledger().total() > 12_000, "too few rows to be shared out");
        run
    });
    let [one, other] = &mut runs;
    assert_eq!(difference(one, other), None);
}

/// Runs each shipped scene as it is and with what `look` does before its steps, and fails with all differences.
#[track_caller]
fn each_scene_stays_the_same_under(look: impl Fn(&mut Simulation, usize)) {
    let mut faults = Vec::new();
    for path in shipped() {
        let (mut alone, mut looked_at) = (simulation(&path), simulation(&path));
        for step in 0..LOOKED_AT {
            look(&mut looked_at, step);
            alone.step().expect("a step");
            looked_at.step().expect("a step");
        }
        if let Some(found) = difference(&mut alone, &mut looked_at) {
            faults.push(format!("{}: {found}", path.display()));
        }
    }
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}

#[test]
fn reading_between_steps_changes_no_bit() {
    each_scene_stays_the_same_under(|simulation, step| match step % 11 {
        0 => drop(simulation.monitor_row()),
        3 => drop(simulation.sample(&[DVec3::ZERO, DVec3::splat(1e-4)])),
        5 => drop(census(simulation)),
        _ => {}
    });
}

#[test]
fn taking_the_world_and_leaving_it_as_it_is_changes_no_bit() {
    each_scene_stays_the_same_under(|simulation, step| {
        if step % 7 == 0 {
            simulation.world_mut();
        }
    });
}
