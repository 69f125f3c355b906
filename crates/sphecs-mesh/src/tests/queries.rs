//! Queries against sums and minima over all triangles.

use std::f64::consts::PI;

use glam::{DQuat, DVec3, EulerRot};

use super::shapes::{Random, Shape, bar, cube, gear, sphere};
use crate::Surface;

/// Returns the distance of a point from a triangle by another way than the search: the foot of the
/// perpendicular if it is inside all edges, and the nearest points of the edges.
fn distance([a, b, c]: [DVec3; 3], query: DVec3) -> f64 {
    let normal = (b - a).cross(c - a).normalize();
    let height = (query - a).dot(normal);
    let foot = query - height * normal;
    let is_left = |from: DVec3, to: DVec3| (to - from).cross(foot - from).dot(normal) >= 0.0;
    if is_left(a, b) && is_left(b, c) && is_left(c, a) {
        return height.abs();
    }
    let to_edge = |from: DVec3, to: DVec3| {
        let share = (query - from).dot(to - from) / (to - from).length_squared();
        query.distance(from + share.clamp(0.0, 1.0) * (to - from))
    };
    to_edge(a, b).min(to_edge(b, c)).min(to_edge(c, a))
}

/// Returns the solid angle of a triangle in sr by l'Huilier's theorem, without its sign.
fn solid_angle(corners: [DVec3; 3], query: DVec3) -> f64 {
    let [a, b, c] = corners.map(|corner| (corner - query).normalize());
    let side = |u: DVec3, v: DVec3| 2.0 * (0.5 * u.distance(v)).min(1.0).asin();
    let (x, y, z) = (side(b, c), side(c, a), side(a, b));
    let s = 0.5 * (x + y + z);
    let product = (0.5 * s).tan() * (0.5 * (s - x)).tan() * (0.5 * (s - y)).tan() * (0.5 * (s - z)).tan();
    4.0 * product.max(0.0).sqrt().atan()
}

