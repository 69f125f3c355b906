//! Properties of the signed distances of all shapes.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use proptest::prelude::{ProptestConfig, Strategy, proptest};

use crate::geometry::Shape;
use crate::geometry::bend::{Bend, BendSection};
use crate::geometry::outline::Outline;

fn cuboid(min: [f64; 3], max: [f64; 3]) -> Shape {
    Shape::Box { min: DVec3::from(min), max: DVec3::from(max) }
}

fn elbow(section: BendSection, angle: f64) -> Shape {
    Shape::Bend(Bend {
        center: DVec3::new(0.1, -0.2, 0.0),
        outwards: DVec3::X,
        direction: DVec3::Y,
        radius: 0.8,
        angle,
        section,
    })
}

/// Returns the shapes whose distance is exact on both sides.
fn exact() -> Vec<(&'static str, Shape)> {
    let dart = [[0.0, 0.0], [1.0, -0.5], [0.4, 0.1], [0.9, 0.9]].map(DVec2::from);
    let hole = [[0.3, -0.05], [0.5, -0.15], [0.4, 0.0]].map(DVec2::from);
    vec![
        ("box", cuboid([-0.5, -0.3, -0.2], [0.6, 0.2, 0.9])),
        ("ball", Shape::Ball { center: DVec3::new(0.1, 0.2, -0.1), radius: 0.7 }),
        (
            "cylinder",
            Shape::Cylinder { from: DVec3::new(-0.5, -0.4, 0.0), to: DVec3::new(0.4, 0.6, 0.5), radius: 0.3 },
        ),
        ("outline", Shape::Outline(Arc::new(Outline::new(vec![dart.to_vec(), hole.to_vec()])))),
        ("prism", Shape::Prism { points: dart.to_vec(), from: -0.4, to: 0.3 }),
        (
            "placed",
            Shape::Placed {
                shape: Box::new(cuboid([-0.3, -0.2, -0.1], [0.4, 0.5, 0.2])),
                rotation: DMat3::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7),
                scale: 1.3,
                origin: DVec3::new(0.1, 0.2, 0.0),
            },
        ),
    ]
}

/// Returns the shapes whose distance is exact outside and a lower bound inside.
fn bounded() -> Vec<(&'static str, Shape)> {
    vec![
        (
            "union",
            Shape::Union(vec![
                cuboid([-1.0, -0.5, -0.5], [0.0, 0.5, 0.5]),
                cuboid([0.0, -0.2, -0.2], [0.8, 0.2, 0.2]),
            ]),
        ),
        ("round bend", elbow(BendSection::Circular(0.25), 1.2)),
        ("square bend", elbow(BendSection::Rectangular(0.25, 0.2), 1.9)),
        ("half turn", elbow(BendSection::Rectangular(0.25, 0.2), std::f64::consts::PI)),
    ]
}

/// Returns the shapes whose distance is a lower bound on both sides.
fn signed_only() -> Vec<(&'static str, Shape)> {
    let block = cuboid([-0.9, -0.6, -0.5], [0.9, 0.6, 0.5]);
    let ball = Shape::Ball { center: DVec3::new(0.2, 0.3, 0.1), radius: 0.5 };
    vec![
        ("difference", Shape::Difference(Box::new(block.clone()), Box::new(ball.clone()))),
        ("intersection", Shape::Intersection(vec![block, ball])),
    ]
}

fn all() -> Vec<(&'static str, Shape)> {
    [exact(), bounded(), signed_only()].concat()
}

