//! Sections of openings that are no rectangle.

use crate::model::{Patch, Scene};
use crate::opening_figures::opening_figures;
use crate::seeds;
use crate::summary::summary;
use sphecs_core::particles::zone::Zone;

/// Returns a 3D scene along x from 0 to 0.2 m.
fn scene(domain: &str, inlets: &str, outlets: &str) -> Scene {
    let text = format!(
        "Scene(title: \"t\", dimensions: 3, spacing: 0.005,
        fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0),
        domain: {domain}, inlets: [{inlets}], outlets: [{outlets}],
        time: (end: 1.0), output: (every: 0.1))"
    );
    Scene::from_text("openings", text)
        .load()
        .unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)))
}

/// Returns an opening at a point of the plane x = 0 (an inlet of 0.1 m/s) or x = 0.2 m.
fn opening(y: f64, z: f64, more: &str, is_inlet: bool) -> String {
    let (x, velocity) = if is_inlet { (0.0, "velocity: Normal(0.1),") } else { (0.2, "") };
    format!("(at: ({x:?}, {y:?}, {z:?}), towards: (1.0, 0.0, 0.0), {velocity} {more})")
}

fn check_section(patch: &Patch, area: f64, perimeter: f64) {
    assert!((patch.area / area - 1.0).abs() < 1e-3, "area {} m², exact {area}", patch.area);
    let found = patch.perimeter;
    assert!((found / perimeter - 1.0).abs() < 0.02, "perimeter {found} m, exact {perimeter}");
}

#[test]
fn ring_is_measured_and_filled_without_its_core() {
    let ring = "Difference([
        Cylinder(from: (0.0, 0.0, 0.0), to: (0.2, 0.0, 0.0), radius: 0.06),
        Cylinder(from: (-1.0, 0.0, 0.0), to: (1.0, 0.0, 0.0), radius: 0.03)])";
    let scene = scene(ring, &opening(0.045, 0.0, "", true), &opening(0.0, -0.04, "", false));
    let pi = std::f64::consts::PI;
    for patch in [&scene.inlets[0].patch, &scene.outlets[0].patch] {
        check_section(patch, pi * (0.06_f64.powi(2) - 0.03_f64.powi(2)), pi * 0.18);
        assert!(patch.at.truncate().y.abs() < 1e-6 && patch.at.z.abs() < 1e-6, "centre at {}", patch.at);
        assert!((patch.half_extent[0] - 0.06).abs() < 1e-5, "{:?}", patch.half_extent);
        assert!(!patch.covers(patch.at, 0.01) && patch.covers(patch.at + patch.across[0] * 0.05, 0.0));
    }
    let seeds = seeds(&scene);
    let count = |zone: Zone| seeds.iter().filter(|seed| seed.zone == zone).count();
    let layers = |zone: Zone, depth: f64| count(zone) as f64 / (depth / scene.spacing);
    // All layers of the zones and of the fluid are alike.
    let (inflow, outflow) = (layers(Zone::Inflow, 0.025), layers(Zone::Outflow, 0.04));
    assert_eq!((inflow, outflow), (layers(Zone::Fluid, 0.2), inflow));
    let core =
        seeds.iter().filter(|seed| seed.zone != Zone::Reservoir && seed.position.with_x(0.0).length() < 0.03);
    assert!(core.clone().count() > 0 && core.clone().all(|seed| seed.zone == Zone::Wall));
    let figures = opening_figures(&scene, 1.0);
    assert!(figures.iter().all(|figures| figures.velocities.iter().all(|(_, v)| (v - 0.1).abs() < 1e-9)));
}

#[test]
fn corner_shapes_have_their_own_area() {
    let corner = "Union([Box(min: (0.0, 0.0, 0.0), max: (0.2, 0.06, 0.02)),
        Box(min: (0.0, 0.0, 0.0), max: (0.2, 0.02, 0.06))])";
    let scene = scene(corner, &opening(0.05, 0.01, "", true), &opening(0.01, 0.05, "", false));
    for patch in [&scene.inlets[0].patch, &scene.outlets[0].patch] {
        check_section(patch, 0.002, 0.24);
        assert!((patch.at.y - 0.03).abs() < 1e-6 && (patch.at.z - 0.03).abs() < 1e-6, "{}", patch.at);
    }
    let half_disc = "Intersection([Cylinder(from: (0.0, 0.0, 0.0), to: (0.2, 0.0, 0.0), radius: 0.05),
        Box(min: (-1.0, 0.0, -1.0), max: (1.0, 1.0, 1.0))])";
    let scene = self::scene(half_disc, &opening(0.02, 0.0, "", true), &opening(0.02, 0.03, "", false));
    let pi = std::f64::consts::PI;
    for patch in [&scene.inlets[0].patch, &scene.outlets[0].patch] {
        check_section(patch, 0.5 * pi * 0.0025, pi * 0.05 + 0.1);
    }
}

