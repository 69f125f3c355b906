//! Meshes as shapes: the same particles as primitive shapes, openings on groups, faults.

use crate::meshes::MeshFile;
use crate::{Scene, SceneErrors, seeds};

/// Facets of a solid of a text STL file.
fn solid(name: &str, facets: &[[[f64; 3]; 3]]) -> String {
    let vertex = |[x, y, z]: [f64; 3]| format!("vertex {x} {y} {z}\n");
    let facet = |facet: &[[f64; 3]; 3]| {
        let vertices = facet.map(vertex).concat();
        format!("facet normal 0 0 0\nouter loop\n{vertices}endloop\nendfacet\n")
    };
    format!("solid {name}\n{}endsolid {name}\n", facets.iter().map(facet).collect::<String>())
}

/// Faces of a box in mm: two triangles each, in the order −x, x, −y, y, −z, z.
fn faces([x, y, z]: [f64; 3]) -> Vec<[[[f64; 3]; 3]; 2]> {
    let corner =
        |bits: usize| [0, 1, 2].map(|axis| if bits >> axis & 1 == 1 { [x, y, z][axis] } else { 0.0 });
    [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]]
        .map(|face| face.map(corner))
        .map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
        .to_vec()
}

/// A duct of 1 m by 0.4 m by 0.4 m with the solids `in`, `out` and `wall`.
fn duct() -> MeshFile {
    let faces = faces([1000.0, 400.0, 400.0]);
    let text = solid("in", &faces[0]) + &solid("out", &faces[1]) + &solid("wall", &faces[2..].concat());
    MeshFile { path: "duct.stl".to_owned(), bytes: text.into_bytes().into() }
}

fn scene(domain: &str, openings: &str) -> Result<Scene, SceneErrors> {
    scene_of(duct(), domain, openings)
}

fn scene_of(mesh: MeshFile, domain: &str, openings: &str) -> Result<Scene, SceneErrors> {
    let text = format!(
        r#"Scene(
    title: "Duct", dimensions: 3, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: {domain}, {openings}
    reference: (velocity: 1.0, length: 0.4), time: (end: 1.0), output: (every: 0.5),
)"#
    );
    Scene::from_text("duct", text).meshes([mesh]).load()
}

const MESH: &str = "Mesh(file: \"duct.stl\", unit: Millimetre)";

const ON: &str = "inlets: [(on: \"in\", velocity: Normal(1.0))], outlets: [(on: \"out\")],";

fn faults(domain: &str, openings: &str) -> String {
    let errors = scene(domain, openings).err();
    let faults = errors.iter().flat_map(|errors| errors.faults());
    let texts = faults.map(|fault| format!("{} | {} | {:?}", fault.title, fault.label, fault.help));
    texts.collect::<Vec<_>>().join("\n")
}

#[test]
fn duct_from_a_mesh_has_the_particles_of_a_box() {
    let openings = "inlets: [(at: (0.0, 0.2, 0.2), towards: (1.0, 0.0, 0.0), velocity: Normal(1.0))],
        outlets: [(at: (1.0, 0.2, 0.2), towards: (1.0, 0.0, 0.0))],";
    let of_box = scene("Box(min: (0.0, 0.0, 0.0), max: (1.0, 0.4, 0.4))", openings).expect("a scene");
    let expected = seeds(&of_box);
    for openings in [openings, ON] {
        let found = seeds(&scene(MESH, openings).expect("a scene"));
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            assert_eq!((found.zone, found.patch), (expected.zone, expected.patch));
            assert!(found.position.distance(expected.position) < 1e-12, "{found:?}, must be {expected:?}");
            assert!((found.wall_distance - expected.wall_distance).abs() < 1e-9, "{found:?}, {expected:?}");
        }
    }
}

#[test]
fn groups_are_found_in_meshes_that_are_placed() {
    let turned = format!("Translated(by: (1.0, 2.0, 3.0), shape: Rotated(angle: 90.0, shape: {MESH}))");
    let scene = scene(&turned, ON).expect("a scene");
    let (inlet, outlet) = (&scene.inlets[0].patch, &scene.outlets[0].patch);
    assert!(inlet.at.distance(glam::DVec3::new(0.8, 2.0, 3.2)) < 1e-12, "{}", inlet.at);
    assert!(outlet.at.distance(glam::DVec3::new(0.8, 3.0, 3.2)) < 1e-12, "{}", outlet.at);
    assert!(
        inlet.towards.distance(glam::DVec3::Y) < 1e-12 && outlet.towards.distance(glam::DVec3::Y) < 1e-12
    );
}

