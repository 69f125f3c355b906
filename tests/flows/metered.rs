//! Inlets with a prescribed mass flow, measured in the fluid downstream.

use std::f64::consts::TAU;

use sphecs::Simulation;
use sphecs::glam::DVec3;

use crate::{flow, fluid};

/// Short channel of 20 particles across with an inflow of 100 kg/s per metre of depth, 0.25 m/s in
/// the mean.
const METERED: &str = r#"Scene(
    title: "Channel with a metered inlet", dimensions: 2, spacing: 0.02, smoke: 0.04,
    constants: {"H": 0.2},
    fluid: (density: 1000.0, viscosity: 1.0e-2, sound_speed: 4.0),
    domain: Box(min: (0.0, "-H"), max: (0.6, "H")),
    initial: (velocity: ("0.375*(1 - y^2/H^2)", 0.0)),
    inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: MassFlow(rate: 100.0, profile: "1 - y^2/H^2"))],
    outlets: [(at: (0.6, 0.0), towards: (1.0, 0.0), condition: WaveEquation(pressure: NonReflecting()))],
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: 0.375, length: 0.4),
)"#;

/// Returns the mass flow through the section x = 0.3 m, kg/s per metre of depth, from the sampled
/// fields.
fn through_the_middle(simulation: &mut Simulation) -> f64 {
    let rows = 40;
    let heights = (0..rows).map(|row| -0.2 + 0.4 * (f64::from(row) + 0.5) / f64::from(rows));
    let points: Vec<DVec3> = heights.map(|y| DVec3::new(0.3, y, 0.0)).collect();
    let samples = simulation.sample(&points);
    let fluxes = samples.iter().map(|sample| sample.map_or(0.0, |at| at.density * at.velocity.x));
    fluxes.sum::<f64>() * 0.4 / f64::from(rows)
}

/// Returns the mean mass flows from `from` to `to`, s, in the middle of the channel from the
/// sampled fields and through the inlet from the particle counts, kg/s.
fn flows(simulation: &mut Simulation, from: f64, to: f64) -> (f64, f64) {
    simulation.run_until(from).expect("a channel flow");
    let (start, before) = (simulation.clock().time, simulation.monitor_row());
    let spacing = simulation.scene().spacing;
    let entered =
        |simulation: &Simulation| simulation.ledger().entered[0] - simulation.ledger().entered_back[0];
    let first = entered(simulation);
    let (mut sum, mut count) = (0.0, 0.0);
    while simulation.clock().time < to {
        simulation.run_until(simulation.clock().time + 0.05).expect("a channel flow");
        sum += through_the_middle(simulation);
        count += 1.0;
    }
    let crossed = (entered(simulation) - first) as f64 * 1000.0 * spacing * spacing;
    assert_eq!(before.through_walls, 0);
    (sum / count, crossed / (simulation.clock().time - start))
}

/// In the middle the error is at most 0.5 %. Columns of 20 particles cross the plane of the inlet
/// at once, of some 2500 in 10 s, so that the counts have an error of 0.8 %.
#[test]
fn prescribed_mass_flow_arrives_in_the_domain() {
    for scheme in ["Wcsph()", "EdacTvf()"] {
        let mut simulation = flow(METERED, &[("scheme", scheme)]);
        let (fields, crossed) = flows(&mut simulation, 3.0, 13.0);
        println!("{scheme}: {fields} kg/s in the middle, {crossed} kg/s over the inlet, of 100");
        assert!((fields - 100.0).abs() < 0.5, "{scheme}: {fields} kg/s in the middle");
        assert!((crossed - 100.0).abs() < 0.8, "{scheme}: {crossed} kg/s over the inlet");
    }
}

/// With a flux that oscillates about its mean, the mean over whole periods arrives.
#[test]
fn oscillating_flux_has_its_prescribed_mean() {
    let velocity = "MassFlux(flux: \"250*(1 + 0.3*sin(2*pi*t))\", profile: \"1 - y^2/H^2\")";
    let mut simulation = flow(METERED, &[("inlets.0.velocity", velocity)]);
    let (fields, crossed) = flows(&mut simulation, 3.0, 13.0);
    println!("swinging: {fields} kg/s in the middle, {crossed} kg/s over the inlet, of 100");
    assert!((fields - 100.0).abs() < 0.5, "{fields} kg/s in the middle");
    assert!((crossed - 100.0).abs() < 0.8, "{crossed} kg/s over the inlet");
}

