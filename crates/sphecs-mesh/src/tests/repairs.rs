//! Faults of surfaces that are repaired, counted or refused.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::shapes::{Random, Shape, bar, cube, gear, sphere};
use crate::{Facets, Part, Report, Surface};

/// Asserts that the lines of a report say something.
fn says(report: &Report, wanted: &str) {
    let lines = report.lines();
    assert!(lines.iter().any(|line| line.contains(wanted)), "{lines:#?}\nmust say `{wanted}`");
}

#[test]
fn clean_surfaces_stay_as_they_are() {
    for shape in [cube(), gear(9), sphere(30), bar(DVec3::new(10.0, 0.1, 0.3))] {
        let (surface, report) = shape.repaired();
        assert_eq!(surface.triangles(), shape.triangles);
        let expected = Report {
            facets: shape.triangles.len(),
            triangles: shape.triangles.len(),
            vertices: shape.vertices.len(),
            components: 1,
            ..Report::default()
        };
        assert_eq!(report, expected);
        assert_eq!(report.lines(), [format!("has {} triangles in 1 connected part", shape.triangles.len())]);
    }
}

#[test]
fn near_vertices_are_welded() {
    let mut soup = Shape { vertices: Vec::new(), triangles: Vec::new() };
    let mut random = Random(7);
    let shape = gear(9);
    for triangle in 0..shape.triangles.len() {
        let first = soup.vertices.len() as u32;
        // Within 1e-6 of the diagonal of 2.8.
        soup.vertices.extend(shape.corners(triangle).map(|corner| corner + 5e-7 * random.vector()));
        soup.triangles.push([first, first + 1, first + 2]);
    }
    soup.vertices.push(DVec3::splat(1e9));
    let (surface, report) = soup.repaired();
    assert_eq!(surface.vertices().len(), shape.vertices.len());
    assert_eq!(report.welded, 3 * shape.triangles.len() - shape.vertices.len());
    assert!(report.is_closed());
    says(&report, "vertices were merged with another within 1e-6");
    assert!(surface.bounds().1.max_element() < 1.1, "a vertex without a triangle does not count");
    // Farther than the tolerance, they stay.
    let apart = cube().with(&cube().moved(DVec3::X * (1.0 + 1e-4)));
    assert_eq!(apart.repaired().0.vertices().len(), 16);
}

#[test]
fn facets_without_extent_and_duplicates_are_dropped() {
    let mut shape = cube();
    shape.triangles.extend([[0, 0, 1], [3, 5, 3], [2, 2, 2]]);
    shape.triangles.extend([shape.triangles[4], shape.triangles[4], shape.triangles[7]]);
    let (surface, report) = shape.repaired();
    assert_eq!((report.degenerate, report.duplicates, report.opposite), (3, 3, 0));
    assert_eq!((surface.triangles().len(), report.facets), (12, 18));
    assert_eq!(surface.volume(), 1.0);
    says(&report, "3 facets without extent were dropped");
    says(&report, "3 facets were in the files once more");
}

#[test]
fn wall_between_touching_parts_cancels() {
    // The common face is divided along the same diagonal in both.
    let mut right = cube().moved(DVec3::X);
    right.triangles[8..10].copy_from_slice(&[[0, 4, 2], [4, 6, 2]]);
    let mut left = cube();
    left.triangles[10..12].copy_from_slice(&[[1, 3, 5], [3, 7, 5]]);
    let (surface, report) = left.with(&right).repaired();
    assert_eq!((report.opposite, report.duplicates, report.components), (4, 0, 1));
    assert!(report.is_closed() && (surface.volume() - 2.0).abs() < 1e-15, "{:?}", report.lines());
    assert!((surface.winding(DVec3::new(1.0, 0.4, 0.5)) - 1.0).abs() < 0.1);
    // A facet of the border that is there with both orientations is needed once.
    let mut shape = cube();
    let [a, b, c] = shape.triangles[5];
    shape.triangles.push([a, c, b]);
    let (surface, report) = shape.repaired();
    assert_eq!((report.opposite, report.duplicates, surface.volume()), (0, 1, 1.0));
    assert!(report.is_closed());
}

