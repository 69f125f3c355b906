//! Division of polygons into triangles.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::read;

/// Reads one polygon as a face of an OBJ file and returns its triangles' areas in all and their sum
/// as a vector, m².
fn areas(points: &[DVec3]) -> (f64, DVec3) {
    let mut text = String::new();
    points.iter().for_each(|p| text.push_str(&format!("v {} {} {}\n", p.x, p.y, p.z)));
    text.push('f');
    (1..=points.len()).for_each(|at| text.push_str(&format!(" {at}")));
    let facets = read(text.as_bytes(), "a.obj").unwrap();
    assert_eq!(facets.triangles.len(), points.len() - 2);
    let area = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| facets.vertices[vertex as usize]);
        0.5 * (b - a).cross(c - a)
    };
    let areas = facets.triangles.iter().map(area);
    (areas.clone().map(DVec3::length).sum(), areas.sum())
}

fn star(corners: usize, inner: f64) -> Vec<DVec3> {
    let corner = |at: usize| {
        let phi = TAU * at as f64 / corners as f64;
        let radius = if at.is_multiple_of(2) { inner } else { 1.0 };
        DVec3::new(radius * phi.cos(), radius * phi.sin(), 0.3 * radius * phi.cos())
    };
    (0..corners).map(corner).collect()
}

#[test]
fn triangles_of_a_simple_polygon_do_not_overlap() {
    let arrow = [(0.0, 0.0), (2.0, 1.0), (0.0, 2.0), (1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, 0.0));
    let mut turned = star(40, 0.3);
    turned.reverse();
    for polygon in [arrow.to_vec(), star(10, 0.2), star(800, 0.9), turned, star(12, 1.0)] {
        let (sum, vector) = areas(&polygon);
        // Equal only if no triangle is turned over.
        assert!((sum - vector.length()).abs() < 1e-12 * sum, "{} corners: {sum} {vector}", polygon.len());
    }
}

#[test]
fn polygons_that_cross_themselves_are_divided() {
    let bow = [DVec3::ZERO, DVec3::new(1.0, 1.0, 0.0), DVec3::X, DVec3::Y];
    let _ = areas(&bow);
    let _ = areas(&[DVec3::ZERO; 5]);
    let _ = areas(&[DVec3::ZERO, DVec3::X, 2.0 * DVec3::X, DVec3::X, DVec3::ZERO]);
}