/// The mass flow rises within a second and then oscillates, under `EdacTvf`; the flow in the middle
/// follows it. An acoustic wave crosses the channel in 0.15 s, so that the mean over whole periods
/// arrives.
#[test]
fn oscillating_mass_flow_has_its_prescribed_mean_under_edac_tvf() {
    let velocity = "MassFlow(rate: \"100*min(t, 1)*(1 + 0.2*sin(2*pi*t))\", profile: \"1 - y^2/H^2\")";
    let set =
        [("inlets.0.velocity", velocity), ("scheme", "EdacTvf()"), ("initial", "(velocity: (0.0, 0.0))")];
    let mut simulation = flow(METERED, &set);
    let (fields, crossed) = flows(&mut simulation, 6.0, 16.0);
    println!("coming and swinging: {fields} kg/s in the middle, {crossed} kg/s over the inlet, of 100");
    assert!((fields - 100.0).abs() < 0.5, "{fields} kg/s in the middle");
    assert!((crossed - 100.0).abs() < 0.8, "{crossed} kg/s over the inlet");
}

/// Round pipe oblique to the lattice, 8.4 spacings wide, with a prescribed mass flow in kg/s and
/// free-slip walls, so that the flow stays uniform.
const PIPE: &str = r#"Scene(
    title: "Metered pipe askew", dimensions: 3, spacing: 0.02, smoke: 0.04,
    constants: {"a": "30*pi/180", "R": 0.084, "L": 0.4, "c": "cos(a)", "s": "sin(a)"},
    fluid: (density: 1000.0, viscosity: 1.0e-2, sound_speed: 4.0),
    domain: Cylinder(from: (0.0, 0.0, 0.0), to: ("L*c", "L*s", 0.0), radius: "R"),
    walls: (slip: FreeSlip),
    initial: (velocity: ("0.4*c", "0.4*s", 0.0)),
    inlets: [(at: (0.0, 0.0, 0.0), towards: ("c", "s", 0.0), velocity: MassFlow(rate: "1000*0.4*pi*R^2"))],
    outlets: [(at: ("L*c", "L*s", 0.0), towards: ("c", "s", 0.0), condition: WaveEquation(pressure: NonReflecting()))],
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: 0.4, length: 0.1),
)"#;

/// Returns the mass flow through the pipe, kg/s: momentum per length, weighted by 1 + cos over
/// 0.3 m in the middle. On a lattice the width of the pipe differs from its geometry, so that
/// fields sampled in a section do not give its mass flow.
fn through_the_pipe(simulation: &mut Simulation) -> f64 {
    let along = DVec3::new(0.75_f64.sqrt(), 0.5, 0.0);
    let weighted = |at: DVec3, velocity: DVec3| {
        let off = at.dot(along) - 0.2;
        let weight = if off.abs() < 0.15 { (1.0 + (TAU * off / 0.3).cos()) / 0.3 } else { 0.0 };
        weight * velocity.dot(along)
    };
    let states = fluid(simulation);
    let sum: f64 = states.iter().map(|state| weighted(state.position, state.velocity)).sum();
    1000.0 * 0.02_f64.powi(3) * sum
}

/// An oblique inlet in 3D has its prescribed mass flow for any width of the pipe in spacings.
#[test]
fn oblique_pipe_has_its_prescribed_mass_flow() {
    let prescribed = 0.5 * TAU * 1000.0 * 0.4 * 0.084 * 0.084;
    for scheme in ["Wcsph()", "EdacTvf()"] {
        let mut simulation = flow(PIPE, &[("scheme", scheme)]);
        simulation.run_until(1.0).expect("a pipe flow");
        let mut sum = 0.0;
        for _ in 0..100 {
            simulation.run_until(simulation.clock().time + 0.05).expect("a pipe flow");
            sum += through_the_pipe(&mut simulation) / 100.0;
        }
        println!("pipe, {scheme}: {sum} kg/s behind the inlet, of {prescribed}");
        assert!((sum / prescribed - 1.0).abs() < 0.005, "{scheme}: {sum} of {prescribed} kg/s");
    }
}
