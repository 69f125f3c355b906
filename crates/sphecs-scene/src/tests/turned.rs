//! Lattices that are turned to the walls.

use glam::{DMat3, DVec3};

use crate::model::{Fill, ParticleSeed, Scene};
use crate::seeds;
use crate::tests::shipped::{names, smoke};
use sphecs_core::particles::zone::Zone;

fn loaded(text: &str, sets: &[(&str, &str)]) -> Scene {
    let scene = Scene::from_text("turned", text).sets(sets.iter().copied()).load();
    scene.unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)))
}

/// Rotation of the lattice of a scene.
fn rotation(scene: &Scene) -> DMat3 {
    match &scene.layout.fill {
        Fill::Lattice(lattice) | Fill::Packed(lattice) => lattice.rotation,
        Fill::WallFitted { .. } => panic!("has no lattice"),
    }
}

const CHANNEL: &str = r#"Scene(
    title: "t", dimensions: 2, spacing: 0.05, smoke: 0.1,
    constants: {"angle": 0.0, "a": "angle*pi/180", "c": "cos(a)", "s": "sin(a)", "H": 0.5, "L": 1.5},
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0),
    domain: Rotated(angle: "angle", shape: Difference([Box(min: (0.0, "-H"), max: ("L", "H")), Circle(center: (0.7, 0.1), radius: 0.2)])),
    inlets: [(at: (0.0, 0.0), towards: ("c", "s"), velocity: Normal(1.0))],
    outlets: [(at: ("L*c", "L*s"), towards: ("c", "s"), condition: WaveEquation())],
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// Square duct or round pipe along x, rotated about an axis askew.
const DUCT: &str = r#"Scene(
    title: "t", dimensions: 3, spacing: 0.05, smoke: 0.1,
    constants: {"angle": 0.0, "a": "angle*pi/180", "c": "cos(a)", "k": "(1 - c)/3", "q": "sin(a)/sqrt(3)"},
    fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0),
    domain: Rotated(angle: "angle", axis: (1.0, 1.0, 1.0), shape: Box(min: (0.0, -0.2, -0.2), max: (0.6, 0.2, 0.2))),
    inlets: [(at: (0.0, 0.0, 0.0), towards: ("c + k", "k + q", "k - q"), velocity: Normal(1.0))],
    outlets: [(at: ("0.6*(c + k)", "0.6*(k + q)", "0.6*(k - q)"), towards: ("c + k", "k + q", "k - q"), condition: WaveEquation())],
    time: (end: 1.0), output: (every: 1.0),
)"#;

/// Returns the particles turned back, in an order that rounding does not change.
fn turned_back(scene: &Scene, by: DMat3) -> Vec<(Zone, [i64; 3], ParticleSeed)> {
    let back = by.transpose();
    let mut all: Vec<_> = seeds(scene)
        .into_iter()
        .filter(|seed| seed.zone != Zone::Reservoir)
        .map(|seed| {
            let position = back * seed.position;
            let key = (position / scene.spacing * 1e4).round().as_i64vec3().to_array();
            (seed.zone, key, ParticleSeed { position, wall_normal: back * seed.wall_normal, ..seed })
        })
        .collect();
    all.sort_by_key(|(zone, key, _)| (*zone as usize, *key));
    all
}

fn check_same(straight: &Scene, turned: &Scene, by: DMat3, what: &str) {
    let (expected, found) = (turned_back(straight, DMat3::IDENTITY), turned_back(turned, by));
    assert_eq!(found.len(), expected.len(), "{what}");
    for ((zone, key, found), (same_zone, same_key, expected)) in found.iter().zip(&expected) {
        assert_eq!((zone, key, found.patch), (same_zone, same_key, expected.patch), "{what}");
        let off = (found.wall_distance - expected.wall_distance).abs();
        assert!(off < 1e-7 * straight.spacing, "{what}: {off} m at {}", found.position);
        assert!(found.wall_normal.distance(expected.wall_normal) < 1e-6, "{what} at {}", found.position);
    }
}

#[test]
fn turned_channel_is_filled_as_the_straight_one() {
    let straight = loaded(CHANNEL, &[]);
    assert_eq!(rotation(&straight), DMat3::IDENTITY);
    for angle in ["15.0", "37.0", "45.0", "-20.0", "-45.0", "70.0", "123.0"] {
        let turned = loaded(CHANNEL, &[("constants.angle", angle)]);
        let degrees: f64 = angle.parse().expect("a number");
        check_same(&straight, &turned, DMat3::from_rotation_z(degrees.to_radians()), angle);
        let towards = turned.inlets[0].patch.towards;
        assert!(!turned.layout.fill.is_oblique(towards), "{angle}");
        // The lattice is turned by 45 degrees at most.
        assert!(rotation(&turned).x_axis.x >= 0.5_f64.sqrt() - 1e-9, "{angle}");
    }
}