fn anywhere() -> impl Strategy<Value = DVec3> {
    [-1.5..1.5_f64, -1.5..1.5_f64, -1.5..1.5_f64].prop_map(DVec3::from)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2000, failure_persistence: None, ..ProptestConfig::default() })]

    // The distance of a union may jump at a seam by the offset of its probes, 1e-9.
    #[test]
    fn signed_distance_is_lipschitz_continuous(a in anywhere(), b in anywhere()) {
        for (name, shape) in all() {
            let change = (shape.signed_distance(a) - shape.signed_distance(b)).abs();
            assert!(change <= a.distance(b) * (1.0 + 1e-9) + 1e-8, "{name}: {change} from {a} to {b}");
        }
    }

    #[test]
    fn nearest_surface_point_lies_on_the_surface(start in anywhere()) {
        let outside = |shape: &Shape| shape.signed_distance(start) > 1e-3;
        for (name, shape) in [exact(), bounded()].concat().into_iter().filter(|(_, s)| outside(s)) {
            let distance = shape.signed_distance(start);
            let surface = shape.nearest_surface(start, 1e-6, 3);
            let off = shape.signed_distance(surface).abs();
            // Between two equally near surface points the gradient points to neither, so the path
            // may be longer.
            let walked = start.distance(surface);
            assert!(off < 1e-6, "{name}: ends {off} off the surface from {start}");
            assert!(walked > distance - 1e-6, "{name}: {walked} is nearer than {distance}");
        }
    }
}

/// Returns the distance to the nearest change of sign along many rays, m; it is never less than the
/// true distance.
fn brute_force(shape: &Shape, point: DVec3) -> f64 {
    let inside = shape.contains(point, 0.0);
    let mut nearest = f64::INFINITY;
    let count = 4000;
    for index in 0..count {
        // Spherical Fibonacci directions.
        let z = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(count);
        let turn = f64::from(index) * 2.399_963_229_728_653;
        let ring = (1.0 - z * z).sqrt();
        let direction = DVec3::new(ring * turn.cos(), ring * turn.sin(), z);
        let mut distance = 0.0;
        while distance < nearest.min(3.0) {
            distance += 2e-3;
            if shape.contains(point + distance * direction, 0.0) != inside {
                nearest = nearest.min(distance);
            }
        }
    }
    nearest
}

#[test]
fn exact_distances_agree_with_brute_force() {
    let points = [[0.9, 0.8, 0.1], [0.0, 0.1, 0.05], [-0.7, 0.3, -0.9], [0.5, 0.1, 0.1]].map(DVec3::from);
    for (name, shape) in [exact(), bounded()].concat() {
        let one_sided = bounded().iter().any(|(other, _)| *other == name);
        for point in points {
            let distance = shape.signed_distance(point);
            if one_sided && distance < 0.0 {
                continue;
            }
            let found = brute_force(&shape, point);
            // Steps of 2e-3 in 4000 directions overestimate the distance by a few per cent at most.
            assert!(
                found >= distance.abs() - 1e-9 && found <= distance.abs() * 1.03 + 6e-3,
                "{name} at {point}: {distance}, by rays {found}"
            );
        }
    }
}

#[test]
fn seam_of_touching_boxes_is_inside() {
    let tenth = 0.1 + 0.2;
    let union = Shape::Union(vec![
        cuboid([-0.2, -0.05, f64::NEG_INFINITY], [tenth, 0.05, f64::INFINITY]),
        cuboid([0.3, -0.01, f64::NEG_INFINITY], [0.6, 0.01, f64::INFINITY]),
    ]);
    for y in [0.0, 0.004, -0.009] {
        assert!(union.signed_distance(DVec3::new(0.3, y, 0.0)) < 0.0, "y = {y}");
        assert!(union.signed_distance(DVec3::new(tenth, y, 0.0)) < 0.0, "y = {y}");
    }
    for y in [0.02, -0.03] {
        assert!(union.signed_distance(DVec3::new(0.3, y, 0.0)).abs() < 1e-15);
        assert!(union.signed_distance(DVec3::new(0.3 + 1e-9, y, 0.0)) > 0.0);
    }
}

#[test]
fn bounds_contain_the_shape() {
    for (name, shape) in all() {
        let (low, high) = shape.bounds();
        for index in 0..20_000 {
            let unit = |place: i32| f64::from(index * place % 9973) / 9973.0 * 3.0 - 1.5;
            let point = DVec3::new(unit(7919), unit(104_729 % 9973), unit(15_485));
            if shape.signed_distance(point) < 0.0 {
                let held = point.cmpge(low - 1e-12).all() && point.cmple(high + 1e-12).all();
                assert!(held, "{name}: {point} is not in {low} … {high}");
            }
        }
    }
}
