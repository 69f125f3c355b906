//! Weights of the flow through openings, in channels and a junction.

use crate::Scene;
use crate::potential_flow::{PotentialFlow, potential_flows};
use glam::DVec3;

fn scene(domain: &str, openings: &str) -> Scene {
    let text = format!(
        r#"Scene(
    title: "Potential", dimensions: 2, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 20.0),
    domain: {domain}, {openings},
    reference: (velocity: 1.0, length: 1.0),
    time: (end: 1.0), output: (every: 0.5),
)"#
    );
    Scene::from_text("potential", text).load().expect("a scene")
}

/// Returns the flow of a velocity field out of each outlet.
fn flows(scene: &Scene, velocity: impl Fn(DVec3) -> DVec3) -> Vec<f64> {
    let (low, high) = scene.domain.bounds();
    let count = |axis: usize| ((high[axis] - low[axis]) / scene.spacing).round() as u32;
    let place = |axis: usize, index: u32| low[axis] + (f64::from(index) + 0.5) * scene.spacing;
    let points: Vec<DVec3> = (0..count(0))
        .flat_map(|i| (0..count(1)).map(move |j| (i, j)))
        .map(|(i, j)| DVec3::new(place(0, i), place(1, j), 0.0))
        .collect();
    let flow_of = |flow: Option<PotentialFlow>| {
        let flow = flow.expect("a flow");
        let gradient = |at: DVec3| DVec3::from(flow.gradient(at).map(f64::from));
        points.iter().map(|at| gradient(*at).dot(velocity(*at))).sum::<f64>() * scene.spacing.powi(2)
    };
    potential_flows(scene, |_| true).into_iter().map(flow_of).collect()
}

const CHANNEL: &str =
    "outlets: [(at: (6.0, 0.5), towards: (1.0, 0.0)), (at: (0.0, 0.5), towards: (-1.0, 0.0))]";

#[test]
fn flow_through_a_channel_is_its_mean_velocity_times_the_width() {
    let channel = scene("Box(min: (0.0, 0.0), max: (6.0, 1.0))", CHANNEL);
    let found = flows(&channel, |at| DVec3::X * (at.y * (1.0 - at.y)));
    let square = potential_flows(&channel, |_| true)[0].as_ref().map(|flow| flow.square);
    // |∇φ| is one over the length. φ is linear, over 6 m².
    let overlaps = potential_flows(&channel, |_| true).remove(0).expect("a flow").overlaps;
    let conductances = potential_flows(&channel, |_| true).remove(0).expect("a flow").conductances;
    assert!((conductances[0] + conductances[1]).abs() < 1e-6, "{conductances:?}");
    assert!((overlaps[0] - 2.0).abs() < 1e-3 && (overlaps[1] - 1.0).abs() < 1e-3, "{overlaps:?}");
    assert!(square.is_some_and(|square| (square - 1.0 / 6.0).abs() < 1e-6), "{square:?}");
    let exact: f64 = (0..20).map(|row| (f64::from(row) + 0.5) / 20.0).map(|y| 0.05 * y * (1.0 - y)).sum();
    assert!((found[0] - exact).abs() < 1e-6 && (found[1] + exact).abs() < 1e-6, "{found:?}");
}

#[test]
fn standing_waves_between_openings_do_not_count() {
    let channel = scene("Box(min: (0.0, 0.0), max: (6.0, 1.0))", CHANNEL);
    for mode in 1..4 {
        let wave = |at: DVec3| DVec3::X * (f64::from(mode) * std::f64::consts::PI * at.x / 6.0).cos();
        let found = flows(&channel, wave);
        assert!(found[0].abs() < 1e-9, "{found:?}");
    }
}

