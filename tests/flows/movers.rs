//! Walls that move: poses, forces, fluid that stays on its side.

use sphecs::Simulation;
use sphecs::bevy_ecs::query::With;
use sphecs::glam::DVec3;
use sphecs_engine::components::{ParticleId, Position, Velocity, Wall};

use crate::common::{Sets, advance, simulation, text_scene};
use crate::{flow, fluid};

/// Numbers, wall parts, positions (m) and velocities (m/s) of the wall particles.
fn walls(simulation: &mut Simulation) -> Vec<(u32, u16, DVec3, DVec3)> {
    let world = simulation.world_mut();
    let mut query = world.query_filtered::<(&ParticleId, &Wall, &Position, &Velocity), With<Wall>>();
    let mut found: Vec<_> = query
        .iter(world)
        .map(|(id, wall, position, velocity)| (id.0, wall.part, position.0, velocity.0))
        .collect();
    found.sort_by_key(|(id, ..)| *id);
    found
}

/// A paddle that turns about a point that moves, in a closed box.
const PADDLE: &str = r#"Scene(
    title: "Paddle", dimensions: 2, spacing: 0.05, smoke: 0.05,
    fluid: (density: 1000.0, viscosity: 0.05, sound_speed: 20.0),
    domain: Box(min: (-1.0, -1.0), max: (1.0, 1.0)),
    movers: [(
        name: "paddle", shape: Box(min: (-0.5, -0.1), max: (0.5, 0.1)),
        motion: Chain([
            Rotation(about: (0.1, 0.0), radians: "1.5*t^2"),
            Translation(displacement: ("0.1*sin(3*t)", "0.05*t")),
        ]),
    )],
    bodies: [(part: "paddle", about: (0.1, 0.0))],
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
)"#;

/// Checks that the particles of a mover are where its motion puts them, and as fast.
fn check_poses(text: &str, sets: Sets, steps: u64, tolerance: f64) {
    let scene = text_scene("movers", text, sets);
    let mut run = simulation(scene.clone());
    let before = walls(&mut run);
    advance(&mut run, steps);
    let time = run.clock().time;
    let (start, now) = (scene.wall_poses(0.0), scene.wall_poses(time));
    let mut count = 0;
    for ((id, part, first, _), (other, _, position, velocity)) in before.into_iter().zip(walls(&mut run)) {
        assert_eq!(id, other);
        let (Some(start), Some(pose)) = (scene.pose_of_part(&start, part), scene.pose_of_part(&now, part))
        else {
            assert_eq!(position, first, "a wall at rest moved");
            continue;
        };
        count += 1;
        let expected = pose.place(start.reference(first));
        assert!(position.distance(expected) < 1e-12, "{position}, must be {expected}");
        // The velocity is that of the surface in front of the particle, at most four spacings away.
        let slip = pose.spin.length() * 4.0 * scene.spacing;
        let own = pose.velocity_at(position);
        assert!(velocity.distance(own) < slip + tolerance, "{velocity}, its own place has {own}");
    }
    assert!(count > 20, "{count} particles move");
    let row = run.monitor_row();
    assert_eq!(row.through_walls, 0, "fluid is behind a wall");
}

#[test]
fn particles_of_a_mover_are_where_its_motion_puts_them() {
    check_poses(PADDLE, &[], 300, 1e-12);
    check_poses(PADDLE, &[("scheme", "EdacTvf()"), ("precision", "F32")], 300, 1e-6);
}

#[test]
fn particles_of_a_mover_in_3d_are_where_its_motion_puts_them() {
    let text = r#"Scene(
        title: "Rotor", dimensions: 3, spacing: 0.1, smoke: 0.1,
        fluid: (density: 1000.0, viscosity: 0.05, sound_speed: 20.0),
        domain: Cylinder(from: (0.0, 0.0, -0.6), to: (0.0, 0.0, 0.6), radius: 1.0),
        movers: [(
            name: "rotor", shape: Box(min: (-0.6, -0.2, -0.2), max: (0.6, 0.2, 0.2)),
            motion: Rotation(about: (0.0, 0.0, 0.0), axis: (0.2, 0.1, 1.0), rate: "2*t"), slip: FreeSlip,
        )],
        bodies: [(part: "rotor")],
        reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
    )"#;
    check_poses(text, &[], 60, 1e-12);
    check_poses(text, &[("scheme", "EdacTvf()"), ("precision", "F32")], 60, 1e-6);
}

