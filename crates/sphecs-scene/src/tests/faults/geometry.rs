//! Faults of shapes, openings, periods and particle counts.

use super::{SOUND, check, faults_of};
use crate::Scene;

#[test]
fn degenerate_shapes_are_faults() {
    check("max: (1.0, \"H\")", "max: (-1.0, \"H\")", "a box has no extent along x", "(-1.0, \"H\")");
    let domain = "Box(min: (0.0, 0.0), max: (1.0, \"H\"))";
    check(domain, "Sphere(center: (0.0, 0.0), radius: 1.0)", "`Sphere` needs 3 dimensions", "(0.0, 0.0)");
    check(
        domain,
        "Polygon(points: [(0.0, 0.0), (1.0, 0.4), (1.0, 0.0), (0.0, 0.4)])",
        "a polygon crosses itself",
        "(1.0, 0.0)",
    );
    check(domain, "Polygon(points: [(0.0, 0.0), (1.0, 0.4)])", "a polygon has no area", "[");
}

#[test]
fn openings_must_be_ends_of_the_domain() {
    let report = check(
        "at: (0.0, 0.2), towards: (1.0, 0.0)",
        "at: (-0.1, 0.2), towards: (1.0, 0.0)",
        "not on the domain's surface",
        "(-0.1, 0.2)",
    );
    assert!(report.contains("it begins at (0, 0.2) m"), "{report}");
    let report = check(
        "at: (0.0, 0.2), towards: (1.0, 0.0)",
        "at: (0.3, 0.2), towards: (1.0, 0.0)",
        "the inlet is inside the domain",
        "(0.3, 0.2)",
    );
    assert!(report.contains("(0, 0.2) m"), "{report}");
    check(
        "at: (0.0, 0.2), towards: (1.0, 0.0)",
        "at: (0.0, 0.2), towards: (-1.0, 0.0)",
        "the inlet faces the wrong way",
        "(-1.0, 0.0)",
    );
    check(
        "at: (1.0, 0.2), towards: (1.0, 0.0)",
        "at: (1.0, 0.2), towards: (-1.0, 0.0)",
        "the outlet faces the wrong way",
        "(-1.0, 0.0)",
    );
    check(
        "at: (1.0, 0.2), towards: (1.0, 0.0)",
        "at: (1.0, 0.2), towards: (0.0, 0.0)",
        "`towards` has no direction",
        "(0.0, 0.0)",
    );
    check(
        "at: (1.0, 0.2), towards: (1.0, 0.0)",
        "at: (0.5, 0.4), towards: (0.7, 0.7)",
        "the opening is not a plane end",
        "(0.5, 0.4)",
    );
}

#[test]
fn zones_must_be_longer_than_the_support() {
    let report = check("depth: 0.4", "depth: 0.1", "the zone of the outlet is shorter", "0.1");
    assert!(report.contains("must be at least `0.15` m"), "{report}");
    check("depth: 0.25", "depth: 0.01", "the zone of the inlet is shorter", "0.01");
}

#[test]
fn openings_must_not_overlap() {
    let twice = "outlets: [(at: (1.0, 0.1), towards: (1.0, 0.0), condition: WaveEquation()), (at";
    check("outlets: [(at", twice, "the zones of `outlet 1` and `outlet 0` overlap", "(1.0, 0.2)");
    let named = "outlets: [(name: \"a\", at: (0.5, 0.4), towards: (0.0, 1.0), condition: Orlanski()), (name: \"a\", at";
    check("outlets: [(at", named, "two outlets are called `a`", "\"a\"");
}