#[test]
fn flow_of_a_junction_divides_by_its_branches() {
    let junction = scene(
        "Union([Box(min: (0.0, 0.0), max: (4.0, 1.0)), Box(min: (1.5, 0.5), max: (2.5, 3.0))])",
        "outlets: [(at: (4.0, 0.5), towards: (1.0, 0.0)), (at: (2.0, 3.0), towards: (0.0, 1.0)), \
             (at: (0.0, 0.5), towards: (-1.0, 0.0))]",
    );
    // A stream function without flow through walls: ψ from 0 at the bottom to 1 at the top left
    // and the branch, so that all comes in on the left and leaves on the right.
    let found = flows(&junction, |at| if at.y < 1.0 { DVec3::X } else { DVec3::ZERO });
    assert!((found[0] - 1.0).abs() < 0.02, "{found:?}");
    assert!(found[1].abs() < 0.02 && (found[2] + 1.0).abs() < 0.02, "{found:?}");
    // The outlets together have potential 1: inflow is outflow.
    assert!(found.iter().sum::<f64>().abs() < 1e-6, "{found:?}");
}

#[test]
fn a_single_outlet_takes_all_that_an_inlet_brings() {
    let channel = scene(
        "Box(min: (0.0, 0.0), max: (6.0, 1.0))",
        "inlets: [(at: (0.0, 0.5), towards: (1.0, 0.0), velocity: Normal(1.0))], \
             outlets: [(at: (6.0, 0.5), towards: (1.0, 0.0))]",
    );
    let flow = potential_flows(&channel, |_| true).remove(0).expect("a flow");
    assert!((flow.inlet_potential - 1.0).abs() < 1e-6, "{}", flow.inlet_potential);
}

/// A pipe of 16 whole cells would have 3 % more than the section of the circle.
#[test]
fn flow_through_a_pipe_is_its_mean_velocity_times_the_area() {
    let text = r#"Scene(
    title: "Pipe", dimensions: 3, spacing: 0.125,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 20.0),
    domain: Cylinder(from: (0.0, 0.0, 0.0), to: (4.0, 0.0, 0.0), radius: 1.0),
    outlets: [(at: (4.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0)), (at: (0.0, 0.0, 0.0), towards: (-1.0, 0.0, 0.0))],
    reference: (velocity: 1.0, length: 1.0),
    time: (end: 1.0), output: (every: 0.5),
)"#;
    let pipe = Scene::from_text("pipe", text).load().expect("a scene");
    let flow = potential_flows(&pipe, |_| true).remove(0).expect("a flow");
    // φ is x/4, so that the integral of its square is the area over the length.
    let area = 4.0 * flow.square;
    assert!((area / std::f64::consts::PI - 1.0).abs() < 0.005, "{area}");
    assert!((flow.gradient(DVec3::new(2.1, 0.9, 0.3))[0] - 0.25).abs() < 1e-3);
    assert!((flow.overlaps[0] * 3.0 / area - 4.0).abs() < 0.02, "{:?}", flow.overlaps);
}

/// Oblique walls and openings.
#[test]
fn flow_through_a_turned_channel_is_its_mean_velocity_times_the_width() {
    for angle in [15.0_f64, 37.0, 45.0] {
        let (s, c) = angle.to_radians().sin_cos();
        let turned = scene(
            &format!("Rotated(angle: {angle}, shape: Box(min: (0.0, -0.5), max: (6.0, 0.5)))"),
            &format!(
                "outlets: [(at: ({}, {}), towards: ({c}, {s})), (at: (0.0, 0.0), towards: ({}, {}))]",
                6.0 * c,
                6.0 * s,
                -c,
                -s
            ),
        );
        let flow = potential_flows(&turned, |_| true).remove(0).expect("a flow");
        // φ rises by one over the length of 6 m, in a channel of 6 m².
        assert!((6.0 * flow.square - 1.0).abs() < 0.03, "{angle}°: {}", flow.square);
        assert!((flow.conductances[0] + flow.conductances[1]).abs() < 0.03, "{:?}", flow.conductances);
        let gradient = DVec3::from(flow.gradient(DVec3::new(3.0 * c, 3.0 * s, 0.0)).map(f64::from));
        assert!((gradient - DVec3::new(c, s, 0.0) / 6.0).length() < 0.01, "{angle}°: {gradient}");
    }
}
