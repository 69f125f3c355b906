//! Polygon and prism, exact on both sides.

use glam::{DVec2, DVec3};

use super::primitives::corner;

/// Returns the signed distance to a polygon, m. The corners may be in either orientation.
pub fn polygon(point: DVec2, points: &[DVec2]) -> f64 {
    let mut squared = f64::INFINITY;
    let mut inside = false;
    for (index, &a) in points.iter().enumerate() {
        let b = points[(index + 1) % points.len()];
        let edge = b - a;
        let along = ((point - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
        squared = squared.min((point - a - along * edge).length_squared());
        // Crossing number of the ray to +x; half-open in y, so that a corner counts once.
        if (a.y > point.y) != (b.y > point.y) {
            let crossing = a.x + (point.y - a.y) / edge.y * edge.x;
            inside ^= point.x < crossing;
        }
    }
    let distance = squared.sqrt();
    if inside { -distance } else { distance }
}

/// Returns the signed distance to a polygon in x and y, extruded along z from `from` to `to`, m; ±∞
/// in 2D.
pub fn prism(point: DVec3, points: &[DVec2], from: f64, to: f64) -> f64 {
    let lateral = polygon(point.truncate(), points);
    corner(lateral, (from - point.z).max(point.z - to))
}

/// Returns the area of a polygon, m²; negative if the corners are clockwise.
pub fn signed_area(points: &[DVec2]) -> f64 {
    let mut doubled = 0.0;
    for (index, a) in points.iter().enumerate() {
        doubled += a.perp_dot(points[(index + 1) % points.len()]);
    }
    doubled / 2.0
}

/// Returns two edges of a polygon that cross or touch without being neighbours.
pub fn crossing_edges(points: &[DVec2]) -> Option<(usize, usize)> {
    let count = points.len();
    let edge = |i: usize| (points[i], points[(i + 1) % count]);
    for i in 0..count {
        for j in i + 2..count {
            if i == 0 && j == count - 1 {
                continue;
            }
            let ((a, b), (c, d)) = (edge(i), edge(j));
            let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
            if side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0 {
                return Some((i, j));
            }
        }
    }
    None
}
