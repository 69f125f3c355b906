//! Free-slip walls of every model under both schemes: no drag along the wall, and full support
//! normal to it. The figures are in docs/book/src/theory/walls.md, printed with `--nocapture`.

use std::f64::consts::PI;

use sphecs::Simulation;

use crate::channel::{SLIPPERY, largest_error};
use crate::rest::BOX;
use crate::walls::{check, off_the_weight, pressures};
use crate::{flow, fluid};

/// Share of its momentum that a flow loses along free-slip walls over 2 s.
#[test]
fn free_slip_walls_of_every_model_exert_no_shear() {
    check("free slip", [[1e-5; 3], [6e-5; 3]], |scheme, model| {
        let mut simulation = flow(SLIPPERY, &[("scheme", scheme), ("walls.model", model)]);
        let before = simulation.monitor_row().momentum.x;
        simulation.run_until(2.0).expect("a stream");
        let profile = largest_error(&mut simulation, |_| 1.0);
        assert!(profile < 1e-3, "{scheme}, {model}: u is off by {profile} m/s");
        (1.0 - simulation.monitor_row().momentum.x / before).abs()
    });
}

/// Largest speed that a slipping lid gives to water at rest within 2 s, over its own.
#[test]
fn slipping_lid_exerts_no_drag() {
    check("sliding lid", [[1e-5; 3], [1e-5; 3]], |scheme, model| {
        let lid = "[(name: \"lid\", region: Box(min: (-1.0, 0.9), max: (2.0, 2.0)), velocity: (1.0, 0.0))]";
        let set = [
            ("scheme", scheme),
            ("walls.model", model),
            ("walls.parts", lid),
            ("initial", "(velocity: (0.0, 0.0))"),
        ];
        let mut simulation = flow(SLIPPERY, &set);
        simulation.run_until(2.0).expect("water at rest");
        fluid(&mut simulation).iter().map(|state| state.velocity.length()).fold(0.0, f64::max)
    });
}

/// Largest error of the mean pressure of water at rest from 6 to 8 s, over that of the whole depth.
/// Free-slip walls do not damp the acoustic wave of the start, which changes it by some per cent
/// until then (period 0.2 s).
#[test]
fn water_in_a_box_carries_its_weight_on_free_slip_walls() {
    check("hydrostatic pressure, free slip", [[0.0012, 0.0012, 0.005], [0.0006; 3]], |scheme, model| {
        let walls = format!("(model: {model}, slip: FreeSlip)");
        let mut simulation = flow(BOX, &[("scheme", scheme), ("walls", walls.as_str())]);
        let mut mean = [0.0; 9];
        for at in 0..100 {
            simulation.run_until(6.0 + 0.02 * f64::from(at)).expect("water at rest");
            for (mean, pressure) in mean.iter_mut().zip(pressures(&mut simulation)) {
                *mean += 0.01 * pressure;
            }
        }
        assert_eq!(simulation.monitor_row().through_walls, 0);
        off_the_weight(&mean)
    });
}

/// Inviscid fluid in solid-body rotation between two slipping cylinders at rest.
const TURNING: &str = r#"Scene(
    title: "Fluid that turns between cylinders that slip", dimensions: 2, spacing: 0.05, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 0.0, sound_speed: 10.0),
    domain: Difference([Circle(center: (0.0, 0.0), radius: 1.0), Circle(center: (0.0, 0.0), radius: 0.5)]),
    walls: (slip: FreeSlip),
    initial: (velocity: ("-y", "x"), pressure: "500*(x^2 + y^2 - 0.625)"),
    time: (end: 20.0), output: (every: 1.0), reference: (velocity: 1.0, length: 0.5),
)"#;

fn angular_momentum(simulation: &mut Simulation) -> f64 {
    fluid(simulation).iter().map(|state| state.position.cross(state.velocity).z).sum()
}

/// Share of the angular momentum lost within half a turn at walls cut out of the lattice, along
/// whose stairs the fluid flows.
#[test]
fn rotating_fluid_between_slipping_cylinders_keeps_its_angular_momentum() {
    check("turning fluid", [[0.28, 0.28, 0.35], [0.15, 0.15, 0.06]], |scheme, model| {
        let mut simulation = flow(TURNING, &[("scheme", scheme), ("walls.model", model)]);
        let before = angular_momentum(&mut simulation);
        simulation.run_until(PI).expect("a flow in a ring");
        1.0 - angular_momentum(&mut simulation) / before
    });
}

/// The same with layers of wall particles, along which the fluid of `Wcsph` flows as along the
/// surface. Under `EdacTvf` the stairs are not the reason of the loss.
#[test]
fn rotating_fluid_keeps_its_angular_momentum_along_layers() {
    check("turning fluid, layers", [[0.012; 3], [0.15, 0.15, 0.04]], |scheme, model| {
        let sets = [("scheme", scheme), ("walls.model", model), ("walls.fill", "Layers")];
        let mut simulation = flow(TURNING, &sets);
        let before = angular_momentum(&mut simulation);
        simulation.run_until(PI).expect("a flow in a ring");
        1.0 - angular_momentum(&mut simulation) / before
    });
}

/// Mean speed around the inner cylinder, which rotates and slips, over that of its surface after
/// 2.5 s. By then a no-slip cylinder has set a viscous fluid in rotation.
#[test]
fn slipping_cylinder_exerts_no_torque() {
    check("slipping cylinder", [[1e-4; 3], [1e-4; 3]], |scheme, model| {
        let inner = "[(name: \"inner\", region: Circle(center: (0.0, 0.0), radius: 0.75), velocity: (\"-2*y\", \"2*x\"))]";
        let set = [
            ("scheme", scheme),
            ("walls.model", model),
            ("walls.parts", inner),
            ("fluid.viscosity", "0.1"),
            ("initial", "(velocity: (0.0, 0.0))"),
        ];
        let mut simulation = flow(TURNING, &set);
        simulation.run_until(2.5).expect("water at rest");
        let states = fluid(&mut simulation);
        let around =
            states.iter().map(|state| state.position.cross(state.velocity).z / state.position.length());
        (around.sum::<f64>() / states.len() as f64).abs()
    });
}
