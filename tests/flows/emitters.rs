//! Emitters: exact mass, walls that move, flows with known solutions.

use std::f64::consts::{PI, TAU};

use sphecs::Simulation;
use sphecs_engine::systems::boundaries::emitter_states::EmitterStates;

use crate::common::advance;
use crate::{flow, fluid};

/// A bottom whose speed comes and goes, and a cylinder that turns, moves and emits ever faster.
const TWO: &str = r#"Scene(
    title: "Emitters", dimensions: 2, spacing: 0.05, smoke: 0.05,
    fluid: (density: 1000.0, viscosity: 0.05, sound_speed: 20.0),
    domain: Box(min: (-1.0, -1.0), max: (1.0, 1.0)),
    movers: [(
        name: "cylinder", shape: Circle(center: (0.2, 0.1), radius: 0.4),
        motion: Chain([
            Rotation(about: (0.2, 0.1), rate: "5*t"),
            Translation(displacement: ("0.05*sin(20*t)^2", 0.0)),
        ]),
    )],
    bodies: [(part: "cylinder")],
    emitters: [
        (name: "bottom", region: Box(min: (-0.812, -1.2), max: (0.3, -0.9)), velocity: Normal("sin(30*t)^2*(1 + x)")),
        (name: "surface", on: "cylinder", velocity: MassFlow(rate: "2000*t")),
    ],
    outlets: [(name: "right", at: (1.0, 0.0), towards: (1.0, 0.0))],
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
)"#;

/// Volumes that the emitters emitted, m².
fn emitted(run: &mut Simulation) -> Vec<f64> {
    run.world().resource::<EmitterStates>().emitted_volumes().collect()
}

#[test]
fn emitted_mass_is_exact_to_half_a_particle_at_every_step() {
    for sets in [&[][..], &[("scheme", "EdacTvf()"), ("precision", "F32")]] {
        let mut run = flow(TWO, sets);
        let volume = run.scene().discretisation.cell_volume();
        let mut largest: f64 = 0.0;
        for _ in 0..700 {
            run.step().unwrap_or_else(|stop| panic!("{stop}"));
            assert!(run.ledger().balances());
            largest = largest.max(run.world().resource::<EmitterStates>().largest_difference(volume));
        }
        assert!(largest > 0.4 && largest < 0.5 + 1e-9, "{largest} particles of a column");
        let time = run.clock().time;
        let volumes = emitted(&mut run);
        // The trapezoidal rule is exact for the linear one.
        let expected = 2.0 * time * time / 2.0;
        assert!((volumes[1] / expected - 1.0).abs() < 1e-12, "{} of {expected} m²", volumes[1]);
        // ∫ (1 + x) dx over the bottom.
        let length = 1.112 * (1.0 - 0.256);
        let expected = length * (time / 2.0 - (60.0 * time).sin() / 120.0);
        assert!((volumes[0] / expected - 1.0).abs() < 1e-3, "{} of {expected} m²", volumes[0]);
        for (entered, emitted) in run.ledger().entered.iter().zip(&volumes) {
            let particles = emitted / volume;
            let columns = 1.112 / 0.05 + 0.8 * PI / 0.05;
            assert!((*entered as f64 - particles).abs() < 0.5 * columns, "{entered} of {particles}");
        }
        assert_eq!(run.monitor_row().through_walls, 0, "fluid is behind a wall");
    }
}

