//! Force and torque on bodies compared with exact values: the figures of
//! docs/book/src/guides/body_forces.md, printed with `--nocapture`.

use std::f64::consts::PI;

use sphecs::Simulation;
use sphecs::glam::DVec3;
use sphecs_core::pass::body::BodySum;
use sphecs_scene::seeds;

use crate::channel::COUETTE;
use crate::common::text_scene;
use crate::flow;
use crate::walls::ANNULUS;

const SCHEMES: [&str; 2] = ["Wcsph()", "EdacTvf()"];

fn force(body: &BodySum) -> DVec3 {
    body.pressure_force + body.viscous_force
}

/// Cylinder in a closed box of water under gravity.
const SUBMERGED: &str = r#"Scene(
    title: "Submerged cylinder", dimensions: 2, spacing: 0.04, smoke: 0.08,
    fluid: (density: 1000.0, viscosity: 0.1, sound_speed: 10.0),
    domain: Difference([Box(min: (-0.6, -0.6), max: (0.6, 0.6)), Circle(center: (0.0, 0.0), radius: 0.24)]),
    walls: (parts: [(name: "cylinder", region: Circle(center: (0.0, 0.0), radius: 0.4))]),
    bodies: [(part: "cylinder"), (part: "walls")],
    body_force: (0.0, -1.0),
    time: (end: 10.0), output: (every: 0.1), reference: (velocity: 1.0, length: 1.0),
)"#;

/// Returns the mean forces on cylinder and box over a tenth of a second, with the water at rest.
fn at_rest(set: &[(&str, &str)]) -> (Simulation, [DVec3; 2]) {
    let mut simulation = flow(SUBMERGED, set);
    simulation.run_until(6.0).expect("water at rest");
    let mut sums = [DVec3::ZERO; 2];
    for _ in 0..50 {
        simulation.step().expect("water at rest");
        for (sum, body) in sums.iter_mut().zip(&simulation.body_forces().forces) {
            *sum += force(body) / 50.0;
        }
    }
    (simulation, sums)
}

/// Cylinder and box together carry the weight of the water, and the cylinder is lifted by the
/// weight of the displaced water; the box alone would carry more. The surface of the cylinder is of
/// rings or of a lattice with stairs.
#[test]
fn submerged_cylinder_is_lifted_by_the_displaced_weight() {
    for (scheme, weight_band, bands) in
        [(SCHEMES[0], 0.006, [0.075, 0.02]), (SCHEMES[1], 1e-4, [0.075, 0.015])]
    {
        for (fill, band) in
            [None, Some("Concentric(center: (0.0, 0.0), radius: 0.24)")].into_iter().zip(bands)
        {
            let mut set = vec![("scheme", scheme)];
            set.extend(fill.map(|fill| ("walls.parts.0.fill", fill)));
            let (mut simulation, [cylinder, walls]) = at_rest(&set);
            let weight = simulation.monitor_row().mass[0];
            let lift = 1000.0 * PI * 0.24 * 0.24;
            let (of_lift, of_weight) = (cylinder.y / lift - 1.0, (cylinder.y + walls.y) / -weight - 1.0);
            println!(
                "{scheme}, {}: lift off by {:.2} %, weight by {:.3} %, force aside {:.4} of the lift",
                fill.unwrap_or("lattice"),
                100.0 * of_lift,
                100.0 * of_weight,
                cylinder.x / lift
            );
            assert!(of_lift.abs() < band, "{scheme}, {fill:?}: {cylinder} N/m, not {lift} N/m");
            assert!(
                of_weight.abs() < weight_band,
                "{scheme}, {fill:?}: {} of {weight} N/m",
                cylinder.y + walls.y
            );
            assert!(cylinder.x.abs() < 0.001 * lift, "{scheme}, {fill:?}: {cylinder} N/m");
        }
    }
}

/// Steady Couette flow exerts μ U/H per area on lid and bottom, here 50 N/m on half a metre.
#[test]
fn lid_has_the_drag_of_the_shear() {
    for scheme in SCHEMES {
        let set = [
            ("scheme", scheme),
            ("initial", "(velocity: (\"U*y\", 0.0))"),
            ("bodies", "[(part: \"lid\", velocity: \"U\", area: 0.5), (part: \"walls\")]"),
        ];
        let mut simulation = flow(COUETTE, &set);
        simulation.run_until(5.0).expect("a channel flow");
        let row = simulation.body_forces();
        let [lid, bottom] = [0, 1].map(|body| row.forces[body].viscous_force.x);
        println!("{scheme}: {lid} N/m on the lid, {bottom} N/m on the bottom, of 50");
        assert!(
            (lid / -50.0 - 1.0).abs() < 0.01 && (bottom / 50.0 - 1.0).abs() < 0.01,
            "{scheme}: {lid}, {bottom}"
        );
    }
}