#[test]
fn planes_of_openings_are_given_once_and_completely() {
    let cases = [
        ("outlets: [(on: \"outt\")],", "no mesh of the domain has a group `outt`"),
        ("outlets: [(on: \"outt\")],", "did you mean `out`"),
        ("outlets: [(on: \"wall\")],", "the group `wall` is not flat"),
        ("outlets: [(on: \"out\", towards: (1.0, 0.0, 0.0))],", "the plane of the outlet is given twice"),
        ("outlets: [(towards: (1.0, 0.0, 0.0))],", "field `at` is missing"),
        ("outlets: [(at: (1.0, 0.2, 0.2))],", "field `towards` is missing"),
        ("outlets: [()],", "field `at` is missing"),
        ("inlets: [(velocity: Normal(1.0))],", "on: \\\"in\\\""),
    ];
    for (openings, expected) in cases {
        let found = faults(MESH, openings);
        assert!(found.contains(expected), "{openings}: {found}");
    }
    let found = faults("Box(min: (0.0, 0.0, 0.0), max: (1.0, 0.4, 0.4))", ON);
    assert!(found.contains("the domain has no mesh"), "{found}");
}

#[test]
fn volume_of_overlapping_parts_is_said_to_count_them_twice() {
    let first = faces([1000.0, 400.0, 400.0]).concat();
    let shifted = |facet: &[[f64; 3]; 3]| facet.map(|[x, y, z]| [x + 500.0, y + 100.0, z + 100.0]);
    let second: Vec<_> = first.iter().map(shifted).collect();
    let text = solid("first", &first) + &solid("second", &second);
    let mesh = MeshFile { path: "duct.stl".to_owned(), bytes: text.into_bytes().into() };
    for (mesh, volume, twice) in [(duct(), "0.16 m³", false), (mesh, "0.32 m³", true)] {
        let scene = scene_of(mesh, MESH, "").expect("a scene");
        let lines = scene.mesh_reports[0].lines.join("\n");
        assert!(lines.contains(volume), "{lines}");
        assert_eq!(lines.contains("parts that overlap count twice"), twice, "{lines}");
    }
}

#[test]
fn files_and_units_of_meshes_are_checked() {
    let cases = [
        ("Mesh(file: \"duct.stl\")", "field `unit` is missing"),
        ("Mesh(unit: Metre)", "a mesh has no file"),
        ("Mesh(file: \"duct.stl\", files: [\"duct.stl\"], unit: Metre)", "given twice"),
        ("Mesh(file: \"missing.stl\", unit: Metre)", "mesh `missing.stl` cannot be read"),
        ("Mesh(file: \"duct.stl\", unit: Micrometre)", "is the `unit` right?"),
        ("Mesh(file: \"duct.stl\", unit: Furlong)", "`Furlong` is not a choice"),
    ];
    for (domain, expected) in cases {
        let found = faults(domain, "");
        assert!(found.contains(expected), "{domain}: {found}");
        assert_eq!(found.lines().count(), 1, "{domain}: {found}");
        let errors = scene(domain, "").expect_err("a fault");
        assert!(errors.faults()[0].span.is_some(), "{domain}: the fault has no place");
    }
    // A hole: the surface without its outlet.
    let faces = faces([1000.0, 400.0, 400.0]);
    let open = solid("wall", &[&faces[0][..], &faces[2..].concat()].concat());
    let mesh = MeshFile { path: "open.stl".to_owned(), bytes: open.into_bytes().into() };
    let text = r#"Scene(
        title: "Open", dimensions: 3, spacing: 0.05,
        fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
        domain: Mesh(file: "open.stl", unit: Millimetre),
        reference: (velocity: 1.0, length: 0.4), time: (end: 1.0), output: (every: 0.5),
    )"#;
    let faults = Scene::from_text("open", text).meshes([mesh]).load().expect_err("a hole");
    let fault = &faults.faults()[0];
    assert!(fault.title.contains("a mesh is not closed"), "{fault:?}");
    assert!(fault.label.contains("1.6 m") && fault.label.contains("(1"), "{fault:?}");
}

/// A group emits on the domain's surface and on a body that moves; its facets are large.
#[test]
fn groups_of_facets_emit() {
    let emitter = "emitters: [(on: \"in\", velocity: MassFlow(rate: 16.0))],";
    let of_casing = scene(MESH, &format!("{emitter} outlets: [(on: \"out\")],")).expect("a scene");
    let body = format!(
        "movers: [(name: \"body\", shape: {MESH}, motion: Rotation(about: (0.5, 0.2, 0.0), radians: \"1 + t\"))],
        outlets: [(at: (2.0, 0.0, 0.0), towards: (1.0, 0.0, 0.0))], {emitter}"
    );
    let domain = "Box(min: (-1.0, -1.0, -1.0), max: (2.0, 1.4, 1.4))";
    let of_mover = scene(domain, &body).expect("a scene");
    for (scene, sign) in [(of_casing, 1.0), (of_mover, -1.0)] {
        let emitter = &scene.emitters[0];
        assert_eq!(emitter.columns.len(), 64);
        assert!((emitter.area() / 0.16 - 1.0).abs() < 1e-9, "{} m²", emitter.area());
        assert!((emitter.volume_flow(0.0) / 0.016 - 1.0).abs() < 1e-12);
        for column in &emitter.columns {
            assert!(column.foot.x.abs() < 1e-9 && (column.normal.x - sign).abs() < 1e-9, "{column:?}");
            assert!((column.area / 0.0025 - 1.0).abs() < 0.15, "{column:?}");
        }
    }
}
