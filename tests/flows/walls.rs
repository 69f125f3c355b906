//! Every wall model under both schemes compared with exact solutions: the figures of
//! docs/book/src/theory/walls.md, printed with `--nocapture`. The bands are some tenths above the
//! measured values.

use sphecs::Simulation;
use sphecs::glam::DVec3;
use sphecs_core::boundary::inlet::poiseuille::startup_velocity;

use crate::channel::{COUETTE, couette, largest_error};
use crate::rest::BOX;
use crate::{flow, fluid, shipped_flow};

/// Wall models, in the order of the tables below.
const MODELS: [&str; 3] = ["Image()", "Dummy", "Ghost"];

/// Schemes, in the order of the tables below.
const SCHEMES: [&str; 2] = ["Wcsph()", "EdacTvf()"];

/// Measures each model under each scheme and checks its band, `bands[scheme][model]`.
#[track_caller]
#[expect(clippy::print_stdout, reason = "the figures of docs/book/src/theory/walls.md, by `--nocapture`")]
pub(crate) fn check(what: &str, bands: [[f64; 3]; 2], measure: impl Fn(&str, &str) -> f64) {
    let mut faults = Vec::new();
    for (scheme, bands) in SCHEMES.into_iter().zip(bands) {
        for (model, band) in MODELS.into_iter().zip(bands) {
            let error = measure(scheme, model);
            println!("{what}, {scheme}, {model}: {:.4} % (at most {:.4} %)", 100.0 * error, 100.0 * band);
            if error.is_nan() || error > band {
                faults.push(format!("{what}, {scheme}, {model}: {error}, at most {band}"));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
}

/// Largest error of u over the peak of the steady flow at 0.15 and 1 s of the start-up, with 25
/// particles across.
#[test]
fn poiseuille_starts_up_between_walls_of_every_model() {
    check("Poiseuille", [[0.003, 0.0055, 0.013], [0.0033, 0.0055, 0.015]], |scheme, model| {
        let walls = format!("(model: {model})");
        let set = [("spacing", "4.0e-5"), ("scheme", scheme), ("walls", walls.as_str())];
        let mut simulation = shipped_flow("poiseuille_periodic.ron", &set);
        let mut error = 0.0_f64;
        for time in [0.15, 1.0] {
            simulation.run_until(time).expect("a channel flow");
            let t = simulation.clock().time;
            let exact = |y: f64| startup_velocity(y, t, 5e-4, 1e-4, 1e-6);
            error = error.max(largest_error(&mut simulation, exact) / 1.25e-5);
        }
        error
    });
}

/// Largest error of u over the speed of the lid at 0.5 s of the start-up and in the steady flow,
/// with 20 particles across.
#[test]
fn couette_flow_starts_up_between_walls_of_every_model() {
    check("Couette", [[0.003, 0.0034, 0.01], [0.0033, 0.0033, 0.0105]], |scheme, model| {
        couette_error(&[("scheme", scheme), ("walls.model", model)], couette, &[0.5, 8.0])
    });
}

/// Returns the largest error of u at some times, s.
fn couette_error(set: &[(&str, &str)], exact: impl Fn(f64, f64) -> f64, times: &[f64]) -> f64 {
    let mut simulation = flow(COUETTE, set);
    let mut error = 0.0_f64;
    for &time in times {
        simulation.run_until(time).expect("a channel flow");
        let t = simulation.clock().time;
        error = error.max(largest_error(&mut simulation, |y| exact(y, t)));
    }
    error
}

/// In single precision the error is that of the model, not of the numbers.
#[test]
fn every_wall_model_works_in_single_precision() {
    check("Couette in F32", [[0.003, 0.0034, 0.01], [0.0033, 0.0033, 0.0105]], |scheme, model| {
        let set = [("scheme", scheme), ("walls.model", model), ("precision", "F32")];
        couette_error(&set, couette, &[0.5])
    });
}

/// Plane Couette flow in 3D, 10 particles across.
const SLAB: &str = r#"Scene(
    title: "Plane Couette flow in space", dimensions: 3, spacing: 0.1, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
    domain: Box(min: (0.0, 0.0, 0.0), max: (0.4, 1.0, 0.4)),
    periodic: ["x", "z"],
    walls: (parts: [(
        name: "lid", region: Box(min: (-1.0, 0.9, -1.0), max: (2.0, 2.0, 2.0)), velocity: (1.0, 0.0, 0.0),
    )]),
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: 1.0, length: 1.0),
)"#;

#[test]
fn every_wall_model_works_in_3d() {
    check("Couette in 3D", [[0.007, 0.007, 0.016], [0.007, 0.007, 0.011]], |scheme, model| {
        let mut simulation = flow(SLAB, &[("scheme", scheme), ("walls.model", model)]);
        simulation.run_until(1.0).expect("a channel flow");
        let t = simulation.clock().time;
        largest_error(&mut simulation, |y| couette(y, t))
    });
}

/// u(y, t) under a lid that moves with sin(ωt): Im[sinh(ky)/sinh(k) exp(iωt)], k = (1 + i) √(ω/2ν),
/// ν = 0.1 m²/s, ω = 4/s.
fn oscillating(y: f64, t: f64) -> f64 {
    let k = (4.0_f64 / 0.2).sqrt();
    let sinh = |a: f64| (a.sinh() * a.cos(), a.cosh() * a.sin());
    let ((a, b), (c, d)) = (sinh(k * y), sinh(k));
    let (re, im) = ((a * c + b * d) / (c * c + d * d), (b * c - a * d) / (c * c + d * d));
    re * (4.0 * t).sin() + im * (4.0 * t).cos()
}

/// A wall of varying speed, after the start has decayed. The dissipative terms of a leapfrog step
/// use the speed of the wall one step earlier, not that of the start.
#[test]
fn oscillating_lid_drives_the_exact_flow() {
    check("swinging lid", [[0.02, 0.025, 0.028], [0.02, 0.026, 0.029]], |scheme, model| {
        let lid = "(\"sin(4*t)\", 0.0)";
        let set = [("scheme", scheme), ("walls.model", model), ("walls.parts.0.velocity", lid)];
        couette_error(&set, oscillating, &[6.0, 6.3, 6.6, 6.9])
    });
}

/// Largest error of the pressure, over that of the whole depth, at points up to 0.1 m from lid and
/// bottom, with 20 particles across.
#[test]
fn water_in_a_box_carries_its_weight_on_walls_of_every_model() {
    check("hydrostatic pressure", [[0.002; 3], [0.0007; 3]], |scheme, model| {
        hydrostatic_error(&[("scheme", scheme), ("walls", &format!("(model: {model})"))])
    });
}

/// The weight increases gradually and is given by an expression.
#[test]
fn walls_of_every_model_carry_a_gradual_weight() {
    check("weight that comes", [[0.002; 3], [0.0007; 3]], |scheme, model| {
        let weight = "(0.0, \"-min(t, 1.0)\")";
        hydrostatic_error(&[
            ("scheme", scheme),
            ("walls", &format!("(model: {model})")),
            ("body_force", weight),
        ])
    });
}

fn hydrostatic_error(set: &[(&str, &str)]) -> f64 {
    let mut simulation = flow(BOX, set);
    simulation.run_until(8.0).expect("water at rest");
    assert_eq!(simulation.monitor_row().through_walls, 0);
    off_the_weight(&pressures(&mut simulation))
}

/// Returns the pressure at nine depths of the box, 0.1 m apart, Pa.
pub(crate) fn pressures(simulation: &mut Simulation) -> [f64; 9] {
    let points: [DVec3; 9] = std::array::from_fn(|at| DVec3::new(0.02, DEEPEST + 0.1 * at as f64, 0.0));
    let samples = simulation.sample(&points);
    std::array::from_fn(|at| samples[at].expect("water").pressure)
}

/// Largest of the depths, m.
const DEEPEST: f64 = -0.4;

/// Returns the largest difference of the pressures from those of the weight, over that of the whole
/// depth. Their mean is the initial one, which `EdacTvf` keeps up to second order in the settling.
pub(crate) fn off_the_weight(pressures: &[f64; 9]) -> f64 {
    let mean = pressures.iter().sum::<f64>() / 9.0;
    let off = |(at, p): (usize, &f64)| (p - mean + 1000.0 * (DEEPEST + 0.1 * at as f64)).abs();
    pressures.iter().enumerate().map(off).fold(0.0, f64::max) / 1000.0
}

/// Fluid between a rotating cylinder and one at rest, started from the steady flow.
pub(crate) const ANNULUS: &str = r#"Scene(
    title: "Fluid between two cylinders", dimensions: 2, spacing: 0.05, smoke: 0.1,
    constants: {"R": 0.5, "S": 1.0, "w": 2.0, "B": "w/(1/R^2 - 1/S^2)", "A": "-B/S^2"},
    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
    domain: Difference([Circle(center: (0.0, 0.0), radius: "S"), Circle(center: (0.0, 0.0), radius: "R")]),
    walls: (parts: [(
        name: "inner", region: Circle(center: (0.0, 0.0), radius: 0.75), velocity: ("-w*y", "w*x"),
    )]),
    initial: (velocity: ("-(A + B/(x^2 + y^2))*y", "(A + B/(x^2 + y^2))*x")),
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: 1.0, length: 0.5),
)"#;