/// Torque on the rotating inner and on the outer cylinder, started from the steady flow, after the
/// time in which shear crosses the gap of ten spacings. Both have the torque of the shear, 4π μ ω
/// R² S²/(S² − R²) = 837.8 N m per metre. Of the inner one, −2 μ ω π R² = −314.2 N m per metre come
/// from the transposed gradient (`physics/wall/transposed.rs`), the rest from the pairs.
#[test]
fn cylinders_have_the_torque_of_the_shear_between_them() {
    let torque = 4.0 * PI * 100.0 * 2.0 * 0.25 / 0.75;
    let inner_rings = "Concentric(center: (0.0, 0.0), radius: 0.5)";
    for (scheme, bands) in [(SCHEMES[0], [0.035, 0.07]), (SCHEMES[1], [0.06, 0.035])] {
        for (fill, band) in [None, Some(inner_rings)].into_iter().zip(bands) {
            let mut set = vec![
                ("scheme", scheme),
                ("bodies", "[(part: \"inner\"), (part: \"walls\", about: (0.0, 0.0))]"),
            ];
            set.extend(fill.map(|fill| ("walls.parts.0.fill", fill)));
            let mut simulation = flow(ANNULUS, &set);
            simulation.run_until(2.5).expect("a flow in a ring");
            let (mut inner, mut outer) = (0.0, 0.0);
            for _ in 0..100 {
                simulation.step().expect("a flow in a ring");
                let row = simulation.body_forces();
                let about =
                    |body: usize| row.forces[body].pressure_torque.z + row.forces[body].viscous_torque.z;
                inner += about(0) / 100.0;
                outer += about(1) / 100.0;
            }
            let (of_inner, of_outer) = (inner / -torque - 1.0, outer / torque - 1.0);
            println!(
                "{scheme}, {}: torque off by {:.2} % inside, {:.2} % outside",
                fill.unwrap_or("lattice"),
                100.0 * of_inner,
                100.0 * of_outer
            );
            assert!(of_inner.abs() < band && of_outer.abs() < band, "{scheme}, {fill:?}: {inner}, {outer} N");
        }
    }
}

/// Closed box whose walls are a body.
const CLOSED: &str = r#"Scene(
    title: "Closed box", dimensions: 2, spacing: 0.05, smoke: 0.1,
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 20.0),
    domain: Box(min: (0.0, 0.0), max: (1.0, 1.0)),
    bodies: [(part: "walls", about: (0.0, 0.0))],
    time: (end: 1.0), output: (every: 1.0), reference: (velocity: 1.0, length: 1.0),
)"#;

/// Returns force (N s/m) and torque (N s) on the walls in the second step, times the first step,
/// with a particle that begins behind the right wall with a velocity (m/s) into it.
fn after_a_contact(scheme: &str, velocity: f64) -> (f64, f64) {
    let scene = text_scene("closed", CLOSED, &[("scheme", scheme)]);
    let mut particles = seeds(&scene);
    let at = DVec3::new(0.975, 0.475, 0.0);
    let stray = particles.iter_mut().find(|particle| particle.position.distance(at) < 1e-9).expect("fluid");
    (stray.position.x, stray.velocity.x) = (1.001, velocity);
    let mut simulation = Simulation::builder(scene).particles(particles).build().expect("a simulation");
    simulation.step().expect("a step");
    let time_step = simulation.clock().time_step;
    simulation.step().expect("a step");
    let sum = simulation.body_forces().forces[0];
    (time_step * force(&sum).x, time_step * (sum.pressure_torque + sum.viscous_torque).z)
}

/// A particle behind a wall that flies on is moved back and stops, and the body receives its
/// momentum: with 3 m/s that of 2.5 kg at 1 m/s more than with 2 m/s, at y = 0.475 m.
#[test]
fn particle_moved_back_to_a_wall_leaves_its_momentum_to_the_body() {
    for scheme in SCHEMES {
        let [slow, fast] = [2.0, 3.0].map(|velocity| after_a_contact(scheme, velocity));
        let (impulse, moment) = (fast.0 - slow.0, fast.1 - slow.1);
        println!("{scheme}: {impulse} N s/m, {moment} N s");
        // The steps of both runs differ by 4 %, and so do the impulses of the pressure.
        assert!((impulse / 2.5 - 1.0).abs() < 0.05, "{scheme}: {impulse} N s/m");
        assert!((moment / (-0.475 * 2.5) - 1.0).abs() < 0.05, "{scheme}: {moment} N s");
    }
}