fn winding(surface: &Surface, query: DVec3) -> f64 {
    let signed = |triangle: &[u32; 3]| {
        let corners = triangle.map(|vertex| surface.vertices()[vertex as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        solid_angle(corners, query) * (corners[0] - query).dot(normal).signum()
    };
    surface.triangles().iter().map(signed).sum::<f64>() / (4.0 * PI)
}

/// Points around the box of a surface, and near the surface.
fn points(surface: &Surface, count: usize) -> Vec<DVec3> {
    let (low, high) = surface.bounds();
    let mut random = Random(88_172_645_463_325_252);
    let mut points: Vec<DVec3> =
        (0..count).map(|_| low + (high - low) * (1.4 * random.vector() - 0.2)).collect();
    for index in 0..count {
        let triangle = surface.triangles()[index * 7919 % surface.triangles().len()];
        let [a, b, c] = triangle.map(|vertex| surface.vertices()[vertex as usize]);
        let (u, v) = (random.unit(), random.unit());
        let place = a + 0.5 * u * (b - a) + 0.5 * v * (c - a);
        points.push(place + (random.vector() - 0.5) * 0.02 * low.distance(high));
    }
    points
}

fn compare_with_all_triangles(name: &str, surface: &Surface, count: usize) {
    let (low, high) = surface.bounds();
    for query in points(surface, count) {
        let corners = surface.triangles().iter().map(|t| t.map(|vertex| surface.vertices()[vertex as usize]));
        let least = corners.map(|corners| distance(corners, query)).fold(f64::INFINITY, f64::min);
        let found = surface.nearest(query);
        // Rounding of coordinates of the size of the diagonal.
        let tolerance = 1e-12 * low.distance(high);
        assert!((found.distance - least).abs() <= tolerance, "{name} {query}: {found:?}, must be {least}");
        assert!((found.point.distance(query) - least).abs() <= tolerance, "{name} {query}: {found:?}");
        let bounded = surface.nearest_within(query, found.distance);
        assert_eq!(bounded.map(|near| near.triangle), Some(found.triangle), "{name} {query}");
        assert_eq!(surface.nearest_within(query, 0.999 * found.distance), None, "{name} {query}");
        let clear = surface.clearance(query);
        let allowed = 0.8 * least - tolerance..=least + tolerance;
        assert!(allowed.contains(&clear), "{name} {query}: clear by {clear}, nearest is {least}");
        let exact = winding(surface, query);
        assert_eq!(surface.is_inside(query), exact > 0.5, "{name} {query}: {exact}");
        assert_eq!(surface.signed_distance(query) < 0.0, exact > 0.5, "{name} {query}");
    }
}

fn two_cubes() -> Shape {
    cube().with(&cube().scaled(DVec3::splat(0.5)).moved(DVec3::new(2.0, 0.2, 0.1)))
}

fn holed() -> Shape {
    let mut shape = sphere(20);
    shape.triangles.drain(100..104);
    shape
}

fn partly_flipped() -> Shape {
    let mut shape = gear(9);
    shape.triangles.iter_mut().step_by(3).for_each(|triangle| triangle.swap(0, 1));
    shape
}

fn duplicated() -> Shape {
    let mut shape = cube();
    shape.triangles.push(shape.triangles[3]);
    shape
}

#[test]
fn nearest_and_sign_equal_those_of_all_triangles() {
    let shapes = [
        ("cube", cube()),
        ("bar", bar(DVec3::new(10.0, 0.1, 0.3)).moved(DVec3::new(-4.0, 7.0, 0.5))),
        ("gear", gear(24)),
        ("sphere", sphere(40)),
        ("two solids", two_cubes()),
        ("holed", holed()),
        ("flipped", partly_flipped()),
        ("inside out", gear(5).turned()),
        ("duplicated", duplicated()),
        ("overlapping", cube().with(&cube().moved(DVec3::splat(0.5)))),
        ("small", gear(12).scaled(DVec3::splat(1e-6))),
        ("large", gear(12).scaled(DVec3::splat(1e6))),
    ];
    for (name, shape) in shapes {
        let (surface, report) = shape.repaired();
        compare_with_all_triangles(name, &surface, 400);
        assert_eq!(report.is_closed(), name != "holed", "{name}: {:?}", report.lines());
    }
}

#[test]
fn expansion_is_near_the_exact_sum() {
    for shape in [gear(24), sphere(60), bar(DVec3::new(10.0, 0.1, 0.3)), holed()] {
        let surface = shape.repaired().0;
        for query in points(&surface, 300) {
            let expanded = crate::surface::winding::expanded(&surface.bvh, &surface.mesh, query);
            let exact = winding(&surface, query);
            assert!((expanded - exact).abs() < 0.08, "{query}: {expanded}, exactly {exact}");
        }
    }
}

#[test]
fn winding_near_an_opening_is_exact() {
    let mut shape = sphere(20);
    shape.triangles.retain(|triangle| triangle.iter().any(|vertex| shape.vertices[*vertex as usize].x < 0.5));
    let surface = shape.repaired().0;
    let doubtful: Vec<DVec3> = points(&surface, 2000)
        .into_iter()
        .filter(|query| (surface.winding(*query) - surface.winding(*query).round()).abs() > 0.21)
        .collect();
    assert!(doubtful.len() > 100, "{} points", doubtful.len());
    for query in doubtful {
        assert!((surface.winding(query) - winding(&surface, query)).abs() < 1e-9, "{query}");
    }
}

#[test]
fn volume_of_a_sphere_converges() {
    // 4π/3 less the chords: exact volumes of the polyhedra to five digits.
    for (n, triangles, volume) in [(100, 39_600, 4.1871), (224, 199_808, 4.1884), (708, 2_002_224, 4.1888)] {
        let surface = sphere(n).surface();
        assert_eq!(surface.triangles().len(), triangles);
        assert!((surface.volume() - volume).abs() < 5e-5, "{triangles}: {}", surface.volume());
        assert!((surface.area() - 4.0 * PI).abs() < 1e-2, "{triangles}: {}", surface.area());
        assert!((surface.signed_distance(DVec3::new(0.3, 0.1, 0.2)) + 1.0 - 0.14_f64.sqrt()).abs() < 1e-3);
    }
}

#[test]
fn queries_on_several_threads_are_bitwise_identical() {
    let surface = gear(24).surface();
    let queries = points(&surface, 500);
    let answers = || -> Vec<(f64, u32)> {
        let nearest = |query: &DVec3| surface.nearest(*query).triangle;
        queries.iter().map(|query| (surface.signed_distance(*query), nearest(query))).collect()
    };
    let first = answers();
    std::thread::scope(|scope| {
        let threads: Vec<_> = (0..3).map(|_| scope.spawn(answers)).collect();
        for thread in threads {
            assert_eq!(thread.join().unwrap(), first);
        }
    });
}

#[test]
fn queries_far_away_and_on_the_surface_are_finite() {
    let surface = gear(9).surface();
    for query in [DVec3::splat(1e100), DVec3::new(-1e15, 0.0, 0.0)] {
        assert!((surface.nearest(query).distance / query.length() - 1.0).abs() < 1e-12, "{query}");
        assert!(!surface.is_inside(query));
    }
    for query in surface.vertices() {
        assert_eq!(surface.signed_distance(*query), 0.0);
        assert!(surface.winding(*query).is_finite());
        let normal = surface.smooth_normal_at(*query, &surface.nearest(*query));
        assert!((normal.length() - 1.0).abs() < 1e-12, "{query}: {normal}");
    }
    assert_eq!(surface.nearest_within(DVec3::ZERO, -1.0), None);
    assert_eq!(surface.nearest_within(DVec3::NAN, 1.0), None);
}

#[test]
fn slender_triangles_are_as_accurate_as_others() {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7);
    for height in [1e-3, 1e-5, 1e-7, 1e-9] {
        let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, height, 0.0)].map(|corner| turn * corner);
        let surface = Surface::from_triangles(corners.to_vec(), vec![[0, 1, 2]]).unwrap();
        for (x, y) in [(0.4, 0.5), (0.2, 0.2), (0.9, 0.1)] {
            let foot = DVec3::new(x, y * height, 0.0);
            for above in [0.3, 1e-6, -2.0] {
                let found = surface.nearest(turn * (foot + above * DVec3::Z));
                assert!(
                    (found.distance - f64::abs(above)).abs() < 1e-12,
                    "{height} {foot} {above}: {found:?}"
                );
            }
        }
    }
}