/// A piston that oscillates and emits in pulses drives a plug: u = U + v and p = ρ (dU/dt + dv/dt)
/// L.
#[test]
fn piston_that_emits_drives_a_plug_with_both_accelerations() {
    let text = r#"Scene(
        title: "Emitting piston", dimensions: 2, spacing: 0.02, smoke: 0.02,
        fluid: (density: 1000.0, viscosity: 0.01, sound_speed: 20.0),
        domain: Box(min: (-0.1, 0.0), max: (0.5, 0.2)), walls: (slip: FreeSlip),
        movers: [(
            name: "piston", shape: Box(min: (-0.4, 0.0), max: (0.0, 0.2)),
            motion: Translation(displacement: ("-0.03*sin(2*pi*t)*tanh(4*t^2)", 0.0)),
        )],
        bodies: [(part: "piston")],
        emitters: [(
            on: "piston", region: Box(min: (-0.05, 0.0), max: (0.05, 0.2)),
            velocity: Normal("0.2*(1 - cos(2*pi*t))*tanh(4*t^2)"),
        )],
        outlets: [(at: (0.5, 0.1), towards: (1.0, 0.0))],
        reference: (velocity: 0.6, length: 0.2), time: (end: 2.0), output: (every: 1.0),
    )"#;
    for scheme in ["Wcsph()", "EdacTvf()"] {
        let mut run = flow(text, &[("scheme", scheme)]);
        run.run_until(1.0).unwrap_or_else(|stop| panic!("{stop}"));
        let (mut product, mut square) = (0.0, 0.0);
        let mut off: f64 = 0.0;
        while run.clock().time < 2.0 {
            run.step().unwrap_or_else(|stop| panic!("{stop}"));
            let row = run.body_forces();
            let sine = (TAU * row.time).sin();
            let exact = 1000.0 * (0.03 * TAU * TAU + 0.2 * TAU) * sine * (0.5 + 0.03 * sine) * 0.2;
            product -= row.forces[0].pressure_force.x * exact;
            square += exact * exact;
            if run.clock().step.is_multiple_of(50) {
                let cosine = (TAU * run.clock().time).cos();
                let speed = -0.03 * TAU * cosine + 0.2 * (1.0 - cosine);
                let flow = fluid(&mut run);
                let mean = flow.iter().map(|particle| particle.velocity.x).sum::<f64>() / flow.len() as f64;
                off = off.max((mean - speed).abs());
            }
        }
        let factor = product / square;
        println!("{scheme}: force {factor:.4}, mean u off by {off:.4} m/s");
        assert!((factor - 1.0).abs() < 0.05, "{scheme}: {factor} of the force");
        assert!(off < 0.01, "{scheme}: {off} m/s");
    }
}

/// A ball that emits is a source: v = V R²/r², with Bernoulli's pressure, evenly over all
/// directions.
#[test]
fn ball_that_emits_is_a_source() {
    let text = r#"Scene(
        title: "Ball", dimensions: 3, spacing: 0.1, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 0.01, sound_speed: 10.0), scheme: EdacTvf(),
        domain: Box(min: (-1.5, -1.5, -1.5), max: (1.5, 1.5, 1.5)),
        movers: [(
            name: "ball", shape: Sphere(center: (0.0, 0.0, 0.0), radius: 0.9),
            motion: Rotation(about: (0.0, 0.0, 0.0), radians: 0.0),
        )],
        emitters: [(on: "ball", velocity: Normal(0.5))],
        initial: (velocity: (
            "0.405*x/(x^2 + y^2 + z^2)^1.5", "0.405*y/(x^2 + y^2 + z^2)^1.5", "0.405*z/(x^2 + y^2 + z^2)^1.5",
        )),
        outlets: [
            (name: "a", at: (1.5, 0.0, 0.0), towards: (1.0, 0.0, 0.0), depth: 0.4),
            (name: "b", at: (-1.5, 0.0, 0.0), towards: (-1.0, 0.0, 0.0), depth: 0.4),
            (name: "c", at: (0.0, 1.5, 0.0), towards: (0.0, 1.0, 0.0), depth: 0.4),
            (name: "d", at: (0.0, -1.5, 0.0), towards: (0.0, -1.0, 0.0), depth: 0.4),
            (name: "e", at: (0.0, 0.0, 1.5), towards: (0.0, 0.0, 1.0), depth: 0.4),
            (name: "f", at: (0.0, 0.0, -1.5), towards: (0.0, 0.0, -1.0), depth: 0.4),
        ],
        reference: (velocity: 0.5, length: 1.0), time: (end: 2.0), output: (every: 1.0),
    )"#;
    let mut run = flow(text, &[]);
    run.run_until(0.15).unwrap_or_else(|stop| panic!("{stop}"));
    let (mut sum, mut squares, mut across, mut count) = (0.0, 0.0, 0.0, 0.0);
    for particle in fluid(&mut run) {
        let radius = particle.position.length();
        if (1.0..1.2).contains(&radius) {
            let radial = particle.velocity.dot(particle.position) / radius;
            let share = radial / (0.5 * 0.81 / (radius * radius));
            sum += share;
            squares += share * share;
            across += (particle.velocity.length_squared() - radial * radial).max(0.0);
            count += 1.0;
        }
    }
    let mean: f64 = sum / count;
    let scatter = (squares / count - mean * mean).sqrt();
    let across = (across / count).sqrt() / 0.5;
    println!("flux {mean:.4}, scatter {scatter:.4}, across {across:.4}");
    assert!((mean - 1.0).abs() < 0.02, "{mean} of the flux");
    assert!(scatter < 0.05 && across < 0.05, "scatter {scatter}, across {across}");
    advance(&mut run, 1);
    assert_eq!(run.monitor_row().through_walls, 0, "fluid is behind a wall");
}