#[test]
fn plate_divides_an_end_into_parts() {
    let divided = "Difference([Box(min: (0.0, -0.04, 0.0), max: (0.2, 0.04, 0.04)),
        Box(min: (0.1, -0.01, -1.0), max: (1.0, 0.01, 1.0))])";
    let inlet = opening(0.0, 0.02, "", true);
    let notes = |scene: &Scene| summary(scene, &[]).notes.join("\n");
    let zone = |scene: &Scene, side: f64| {
        let seeds = seeds(scene);
        seeds.iter().filter(|seed| seed.zone == Zone::Outflow && seed.position.y * side > 0.0).count()
    };

    let one = scene(divided, &inlet, &opening(0.02, 0.02, "", false));
    check_section(&one.outlets[0].patch, 0.03 * 0.04, 0.14);
    assert_eq!((zone(&one, 1.0), zone(&one, -1.0)), (6 * 8 * 8, 0));
    assert!(notes(&one).contains("another part, 0.0012"), "{}", notes(&one));
    // The closed part is bounded by a wall.
    let walls = seeds(&one);
    let behind = walls.iter().filter(|seed| seed.position.x > 0.2 && (seed.position.y + 0.025).abs() < 0.005);
    assert!(behind.clone().count() > 0 && behind.clone().all(|seed| seed.zone == Zone::Wall));

    let closed = scene(divided, &inlet, &opening(0.02, 0.02, "closed: true", false));
    assert_eq!(notes(&closed), "");

    let whole = scene(divided, &inlet, &opening(0.02, 0.02, "extent: Whole", false));
    check_section(&whole.outlets[0].patch, 2.0 * 0.03 * 0.04, 0.28);
    assert_eq!((zone(&whole, 1.0), zone(&whole, -1.0)), (6 * 8 * 8, 6 * 8 * 8));
    assert_eq!(notes(&whole), "");

    let outlets = [opening(0.02, 0.02, "", false), opening(-0.02, 0.02, "", false)].join(",");
    let two = scene(divided, &inlet, &outlets);
    assert_eq!((zone(&two, 1.0), zone(&two, -1.0)), (6 * 8 * 8, 6 * 8 * 8));
    assert_eq!(notes(&two), "");
}

#[test]
fn one_plane_may_hold_a_jet_in_a_stream() {
    let nozzle = "Difference([Cylinder(from: (0.0, 0.0, 0.0), to: (0.2, 0.0, 0.0), radius: 0.06),
        Difference([Cylinder(from: (-1.0, 0.0, 0.0), to: (0.05, 0.0, 0.0), radius: 0.035),
            Cylinder(from: (-1.0, 0.0, 0.0), to: (0.06, 0.0, 0.0), radius: 0.025)])])";
    let inlets = [opening(0.0, 0.0, "", true), opening(0.05, 0.0, "", true)].join(",");
    let scene = scene(nozzle, &inlets, &opening(0.0, 0.0, "", false));
    let pi = std::f64::consts::PI;
    check_section(&scene.inlets[0].patch, pi * 0.025 * 0.025, pi * 0.05);
    check_section(&scene.inlets[1].patch, pi * (0.06_f64.powi(2) - 0.035_f64.powi(2)), pi * 0.19);
    for seed in seeds(&scene).iter().filter(|seed| seed.zone == Zone::Inflow) {
        let radius = seed.position.with_x(0.0).length();
        assert_eq!(seed.patch, u16::from(radius > 0.03), "a particle at the radius {radius} m");
    }
    assert!(summary(&scene, &[]).notes.is_empty());
}

#[test]
fn plate_in_a_channel_leaves_two_slits() {
    let text = |more: &str| {
        format!(
            "Scene(title: \"t\", dimensions: 2, spacing: 0.001,
            fluid: (density: 1000.0, viscosity: 1.0e-5, sound_speed: 2.0),
            domain: Difference([Box(min: (0.0, -0.02), max: (0.2, 0.02)), Box(min: (0.12, -0.002), max: (1.0, 0.002))]),
            inlets: [(at: (0.0, 0.0), towards: (1.0, 0.0), velocity: Normal(0.1))],
            outlets: [(at: (0.2, 0.01), towards: (1.0, 0.0){more})],
            time: (end: 1.0), output: (every: 0.1))"
        )
    };
    let load = |more: &str| Scene::from_text("plate", text(more)).load().expect("a scene");
    let one = load("").outlets[0].patch.clone();
    assert!((one.area - 0.018).abs() < 1e-9 && one.perimeter == 2.0 && one.raster.is_none(), "{one:?}");
    let whole = load(", extent: Whole").outlets[0].patch.clone();
    assert!((whole.area - 0.036).abs() < 1e-5, "{} m", whole.area);
    assert!((whole.perimeter - 4.0).abs() < 1e-9 && whole.at.y.abs() < 1e-9, "{}", whole.perimeter);
    assert!(!whole.covers(whole.at, 0.0015) && whole.covers(whole.at, 0.0021));
}