#[test]
fn tilted_duct_and_pipe_are_filled_as_those_along_an_axis() {
    let pipe = DUCT.replace(
        "Box(min: (0.0, -0.2, -0.2), max: (0.6, 0.2, 0.2))",
        "Cylinder(from: (0.0, 0.0, 0.0), to: (0.6, 0.0, 0.0), radius: 0.2)",
    );
    assert_ne!(pipe, DUCT);
    for angle in ["20.0", "33.0"] {
        let radians: f64 = angle.parse::<f64>().expect("a number").to_radians();
        let by = DMat3::from_axis_angle(DVec3::ONE.normalize(), radians);
        let turned = loaded(DUCT, &[("constants.angle", angle)]);
        check_same(&loaded(DUCT, &[]), &turned, by, angle);
        // A round pipe may be rolled about its axis; its rows are those of its opening.
        let (straight, tilted) = (loaded(&pipe, &[]), loaded(&pipe, &[("constants.angle", angle)]));
        let rolled = rotation(&tilted);
        assert!((rolled.x_axis - tilted.inlets[0].patch.towards).length() < 1e-9, "{angle}");
        check_same(&straight, &tilted, rolled, angle);
    }
}

/// The tangents of a circle do not count as walls along the axes.
#[test]
fn round_body_does_not_keep_the_lattice_from_turning() {
    let body = "Circle(center: (0.7, 0.1), radius: 0.2)";
    let text = CHANNEL
        .replace(&format!(", {body}"), "")
        .replace("domain: Rotated(", "domain: Difference([Rotated(")
        .replace("])),\n", "])), Circle(center: (\"0.7*c\", \"0.7*s\"), radius: 0.2)]),\n");
    assert!(text.contains("0.7*s"), "{text}");
    let scene = loaded(&text, &[("constants.angle", "37.0")]);
    assert!((rotation(&scene).x_axis - scene.inlets[0].patch.towards).length() < 1e-9);
}

/// Mixed directions have no frame of their own: the lattice stays along the axes, as do those of
/// all shipped scenes but the one that is about it.
#[test]
fn lattice_stays_along_the_axes_unless_one_frame_serves_the_walls() {
    for (what, domain) in [
        ("wedge", "Polygon(points: [(0.0, -0.2), (1.5, -0.4), (1.5, 0.4), (0.0, 0.2)])"),
        ("one wall along x", "Polygon(points: [(0.0, -0.2), (1.5, -0.2), (1.5, 0.7), (0.0, 0.2)])"),
        ("circle", "Circle(center: (0.0, 0.0), radius: 0.4)"),
    ] {
        let text = format!(
            "Scene(title: \"t\", dimensions: 2, spacing: 0.05, smoke: 0.1,
                fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 15.0), domain: {domain},
                initial: (velocity: (0.1, 0.0)), time: (end: 1.0), output: (every: 1.0))"
        );
        assert_eq!(rotation(&loaded(&text, &[])), DMat3::IDENTITY, "{what}");
    }
    for name in names().into_iter().filter(|name| name != "orientation.ron") {
        if let Fill::Lattice(lattice) = &smoke(&name).layout.fill {
            assert_eq!(lattice.rotation, DMat3::IDENTITY, "{name}");
        }
    }
}

#[test]
fn angle_of_the_lattice_can_be_set() {
    let along_the_axes = loaded(CHANNEL, &[("constants.angle", "37.0"), ("fill", "Lattice(angle: 0.0)")]);
    assert_eq!(rotation(&along_the_axes), DMat3::IDENTITY);
    assert!(along_the_axes.layout.fill.is_oblique(along_the_axes.inlets[0].patch.towards));
    let set = loaded(CHANNEL, &[("constants.angle", "37.0"), ("fill", "Lattice(angle: 37.0)")]);
    let chosen = loaded(CHANNEL, &[("constants.angle", "37.0")]);
    let off = rotation(&set) - rotation(&chosen);
    assert!(off.to_cols_array().iter().all(|component| component.abs() < 1e-15), "{off}");
}

#[test]
fn anchor_of_a_turned_lattice_is_a_corner_of_its_cells() {
    let anchor = DVec3::new(0.313, 0.402, 0.0);
    let fill = format!("Lattice(anchor: ({:?}, {:?}))", anchor.x, anchor.y);
    let scene = loaded(CHANNEL, &[("constants.angle", "37.0"), ("fill", &fill)]);
    let back = rotation(&scene).transpose();
    for seed in seeds(&scene).iter().filter(|seed| seed.zone == Zone::Fluid) {
        let cells = back * (seed.position - anchor) / scene.spacing;
        for cell in [cells.x, cells.y] {
            assert!((cell - 0.5 - (cell - 0.5).round()).abs() < 1e-9, "{cell} spacings from the anchor");
        }
    }
}
