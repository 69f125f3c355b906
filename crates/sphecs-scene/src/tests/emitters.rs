//! Columns, particles and faults of emitters.

use std::f64::consts::{PI, TAU};

use crate::emitters::Emitter;
use crate::emitters::swept_region::SweptRegion;
use crate::model::Scene;
use crate::movers::Wall;
use crate::spawn::seeds;
use sphecs_core::particles::zone::Zone;

fn text(dimensions: u32, fields: &str) -> String {
    format!(
        "Scene(title: \"t\", dimensions: {dimensions}, spacing: 0.02, smoke: 0.02, {fields}
            fluid: (density: 1000.0, viscosity: 1.0e-3, sound_speed: 10.0), reference: (velocity: 1.0),
            time: (end: 1.0), output: (every: 1.0))"
    )
}

fn scene(dimensions: u32, fields: &str) -> Scene {
    let text = text(dimensions, fields);
    Scene::from_text("emitters", &text).load().unwrap_or_else(|faults| panic!("{faults:?}\n{text}"))
}

/// Returns the faults of a scene with these fields, as text.
fn faults(dimensions: u32, fields: &str) -> String {
    let errors = Scene::from_text("emitters", text(dimensions, fields)).load().err();
    let faults = errors.iter().flat_map(|errors| errors.faults());
    let texts = faults.map(|fault| format!("{} | {} | {:?}", fault.title, fault.label, fault.help));
    texts.collect::<Vec<_>>().join("\n")
}

