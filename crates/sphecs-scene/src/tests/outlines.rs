//! Outlines as shapes: the same particles as polygons and boxes, the files of a run, faults.

use std::fmt::Write;

use glam::DVec2;

use crate::geometry::Shape;
use crate::geometry::outline::Outline;
use crate::meshes::MeshFile;
use crate::model::Fill;
use crate::{Scene, SceneErrors, seeds};

/// Points of a NACA 0012 section of unit chord, from the blunt trailing edge over the upper side
/// and back.
fn naca0012(count: usize) -> Vec<DVec2> {
    let half = |x: f64| {
        let polynomial = x * (-0.1260 + x * (-0.3516 + x * (0.2843 - 0.1015 * x)));
        5.0 * 0.12 * (0.2969 * x.sqrt() + polynomial)
    };
    let place = |index: usize| {
        let angle = std::f64::consts::PI * index as f64 / count as f64;
        let x = 0.5 * (1.0 + angle.cos());
        DVec2::new(x, half(x))
    };
    let upper: Vec<DVec2> = (0..=count).map(place).collect();
    let lower = upper[..count].iter().rev().map(|point| DVec2::new(point.x, -point.y));
    upper.iter().copied().chain(lower).collect()
}

fn file(path: &str, text: &str) -> MeshFile {
    MeshFile { path: path.to_owned(), bytes: text.as_bytes().into() }
}

/// Lines `x, y` of points.
fn lines(points: &[DVec2]) -> String {
    points.iter().fold(String::new(), |mut text, point| {
        let _ = writeln!(text, "{:?}, {:?}", point.x, point.y);
        text
    })
}

/// Text of a scene of two or three dimensions, 0.05 m in spacing.
fn scene_text(dimensions: usize, domain: &str, fields: &str) -> String {
    format!(
        r#"Scene(
    title: "Section", dimensions: {dimensions}, spacing: 0.05,
    fluid: (density: 1000.0, viscosity: 1e-3, sound_speed: 10.0),
    domain: {domain}, {fields}
    reference: (velocity: 1.0, length: 1.0), time: (end: 1.0), output: (every: 0.5),
)"#
    )
}

fn scene(domain: &str, fields: &str, outline: &str) -> Result<Scene, SceneErrors> {
    Scene::from_text("section", scene_text(2, domain, fields)).meshes([file("o.csv", outline)]).load()
}

fn sound(scene: Result<Scene, SceneErrors>) -> Scene {
    scene.unwrap_or_else(|faults| panic!("{:?}", miette::Report::new(faults)))
}

/// Titles, labels and advice of the faults of a scene, one a line.
fn faults(scene: Result<Scene, SceneErrors>) -> String {
    let errors = scene.err();
    let faults = errors.iter().flat_map(|errors| errors.faults());
    let texts = faults.map(|fault| {
        format!("{} | {} | {}", fault.title, fault.label, fault.help.as_deref().unwrap_or_default())
    });
    texts.collect::<Vec<_>>().join("\n")
}

const OUTLINE: &str = "Outline(file: \"o.csv\", unit: Metre)";

const SQUARE: &str = "0,0\n1,0\n1,1\n0,1\n";

