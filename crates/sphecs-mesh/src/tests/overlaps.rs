//! Surfaces that cross themselves.

use glam::DVec3;

use super::shapes::{Random, Shape, bar, cube, gear, sphere};
use crate::surface::crossing::cross;
use crate::{Intersections, Surface};

/// Returns true if an edge of one of two triangles goes through the other, in floating point.
fn pierces(p: [DVec3; 3], q: [DVec3; 3]) -> bool {
    let volume = |a: DVec3, b: DVec3, c: DVec3, d: DVec3| (b - a).cross(c - a).dot(d - a);
    let through = |[a, b, c]: [DVec3; 3], from: DVec3, to: DVec3| {
        let sides = [volume(from, to, a, b), volume(from, to, b, c), volume(from, to, c, a)];
        volume(a, b, c, from) * volume(a, b, c, to) < 0.0
            && (sides.iter().all(|side| *side > 0.0) || sides.iter().all(|side| *side < 0.0))
    };
    (0..3).any(|k| through(p, q[k], q[(k + 1) % 3]) || through(q, p[k], p[(k + 1) % 3]))
}

#[test]
fn triangles_cross_where_an_edge_goes_through_the_other() {
    let mut random = Random(99);
    let mut crossing = 0;
    for _ in 0..100_000 {
        let mut triangle = || [random.vector(), random.vector(), random.vector()];
        let (p, q) = (triangle(), triangle());
        let number = |first: u32, t: [DVec3; 3]| [0, 1, 2].map(|k| (first + k as u32, t[k]));
        let expected = pierces(p, q);
        crossing += usize::from(expected);
        for (a, b) in [(p, q), (q, p), ([p[1], p[0], p[2]], q), (p, [q[2], q[1], q[0]])] {
            assert_eq!(cross(number(0, a), number(3, b)), expected, "{p:?} {q:?}");
        }
    }
    assert!(crossing > 10_000, "{crossing}");
}

fn found(shape: &Shape) -> Intersections {
    shape.repaired().0.intersections()
}

#[test]
fn clean_and_touching_surfaces_do_not_cross() {
    let boss = cube().scaled(DVec3::splat(0.5)).moved(DVec3::new(0.25, 0.25, 1.0));
    let shapes = [
        cube(),
        gear(24),
        sphere(60),
        bar(DVec3::new(10.0, 0.1, 0.3)),
        cube().with(&boss),
        cube().with(&cube().moved(DVec3::new(1.0, 0.3, 0.0))),
        cube().with(&cube().moved(DVec3::ONE)),
        cube().with(&sphere(9).scaled(DVec3::splat(0.1)).moved(DVec3::splat(0.5))),
    ];
    for shape in shapes {
        let found = found(&shape);
        assert_eq!((found.clone(), found.line()), (Intersections::default(), None));
    }
}

#[test]
fn overlapping_parts_are_a_union() {
    // Symmetric: edges cross edges, and two walls are in one plane.
    let shape = cube().with(&cube().moved(DVec3::new(0.5, 0.5, 0.0)));
    let (surface, report) = shape.repaired();
    let found = surface.intersections();
    assert_eq!((found.parts, found.within_parts, report.components), (1, 0, 2));
    assert!(found.pairs >= 2);
    assert!(found.line().is_some_and(|line| line.contains("1 pair of parts that overlap")));
    let inside = |x: f64, y: f64| surface.is_inside(DVec3::new(x, y, 0.5));
    assert!(inside(0.2, 0.3) && inside(0.8, 0.7) && inside(1.2, 1.3) && !inside(1.2, 0.2));
    let three = shape.with(&sphere(9).moved(DVec3::new(1.1, 1.2, 0.4)));
    assert_eq!(found_parts(&three.surface()), 3);
}

fn found_parts(surface: &Surface) -> usize {
    surface.intersections().parts
}

#[test]
fn surface_that_crosses_itself_is_reported_with_its_place() {
    let mut shape = sphere(20);
    // A vertex of the upper half is drawn through the lower half.
    let vertex = shape.vertices.iter().position(|vertex| vertex.z > 0.9 && vertex.z < 1.0).unwrap();
    shape.vertices[vertex] = DVec3::new(0.3, 0.2, -1.5);
    let found = found(&shape);
    assert!(found.pairs > 0 && found.within_parts == found.pairs && found.parts == 0, "{found:?}");
    assert!(found.place.unwrap().distance(DVec3::new(0.3, 0.2, -0.9)) < 0.3, "{found:?}");
    assert!(found.line().unwrap().contains("crosses itself"));
}