#[test]
fn orientation_is_made_the_same_and_outward() {
    let shape = sphere(24);
    let exact = shape.surface().volume();
    let (turned, report) = shape.clone().turned().repaired();
    assert_eq!((report.turned_components, report.flipped), (1, 0));
    says(&report, "1 connected part was turned");
    assert!((turned.volume() - exact).abs() < 1e-12);
    let mut partly = shape.clone();
    partly.triangles[3..40].iter_mut().for_each(|triangle| triangle.swap(0, 2));
    let (surface, report) = partly.repaired();
    assert_eq!((report.turned_components, report.flipped), (0, 37));
    assert!((surface.volume() - exact).abs() < 1e-12);
    // Two parts beside each other, of which one is inside out.
    let both = cube().moved(DVec3::X * 3.0).turned().with(&shape);
    let (surface, report) = both.repaired();
    assert_eq!((report.components, report.turned_components, report.cavities), (2, 1, 0));
    assert!((surface.volume() - exact - 1.0).abs() < 1e-12);
}

#[test]
fn closed_parts_inside_others_are_cavities() {
    let inner = sphere(20).scaled(DVec3::splat(0.5));
    let core = sphere(20).scaled(DVec3::splat(0.2));
    let volume = |shape: &Shape| shape.surface().volume();
    let outer = sphere(20);
    let exact = volume(&outer) - volume(&inner) + volume(&core);
    for (inner, turned) in [(inner.clone().turned(), 0), (inner.clone(), 1)] {
        let (surface, report) = core.clone().with(&inner).with(&outer).repaired();
        assert_eq!((report.cavities, report.turned_components), (1, turned));
        assert!((surface.volume() - exact).abs() < 1e-12);
        let inside = |x: f64| surface.is_inside(DVec3::new(x, 0.01, 0.02));
        assert_eq!([0.1, 0.3, 0.8, 1.1].map(inside), [true, false, true, false]);
        says(&report, "1 closed part is inside another and taken as a cavity");
    }
    // Half outside: a union.
    let (_, report) = outer.with(&inner.moved(DVec3::X)).repaired();
    assert_eq!((report.cavities, report.turned_components), (0, 0));
}

#[test]
fn opening_of_a_lid_is_measured() {
    let mut shape = bar(DVec3::new(2.0, 3.0, 1.0));
    shape.triangles.drain(2..4);
    let report = shape.repaired().1;
    let [lid] = report.open_loops[..] else { panic!("{report:?}") };
    assert_eq!((lid.length, lid.area, lid.edges), (10.0, 6.0, 4));
    assert!(!lid.is_seam() && lid.width() == 1.2);
    assert!(lid.centre.distance(DVec3::new(1.0, 1.5, 1.0)) < 1e-15);
    says(&report, "is open along 1.00e1 m near (1.000e0, 1.500e0, 1.000e0) m: 4 edges have one facet");
}

#[test]
fn seam_between_edges_divided_in_different_ways_encloses_no_area() {
    let mut shape = cube();
    // The lid alone has the middle of one of its edges.
    let [a, b, c] = shape.triangles[2];
    let middle = 0.5 * (shape.vertices[a as usize] + shape.vertices[b as usize]);
    shape.vertices.push(middle);
    shape.triangles[2] = [a, 8, c];
    shape.triangles.push([8, b, c]);
    let (surface, report) = shape.repaired();
    let [seam] = report.open_loops[..] else { panic!("{report:?}") };
    assert!((seam.length - 2.0).abs() < 1e-15 && seam.area < 1e-15 && seam.edges == 3, "{seam:?}");
    assert!(seam.is_seam());
    says(&report, "has a seam without a gap along 2.00e0 m");
    assert!((surface.winding(middle.lerp(DVec3::splat(0.5), 0.05)) - 1.0).abs() < 0.1);
}

#[test]
fn parts_that_touch_at_an_edge_are_counted() {
    let (surface, report) = cube().with(&cube().moved(DVec3::new(1.0, 1.0, 0.0))).repaired();
    assert_eq!((report.non_manifold_edges, report.components), (1, 2));
    assert!(report.is_closed());
    assert_eq!(surface.volume(), 2.0);
    says(&report, "1 edge has more than two facets");
}