const SQUARE: &str = "domain: Box(min: (-1.0, -1.0), max: (1.0, 1.0)),
    outlets: [(name: \"end\", at: (1.0, 0.0), towards: (1.0, 0.0))],";

const CUBE: &str = "domain: Box(min: (-0.6, -0.6, -0.6), max: (0.6, 0.6, 0.6)),
    outlets: [(name: \"end\", at: (0.6, 0.0, 0.0), towards: (1.0, 0.0, 0.0))],";

fn rotor(shape: &str) -> String {
    format!("movers: [(name: \"rotor\", shape: {shape}, motion: Rotation(about: (0.0, 0.0), rate: 1.0))],")
}

fn ball(radius: f64) -> String {
    format!(
        "movers: [(name: \"ball\", shape: Sphere(center: (0.0, 0.0, 0.0), radius: {radius}), \
         motion: Translation(displacement: (\"0.01*t\", 0.0, 0.0)))],"
    )
}

/// Returns the smallest and the largest area of the columns, over the spacing to the power of their
/// dimensions.
fn areas(emitter: &Emitter, cell: f64) -> [f64; 2] {
    let areas = emitter.columns.iter().map(|column| column.area / cell);
    [areas.clone().fold(f64::INFINITY, f64::min), areas.fold(0.0, f64::max)]
}

#[test]
fn columns_of_a_circle_have_equal_arcs_and_its_curvature() {
    let fields = "emitters: [(on: \"rotor\", velocity: Normal(0.1))],";
    let scene = scene(2, &format!("{SQUARE} {} {fields}", rotor("Circle(center: (0.1, 0.0), radius: 0.3)")));
    let emitter = &scene.emitters[0];
    assert_eq!(emitter.wall, Wall::Mover(0));
    assert!((emitter.area() / (TAU * 0.3) - 1.0).abs() < 1e-3, "{} m", emitter.area());
    assert_eq!(emitter.columns.len() as f64, (TAU * 0.3 / 0.02_f64).round());
    for column in &emitter.columns {
        let radius = column.foot - glam::DVec3::new(0.1, 0.0, 0.0);
        assert!((radius.length() - 0.3).abs() < 1e-6 && radius.normalize().dot(column.normal) > 0.9999);
        assert!((column.curvature_sum * 0.3 - 1.0).abs() < 0.01, "{}", column.curvature_sum);
    }
    let [least, most] = areas(emitter, 0.02);
    assert!(most - least < 1e-9);
}

#[test]
fn a_region_cuts_the_surface_and_mass_flow_is_exact() {
    let jet = "emitters: [
        (name: \"bottom\", region: Box(min: (-0.313, -1.2), max: (0.2, -0.9)), velocity: Normal(\"0.1*(1 + t)\")),
        (name: \"bar\", on: \"rotor\", region: Box(min: (-0.1, 0.0), max: (0.1, 0.2)),
            velocity: MassFlow(rate: 30.0, profile: \"1 + x\")),
        (name: \"flux\", on: \"rotor\", region: Box(min: (-0.1, -0.2), max: (0.1, 0.0)),
            velocity: MassFlux(flux: 30.0)),
    ],";
    let fields = format!("{SQUARE} {} {jet}", rotor("Box(min: (-0.3, -0.15), max: (0.3, 0.15))"));
    let scene = scene(2, &fields);
    let [bottom, bar, flux] = &scene.emitters[..] else { panic!("three emitters") };
    assert_eq!((bottom.wall, bottom.columns.len()), (Wall::Casing, 26));
    assert!((bottom.area() - 0.513).abs() < 1e-9, "{} m", bottom.area());
    assert!((bottom.volume_flow(1.0) - 0.1026).abs() < 1e-9);
    for (emitter, rate) in [(bar, 30.0), (flux, 30.0 * 0.2)] {
        assert!((emitter.area() - 0.2).abs() < 1e-9, "{} m", emitter.area());
        assert!((emitter.volume_flow(0.5) * 1000.0 / rate - 1.0).abs() < 1e-12);
        let is_flat = |column: &sphecs_core::boundary::inlet::emitter_column::EmitterColumn| {
            column.curvature_sum.abs() < 1e-6 && column.normal.y.abs() > 0.999_999
        };
        assert!(emitter.columns.iter().all(is_flat));
    }
}

#[test]
fn wall_particles_make_way_for_columns() {
    let jet = "emitters: [(region: Box(min: (-0.3, -1.2), max: (0.3, -0.9)), velocity: Normal(0.1))],";
    let scene = scene(2, &format!("{SQUARE} {jet}"));
    let seeds = seeds(&scene);
    let inflow: Vec<_> = seeds.iter().filter(|seed| seed.zone == Zone::Inflow).collect();
    assert_eq!(inflow.len(), 30 * 4);
    assert!(inflow.iter().all(|seed| seed.velocity.y == 0.1 && seed.velocity.x.abs() < 1e-9));
    let others = seeds.iter().filter(|seed| matches!(seed.zone, Zone::Fluid | Zone::Wall));
    for seed in others {
        let nearest = inflow.iter().map(|other| other.position.distance(seed.position)).fold(1.0, f64::min);
        assert!(nearest > 0.69 * 0.02, "{nearest} m at {}", seed.position);
    }
}

#[test]
fn columns_of_a_sphere_are_even() {
    let fields = "emitters: [(on: \"ball\", velocity: Normal(0.1))],";
    let scene = scene(3, &format!("{CUBE} {} {fields}", ball(0.2)));
    let emitter = &scene.emitters[0];
    assert!((emitter.area() / (4.0 * PI * 0.04) - 1.0).abs() < 2e-3, "{} m²", emitter.area());
    let [least, most] = areas(emitter, 4e-4);
    assert!(least > 0.6 && most < 1.3, "{least} to {most} Δ²");
    for column in &emitter.columns {
        assert!((column.foot.length() - 0.2).abs() < 1e-6);
        assert!(column.foot.normalize().dot(column.normal) > 0.999, "{}", column.normal);
        assert!((column.curvature_sum * 0.1 - 1.0).abs() < 0.1, "{} 1/m", column.curvature_sum);
        assert!((column.curvature_product * 0.04 - 1.0).abs() < 0.2, "{} 1/m²", column.curvature_product);
    }
}

/// A square of whole spacings in a plane keeps the lattice.
#[test]
fn columns_of_a_flat_square_are_a_lattice() {
    let jet =
        "emitters: [(region: Box(min: (-0.1, -0.1, -0.7), max: (0.1, 0.1, -0.5)), velocity: Normal(0.1))],";
    let scene = scene(3, &format!("{CUBE} {jet}"));
    let emitter = &scene.emitters[0];
    assert_eq!(emitter.columns.len(), 100);
    assert!((emitter.area() / 0.04 - 1.0).abs() < 1e-3, "{} m²", emitter.area());
    for column in &emitter.columns {
        assert!((column.area / 4e-4 - 1.0).abs() < 1e-3, "{}", column.area);
        let from_lattice = ((column.foot - 0.01) / 0.02 - ((column.foot - 0.01) / 0.02).round()).with_z(0.0);
        assert!(from_lattice.length() < 0.05, "{}", column.foot);
        assert!(column.curvature_sum == 0.0 && column.curvature_product == 0.0);
    }
}

#[test]
fn emitters_need_a_smooth_surface_and_solid_behind_it() {
    let bar = rotor("Box(min: (-0.3, -0.04), max: (0.3, 0.04))");
    let cases = [
        ("(velocity: Normal(0.1))", "must have `on`, `region` or both"),
        ("(on: \"rotr\", velocity: Normal(0.1))", "no surface has the name `rotr`"),
        ("(on: \"rotr\", velocity: Normal(0.1))", "did you mean `rotor`"),
        ("(region: Circle(center: (0.0, 0.0), radius: 0.3), velocity: Normal(0.1))", "has no surface there"),
        ("(on: \"rotor\", velocity: Normal(0.1))", "must be at least 0.1 m thick"),
        (
            "(on: \"rotor\", region: Box(min: (-0.1, 0.0), max: (0.1, 0.1)), velocity: Normal(0.1))",
            "must be at least 0.1 m thick",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: Components((0.1, 0.0)))",
            "must be `Normal`, `TimeTable`, `MassFlow` or `MassFlux`",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: Normal(\"0.5 - t\"))",
            "an emitter draws fluid in",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: Normal(\"1/(t - 0.5)\"))",
            "an emitter draws fluid in",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: MassFlow(rate: 1.0, profile: \"x\"))",
            "carries nothing into the domain",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: Normal(0.1), depth: 1e9)",
            "a zone is too long",
        ),
        (
            "(region: Box(min: (-0.1, -1.1), max: (0.1, -0.9)), velocity: Normal(0.1), depth: 0.01)",
            "must be at least",
        ),
        ("(name: \"end\", on: \"rotor\", velocity: Normal(0.1), points: 3)", "unknown field `points`"),
    ];
    for (emitter, expected) in cases {
        let found = faults(2, &format!("{SQUARE} {bar} emitters: [{emitter}],"));
        assert!(found.contains(expected), "{emitter}: {found}");
    }
    let thick = rotor("Box(min: (-0.3, -0.2), max: (0.3, 0.2))");
    let corner =
        "emitters: [(on: \"rotor\", region: Box(min: (0.2, 0.1), max: (0.4, 0.3)), velocity: Normal(0.1))],";
    assert!(faults(2, &format!("{SQUARE} {thick} {corner}")).contains("has an edge near"));
    let face =
        "emitters: [(on: \"rotor\", region: Box(min: (0.2, -0.2), max: (0.4, 0.2)), velocity: Normal(0.1))],";
    let scene = scene(2, &format!("{SQUARE} {thick} {face}"));
    assert!((scene.emitters[0].area() - 0.4).abs() < 1e-6, "{} m", scene.emitters[0].area());
    let small = rotor("Circle(center: (0.0, 0.0), radius: 0.1)");
    let found = faults(2, &format!("{SQUARE} {small} emitters: [(on: \"rotor\", velocity: Normal(0.1))],"));
    assert!(found.contains("curved too tightly"), "{found}");
    let twice = "emitters: [(name: \"a\", on: \"rotor\", velocity: Normal(0.1)),
        (name: \"A\", on: \"rotor\", velocity: Normal(0.1))],";
    assert!(faults(2, &format!("{SQUARE} {bar} {twice}")).contains("same name in the results"));
    let unwalled =
        "walls: None, emitters: [(region: Box(min: (0.0, 0.0), max: (1.0, 1.0)), velocity: Normal(0.1))],";
    assert!(faults(2, &format!("{SQUARE} {unwalled}")).contains("scene without walls"));
}

/// Returns a scene with an emitter on a bar that turns about a point beside it.
fn turning_bar(motion: &str) -> Scene {
    let bar = format!(
        "movers: [(name: \"rotor\", shape: Box(min: (0.1, -0.1), max: (0.6, 0.1)), motion: {motion})],
        emitters: [(on: \"rotor\", region: Box(min: (0.58, -0.06), max: (0.7, 0.06)), velocity: Normal(0.1))],"
    );
    scene(2, &format!("{SQUARE} {bar}"))
}

#[test]
fn columns_of_a_turning_emitter_do_not_leave_their_shell() {
    let scene = turning_bar("Rotation(about: (0.1, 0.05), rate: 1.0)");
    let emitter = &scene.emitters[0];
    let region = emitter.swept_region(&scene);
    let SweptRegion::Shell { about, .. } = region else { panic!("{region:?}") };
    let mut farthest = 0.0_f64;
    for time in 0..50 {
        let pose = scene.movers[0].motion.pose(0.37 * f64::from(time));
        for (column, part) in
            emitter.columns.iter().flat_map(|column| [(column, 0.0), (column, 0.5), (column, 1.0)])
        {
            let place = pose.place(column.point(part * emitter.depth));
            assert_eq!(region.distance(&scene, place), 0.0, "{place}");
            farthest = farthest.max(place.distance(about));
        }
    }
    // It is not much larger.
    let beyond = about + glam::DVec3::X * (farthest + emitter.depth);
    assert!((region.distance(&scene, beyond) / emitter.depth - 0.5).abs() < 0.1, "{region:?}");
    assert!(region.distance(&scene, about) > 0.2);
    let moved = turning_bar("Translation(displacement: (\"0.01*t\", 0.0))");
    assert_eq!(moved.emitters[0].swept_region(&moved), SweptRegion::Everywhere);
}