#[test]
fn periods_must_fit() {
    check("periodic: []", "periodic: [\"z\"]", "`z` is not an axis", "\"z\"");
    let closed = |text: &str| {
        let inlets = text.find("    inlets").unwrap_or(0);
        let time = text.find("    time").unwrap_or(0);
        format!("{}{}", &text[..inlets], &text[time..])
    };
    let text = closed(&SOUND.replace("periodic: []", "periodic: [\"x\"]"));
    let scene = Scene::from_text("test.ron", &text)
        .load()
        .unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)));
    assert_eq!(scene.periodic, [Some((0.0, 1.0)), None, None]);
    let uneven = text.replace("max: (1.0,", "max: (1.02,");
    let faults = faults_of(&uneven);
    assert!(faults.faults()[0].title.contains("not a whole number of spacings"));
    let slanted = text.replace(
        "Box(min: (0.0, 0.0), max: (1.0, \"H\"))",
        "Polygon(points: [(0,0), (1,0), (1,0.4), (0,0.2)])",
    );
    let faults = faults_of(&slanted);
    assert!(faults.faults()[0].title.contains("do not match"), "{faults:?}");
}

#[test]
fn a_side_without_wall_is_a_fault() {
    check("walls: (slip: NoSlip)", "walls: None", "neither wall nor opening nor periodic", "Box");
}

#[test]
fn more_particles_than_memory_are_refused_with_the_spacing_that_fits() {
    let report = check("spacing: 0.05", "spacing: 1e-7", "too many particles", "1e-7");
    assert!(
        report.contains("particles, that is") && report.contains("raise `spacing` to at least"),
        "{report}"
    );
    check("spacing: 0.05", "spacing: 1e-200", "too many particles", "1e-200");
}

#[test]
fn domain_parts_far_apart_are_refused() {
    for far in ["1e15", "1e20", "1e300"] {
        let apart = format!(
            "domain: Union([Box(min: (0.0, 0.0), max: (1.0, \"H\")), Circle(center: ({far}, 0.0), radius: 0.2)])"
        );
        let box_alone = "domain: Box(min: (0.0, 0.0), max: (1.0, \"H\"))";
        check(box_alone, &apart, "the parts of the domain are too far apart", "0.05");
    }
}

#[test]
fn spacing_that_is_too_coarse_is_a_fault() {
    let text = SOUND
        .replace("spacing: 0.05", "spacing: 5.0")
        .replace("depth: 0.25, ", "")
        .replace("depth: 0.4, ", "");
    let faults = faults_of(&text);
    assert!(faults.faults()[0].title.contains("too coarse"), "{faults:?}");
}

#[test]
fn arrangements_that_exclude_each_other_are_faults() {
    let walls = "walls: (slip: NoSlip)";
    let periodic = "periodic: []";
    let turned = "periodic: [], fill: Lattice(axis: (0.0, 0.0, 1.0))";
    check(periodic, turned, "the lattice has an axis but no angle", "(0.0, 0.0, 1.0)");
    let turned = "periodic: [], fill: Lattice(angle: 30.0, axis: (0.0, 0.0, 1.0))";
    check(periodic, turned, "`axis` has no meaning in 2D", "(0.0, 0.0, 1.0)");
    let box_of = SOUND.replace(
        "inlets: [(at: (0.0, 0.2), towards: (1.0, 0.0), depth: 0.25, velocity: Normal(\"v0 * y\"))],",
        "",
    );
    let box_of = box_of.replace(
        "outlets: [(at: (1.0, 0.2), towards: (1.0, 0.0), depth: 0.4, condition: WaveEquation())],",
        "",
    );
    let faults = faults_of(&box_of.replace(periodic, "periodic: [\"x\"], fill: Lattice(angle: 30.0)"));
    assert_eq!(faults.faults()[0].title, "the lattice is turned away from the periodic axis x");
    check(
        walls,
        "walls: (fill: Concentric(center: (0.5, 0.2), radius: 0.1))",
        "`Concentric` of all walls",
        "Concentric",
    );
    let dummies = "walls: (model: Dummy, one_sided: true)";
    check(walls, dummies, "`one_sided` walls need images", "true");
    check(
        walls,
        "fill: WallFitted(lower: 0.0, upper: \"H\"), walls: (fill: Layers)",
        "walls cannot have a `fill` beside `WallFitted`",
        "Layers",
    );
}