/// All walls of a box move; the water inside takes part.
#[test]
fn box_that_moves_carries_its_water() {
    let text = r#"Scene(
        title: "Box", dimensions: 2, spacing: 0.05, smoke: 0.05,
        fluid: (density: 1000.0, viscosity: 0.001, sound_speed: 40.0),
        domain: Box(min: (0.0, 0.0), max: (1.0, 0.5)),
        walls: (slip: FreeSlip, motion: Translation(displacement: ("0.5*t^2", "0.2*t^2"))),
        bodies: [(part: "walls")],
        reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 1.0),
    )"#;
    check_poses(text, &[], 200, 1e-12);
    let mut run = flow(text, &[]);
    run.run_until(1.0).expect("water in a box");
    let fluid = fluid(&mut run);
    let mean = fluid.iter().map(|state| state.velocity).sum::<DVec3>() / fluid.len() as f64;
    assert!(mean.distance(DVec3::new(1.0, 0.4, 0.0)) < 0.01, "{mean} m/s");
    assert!(fluid.iter().all(|state| (0.5..=1.5).contains(&state.position.x)), "water left the box");
}

/// Weight of the water before a piston, which is at rest. The force on the particles of the piston
/// alone was 6 % too small: those in the corners belong to the wall beside it.
#[test]
fn force_of_a_piston_includes_its_corners() {
    let text = r#"Scene(
        title: "Piston", dimensions: 2, spacing: 0.02, smoke: 0.02,
        fluid: (density: 1000.0, viscosity: 0.01, sound_speed: 20.0),
        domain: Box(min: (-0.1, 0.0), max: (0.4, 0.2)), walls: (slip: FreeSlip),
        movers: [(
            name: "piston", shape: Box(min: (-0.4, 0.0), max: (0.0, 0.2)),
            motion: Translation(displacement: (0.0, 0.0)),
        )],
        body_force: (-1.0, 0.0),
        bodies: [(part: "piston")],
        outlets: [(at: (0.4, 0.1), towards: (1.0, 0.0), condition: Pressure(value: 0.0))],
        reference: (velocity: 1.0, length: 0.2), time: (end: 2.0), output: (every: 1.0),
    )"#;
    for scheme in ["Wcsph()", "EdacTvf()"] {
        let mut run = flow(text, &[("scheme", scheme)]);
        run.run_until(1.0).expect("water at rest");
        let (mut sum, mut count) = (0.0, 0);
        while run.clock().time < 2.0 {
            run.step().expect("a step");
            let forces = run.body_forces().forces[0];
            sum += forces.pressure_force.x + forces.viscous_force.x;
            count += 1;
        }
        let (force, weight) = (sum / f64::from(count), -1000.0 * 0.4 * 0.2);
        println!("{scheme}: force of the piston {force:.2} of {weight} N/m");
        assert!((force / weight - 1.0).abs() < 0.03, "{scheme}: {force} of {weight} N/m");
    }
}

/// A body that leaves through one side of a periodic channel comes in through the other.
#[test]
fn mover_passes_a_periodic_face() {
    let tow = |x: f64| {
        let text = format!(
            r#"Scene(
        title: "Towed", dimensions: 2, spacing: 0.05, smoke: 0.05,
        fluid: (density: 1000.0, viscosity: 0.05, sound_speed: 20.0),
        domain: Box(min: (-1.0, -0.75), max: (1.0, 0.75)), walls: (slip: FreeSlip),
        movers: [(
            name: "cylinder", shape: Circle(center: ({x}, 0.0), radius: 0.25), slip: NoSlip,
            motion: Translation(velocity: ("1 - exp(-(t/0.2)^2)", 0.0)),
            fill: Concentric(center: ({x}, 0.0), radius: 0.25),
        )],
        bodies: [(part: "cylinder")], periodic: ["x"],
        reference: (velocity: 1.0, length: 0.5), time: (end: 1.0), output: (every: 1.0),
    )"#
        );
        let mut run = flow(&text, &[("scheme", "EdacTvf()")]);
        let count = fluid(&mut run).len();
        let mut forces = Vec::new();
        while run.clock().time < 0.9 {
            run.step().expect("a step");
            forces.push(run.body_forces().forces[0].pressure_force.x);
        }
        assert_eq!(fluid(&mut run).len(), count);
        assert_eq!(run.monitor_row().through_walls, 0);
        forces
    };
    // A channel without ends has no place that differs from another. The one cylinder lies within
    // the channel throughout; the face cuts the other, half a channel (20 spacings) further on.
    let [within, cut] = [tow(-0.7), tow(0.3)];
    let scale = within.iter().fold(0.0_f64, |largest, force| largest.max(force.abs()));
    let difference = within.iter().zip(&cut).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    println!("largest difference {difference:.3e} N/m of {scale:.2} N/m");
    assert!(within.iter().rev().take(100).sum::<f64>() < 0.0, "the drag is against the motion");
    assert!(difference < 1e-6 * scale, "{difference} N/m of {scale} N/m");
}