#[test]
fn section_from_a_file_has_the_particles_of_a_polygon() {
    let points = naca0012(60);
    let corners: Vec<String> = points.iter().map(|point| format!("({:?}, {:?})", point.x, point.y)).collect();
    let polygon = format!("Polygon(points: [{}])", corners.join(", "));
    let fields = |section: &str| {
        format!(
            "inlets: [(at: (-1.0, 0.0), towards: (1.0, 0.0), velocity: Normal(1.0))],
            outlets: [(at: (2.0, 0.0), towards: (1.0, 0.0))],
            walls: (parts: [(name: \"wing\", region: {section}, slip: FreeSlip, fill: Layers)]),"
        )
    };
    let made = |section: &str| {
        let turned = format!("Rotated(angle: -7.0, about: (0.25, 0.0), shape: {section})");
        let domain = format!("Difference([Box(min: (-1.0, -1.0), max: (2.0, 1.0)), {turned}])");
        [sound(scene(&domain, "", &lines(&points))), sound(scene(&domain, &fields(&turned), &lines(&points)))]
    };
    for (of_outline, of_polygon) in made(OUTLINE).iter().zip(&made(&polygon)) {
        let [found, expected] = [of_outline, of_polygon].map(seeds);
        assert_eq!(found, expected);
        assert!(found.len() > 2400, "{} particles", found.len());
    }
}

#[test]
fn lattice_fits_straight_walls_of_many_edges() {
    let sides = [[0.0, 0.02], [1.0, 0.02], [1.0, 0.45], [0.0, 0.45]].map(DVec2::from);
    for count in [10, 1000] {
        let side = |at: usize| {
            (0..count).map(move |index| sides[at].lerp(sides[(at + 1) % 4], index as f64 / count as f64))
        };
        let points: Vec<DVec2> = (0..4).flat_map(side).collect();
        let of_outline = sound(scene(OUTLINE, "", &lines(&points)));
        let of_box = sound(scene("Box(min: (0.0, 0.02), max: (1.0, 0.45))", "", SQUARE));
        let [found, expected] = [&of_outline, &of_box].map(|scene| match &scene.layout.fill {
            Fill::Lattice(lattice) | Fill::Packed(lattice) => lattice.fits.clone(),
            Fill::WallFitted { .. } => Vec::new(),
        });
        assert!(found.len() == 4 && expected.len() == 4, "{count} edges a side: {found:?}");
        for (found, expected) in found.iter().zip(&expected) {
            // The points are between the corners up to rounding.
            let off = (found.coordinate - expected.coordinate).abs() + (found.area - expected.area).abs();
            assert!(found.axis == expected.axis && off < 1e-12, "{found:?}, must be {expected:?}");
        }
        assert_eq!(seeds(&of_outline).len(), seeds(&of_box).len());
    }
}

#[test]
fn polylines_inside_another_are_holes_in_either_orientation() {
    let square = |low: f64, high: f64| [[low, low], [high, low], [high, high], [low, high]].map(DVec2::from);
    let (mut hole, island) = (square(1.0, 3.0).to_vec(), square(1.5, 2.5).to_vec());
    hole.reverse();
    let text = [square(0.0, 4.0).to_vec(), hole, island].map(|points| lines(&points)).join("\n");
    let made = sound(scene(OUTLINE, "", &text));
    for (x, inside) in [(-0.5, false), (0.5, true), (1.25, false), (2.0, true), (2.75, false), (3.5, true)] {
        assert_eq!(made.domain.contains(glam::DVec3::new(x, 2.0, 0.0), 0.0), inside, "{x}");
    }
    let report = &made.mesh_reports[0];
    assert_eq!(report.name, "o.csv");
    let expected = "has 12 points in 3 closed polylines; 1 polyline is inside another and taken as a hole; \
                    is 4 by 4 m, with an area of 13 m²";
    assert_eq!(report.lines.join("; "), expected);
}

#[test]
fn a_scene_keeps_the_file_and_needs_it_no_longer() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("section.ron");
    let text = format!("NACA 0012\n{}", lines(&naca0012(40)));
    std::fs::create_dir(folder.path().join("sections")).expect("a folder");
    std::fs::write(folder.path().join("sections/naca0012.csv"), &text).expect("written");
    let domain = "Scaled(factor: 2.0, shape: Outline(file: \"sections/naca0012.csv\", unit: Foot))";
    std::fs::write(&path, scene_text(2, domain, "")).expect("written");
    let first = sound(Scene::from_file(&path).load());
    assert_eq!(first.meshes, [file("sections/naca0012.csv", &text)]);
    assert!(first.mesh_reports[0].lines.contains(&"`NACA 0012` is taken as its heading".to_owned()));
    let (low, high) = first.domain.bounds();
    assert_eq!((low.x, high.x), (0.0, 0.6096));
    let second = sound(Scene::from_text("section", &first.text).meshes(first.meshes.clone()).load());
    assert_eq!(seeds(&first), seeds(&second));
}

#[test]
fn files_and_units_of_outlines_are_checked() {
    let cases = [
        ("Outline(file: \"o.csv\")", SQUARE, "field `unit` is missing"),
        ("Outline(unit: Metre)", SQUARE, "field `file` is missing"),
        ("Outline(file: \"no.csv\", unit: Metre)", SQUARE, "outline `no.csv` cannot be read"),
        ("Outline(file: \"o.csv\", unit: Millimetre)", SQUARE, "is the `unit` right?"),
        ("Scaled(factor: 1e-3, shape: Outline(file: \"o.csv\", unit: Metre))", SQUARE, "0.001 by 0.001 m"),
        (OUTLINE, "0,0\n1,0\n1,l\n0,1\n", "o.csv:3:3: is `l`, must be a finite number"),
        (OUTLINE, "0,0\n1,0,0\n0,1\n", "o.csv:2:1: has 3 columns, must have 2"),
        (OUTLINE, "0,0\n1,0\n", "has 2 points, must have at least 3"),
        (OUTLINE, "0,0\n1,0\n2,0\n", "an outline has no area"),
        (OUTLINE, "0,0\n1,1\n1,0\n0,1\n", "an outline crosses itself"),
        (OUTLINE, "0,0\n2,0\n2,1\n2,0.5\n2,2\n0,2\n", "an outline crosses itself"),
        (OUTLINE, "0,0\n2,0\n0,2\n\n1,1\n3,1\n3,3\n", "an outline crosses itself"),
    ];
    for (domain, text, expected) in cases {
        let found = faults(scene(domain, "", text));
        assert!(found.contains(expected), "{domain}, {text}: {found}");
    }
    let found = faults(scene(OUTLINE, "", "x\n0,0\n1,1\n1,0\n0,1\n"));
    assert_eq!(
        found,
        "an outline crosses itself | o.csv:2:1: the edge from (0, 0) in line 2 to (1, 1) in line 3 must not touch \
         the edge from (1, 0) in line 4 to (0, 1) in line 5: put the points of each closed polyline in order \
         around it, with a blank line between polylines | "
    );
    // One file with two faults, which is named twice.
    let part = format!("walls: (parts: [(name: \"part\", region: {OUTLINE})]),");
    let found = faults(scene(OUTLINE, &part, "0,0\n1,zero\n1,1\nnil,1\n"));
    assert_eq!(found.lines().count(), 2, "{found}");
    assert!(found.contains("o.csv:2:3") && found.contains("o.csv:4:1"), "{found}");
}

#[test]
fn binary_files_are_no_outlines() {
    let bytes = MeshFile { path: "o.csv".to_owned(), bytes: [0x89, b'H', b'D', b'F'].into() };
    let found = faults(Scene::from_text("section", scene_text(2, OUTLINE, "")).meshes([bytes]).load());
    assert!(found.contains("an outline is not a text file"), "{found}");
}

#[test]
fn outlines_are_plane_and_meshes_are_not() {
    let found = faults(Scene::from_text("section", scene_text(3, OUTLINE, "")).load());
    assert!(found.contains("`Outline` needs 2 dimensions") && found.contains("use `Mesh`"), "{found}");
    let found = faults(scene("Mesh(file: \"o.stl\", unit: Metre)", "", SQUARE));
    assert!(found.contains("`Mesh` needs 3 dimensions") && found.contains("use `Outline`"), "{found}");
}

/// A circle of 200 000 points, read and checked for crossings in steps whose number grows little
/// faster than the points.
#[test]
fn outlines_of_many_points_are_accepted() {
    let count = 200_000;
    let point = |index: usize| DVec2::from_angle(std::f64::consts::TAU * index as f64 / f64::from(count));
    let points: Vec<DVec2> = (0..count as usize).map(point).collect();
    let outline = Outline::new(vec![points.clone()]);
    assert_eq!(outline.crossings(1), []);
    assert!((outline.area() - std::f64::consts::PI).abs() < 1e-8, "{}", outline.area());
    assert_eq!(outline.straight().len(), 0);
    let polygon = Shape::Prism { points, from: f64::NEG_INFINITY, to: f64::INFINITY };
    for place in [[0.3, 0.4], [1.0, 1e-7], [-0.9999, 0.1]].map(DVec2::from) {
        let expected = polygon.signed_distance(place.extend(0.0));
        assert_eq!(outline.signed_distance(place).to_bits(), expected.to_bits(), "{place}");
    }
}