#[test]
fn one_sided_surface_is_counted() {
    let mut strip = Shape { vertices: Vec::new(), triangles: Vec::new() };
    let count = 16_u32;
    for at in 0..count {
        let phi = TAU * f64::from(at) / f64::from(count);
        for half in [-0.2, 0.2] {
            let radius = 1.0 + half * (0.5 * phi).cos();
            strip.vertices.push(DVec3::new(radius * phi.cos(), radius * phi.sin(), half * (0.5 * phi).sin()));
        }
    }
    for at in 0..count {
        let (a, b) = (2 * at, 2 * at + 1);
        let (c, d) = if at + 1 == count { (1, 0) } else { (2 * at + 2, 2 * at + 3) };
        strip.triangles.extend([[a, b, c], [b, d, c]]);
    }
    let report = strip.repaired().1;
    assert_eq!((report.one_sided_edges, report.components), (1, 1));
    says(&report, "1 edge has facets that cannot agree");
}

#[test]
fn many_parts_do_not_take_long() {
    let mut bubbles = bar(DVec3::splat(100.0));
    let bubble = sphere(4).scaled(DVec3::splat(0.3));
    for at in 0..5000_u32 {
        let place = DVec3::new(f64::from(at % 30), f64::from(at / 30 % 30), f64::from(at / 900));
        bubbles = append(bubbles, &bubble, place * 3.0 + 1.0);
    }
    let (surface, report) = bubbles.repaired();
    assert_eq!((report.components, report.cavities, report.turned_components), (5001, 5000, 5000));
    assert!((surface.volume() - 1e6 + 5000.0 * bubble.surface().volume()).abs() < 1e-6);
}

fn append(mut shape: Shape, other: &Shape, by: DVec3) -> Shape {
    let first = shape.vertices.len() as u32;
    shape.vertices.extend(other.vertices.iter().map(|vertex| *vertex + by));
    shape.triangles.extend(other.triangles.iter().map(|triangle| triangle.map(|v| v + first)));
    shape
}

#[test]
fn surfaces_that_cannot_be_made_are_refused() {
    let refuse = |facets: Facets, scale: f64, wanted: &str| {
        let part = Part { name: "part".to_owned(), facets };
        let message = Surface::new(vec![part], scale).map(|(_, report)| report).unwrap_err().to_string();
        assert!(message.starts_with("part: ") && message.contains(wanted), "{message}\nmust say `{wanted}`");
    };
    let with = |change: fn(&mut Facets)| {
        let mut facets = cube().facets();
        change(&mut facets);
        facets
    };
    for scale in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        refuse(cube().facets(), scale, "must be above 0");
    }
    refuse(cube().facets(), 1e31, "is the unit right?");
    refuse(cube().facets(), 1e-31, "is the unit right?");
    refuse(Facets::default(), 1.0, "has no triangles");
    refuse(with(|facets| facets.triangles[3] = [0, 1, 8]), 1.0, "vertex 8, must be below 8");
    refuse(with(|facets| facets.groups[3] = 1), 1.0, "group 1, must be below 1");
    refuse(with(|facets| facets.groups.truncate(3)), 1.0, "3 groups for 12 triangles");
    refuse(with(|facets| facets.vertices[3].x = f64::NAN), 1.0, "not a number");
    refuse(with(|facets| facets.vertices.iter_mut().for_each(|v| v.x = v.y)), 1.0, "none with an area");
    refuse(with(|facets| facets.vertices.fill(DVec3::ONE)), 1.0, "0.00e0 m large");
    refuse(with(|facets| facets.group_names = vec![String::new(); 65_537]), 1.0, "65 536");
    assert!(Surface::new(Vec::new(), 1.0).is_err());
    assert!(Surface::from_triangles(vec![DVec3::NAN; 3], vec![[0, 1, 2]]).is_err());
}

#[test]
fn volume_and_place_do_not_lose_digits_far_from_the_origin() {
    let far = DVec3::new(1e6, -2e6, 3e6);
    let surface = sphere(40).moved(far).surface();
    // Coordinates of 1e6 have ten digits of the unit.
    assert!((surface.volume() - sphere(40).surface().volume()).abs() < 1e-8);
    assert!((surface.volume() - 4.0 * PI / 3.0).abs() < 2e-2);
    assert!(surface.is_inside(far) && !surface.is_inside(far + 1.1));
}