#[test]
fn planes_of_a_turned_bar_are_found_in_single_precision() {
    let turn = DQuat::from_euler(EulerRot::XYZ, 0.3, 1.1, -0.7);
    let mut shape = bar(DVec3::new(4.0, 2.0, 1.0));
    shape.vertices.iter_mut().for_each(|vertex| *vertex = turn * *vertex + DVec3::new(5.0, -3.0, 2.0));
    let facets = crate::read(&shape.binary_stl(), "bar.stl").unwrap();
    let part = crate::Part { name: "bar".to_owned(), facets };
    let planes = Surface::new(vec![part], 1.0).unwrap().0.planes();
    assert_eq!(planes.len(), 6);
    for (plane, area) in planes.iter().zip([8.0, 8.0, 4.0, 4.0, 2.0, 2.0]) {
        // Coordinates of 5 have an error of 2e-7 in f32.
        assert!((plane.area - area).abs() < 1e-5, "{plane:?}");
        let along = turn.inverse() * plane.normal;
        assert!((along.abs().max_element() - 1.0).abs() < 1e-6, "{plane:?}");
    }
}

#[test]
fn nearest_of_several_triangles_is_the_first() {
    let surface = cube().surface();
    // Below the diagonal shared by triangles 0 and 1, and at a corner of five triangles.
    assert_eq!(surface.nearest(DVec3::new(0.5, 0.5, -1.0)).triangle, 0);
    let nearest = surface.nearest(DVec3::splat(-1.0));
    assert_eq!((nearest.triangle, nearest.point, nearest.distance), (0, DVec3::ZERO, 3.0_f64.sqrt()));
}

#[test]
fn normals_point_outwards_at_faces_edges_and_vertices() {
    let surface = cube().surface();
    let cases = [
        (DVec3::new(0.3, 0.6, -0.2), -DVec3::Z),
        (DVec3::new(0.3, 0.6, 0.2), -DVec3::Z),
        (DVec3::new(0.3, 0.6, 0.0), -DVec3::Z),
        (DVec3::new(0.3, 0.0, 0.0), -(DVec3::Y + DVec3::Z).normalize()),
        (DVec3::ONE, DVec3::ONE.normalize()),
        (DVec3::splat(2.0), DVec3::ONE.normalize()),
    ];
    for (query, normal) in cases {
        let found = surface.smooth_normal_at(query, &surface.nearest(query));
        assert!(found.distance(normal) < 1e-12, "{query}: {found}, must be {normal}");
    }
}

#[test]
fn planes_are_those_of_the_flat_walls() {
    let planes = bar(DVec3::new(4.0, 2.0, 1.0)).moved(DVec3::new(0.0, 10.0, 0.0)).surface().planes();
    let found: Vec<(DVec3, f64, f64)> = planes.iter().map(|p| (p.normal, p.offset, p.area)).collect();
    let wanted = [
        (-DVec3::Z, 0.0, 8.0),
        (DVec3::Z, 1.0, 8.0),
        (-DVec3::Y, -10.0, 4.0),
        (DVec3::Y, 12.0, 4.0),
        (-DVec3::X, 0.0, 2.0),
        (DVec3::X, 4.0, 2.0),
    ];
    for plane in wanted {
        assert!(found.contains(&plane), "{plane:?} in {found:?}");
    }
    assert_eq!(found.len(), wanted.len());
    assert!(gear(24).surface().planes()[0].normal.z.abs() > 0.999_999, "the ends are largest");
    assert!(sphere(100).surface().planes().is_empty(), "a sphere has no flat wall");
}