/// Root mean square error of the velocity, over that of the rotating surface, after the time in
/// which shear crosses the gap of 10 spacings: (S − R)²/ν.
#[test]
fn flow_between_cylinders_agrees_with_couette() {
    check("annulus", [[0.047, 0.05, 0.05], [0.009, 0.027, 0.032]], |scheme, model| {
        let mut simulation = flow(ANNULUS, &[("scheme", scheme), ("walls.model", model)]);
        simulation.run_until(2.5).expect("a flow in a ring");
        ring_error(&mut simulation)
    });
}

/// Root mean square error of the pressure in that flow, less its mean, over ρ (ω R)².
#[test]
fn pressure_between_cylinders_balances_the_centrifugal_force() {
    check("annulus, pressure", [[0.42; 3], [0.09; 3]], |scheme, model| {
        let mut simulation = flow(ANNULUS, &[("scheme", scheme), ("walls.model", model)]);
        simulation.run_until(2.5).expect("a flow in a ring");
        let b = 2.0 / (0.5_f64.powi(-2) - 1.0);
        // ∂p/∂r = ρ (b/r − b r)²/r
        let exact = |r: f64| 1000.0 * b * b * (0.5 * r * r - 2.0 * r.ln() - 0.5 / (r * r));
        let states = fluid(&mut simulation);
        let off = states.iter().map(|state| state.pressure - exact(state.position.length()));
        let mean = off.clone().sum::<f64>() / states.len() as f64;
        let square = off.map(|off| (off - mean).powi(2)).sum::<f64>() / states.len() as f64;
        square.sqrt() / 1000.0
    });
}

fn ring_error(simulation: &mut Simulation) -> f64 {
    let (w, inner, outer) = (2.0, 0.5_f64, 1.0_f64);
    let b = w / (inner.powi(-2) - outer.powi(-2));
    let states = fluid(simulation);
    let square = |at: DVec3, v: DVec3| {
        let rate = b / (at.x * at.x + at.y * at.y) - b / (outer * outer);
        (v - DVec3::new(-at.y, at.x, 0.0) * rate).length_squared()
    };
    let sum: f64 = states.iter().map(|state| square(state.position, state.velocity)).sum();
    (sum / states.len() as f64).sqrt() / (w * inner)
}
