//! Polygon and prism, exact on both sides.

use glam::{DVec2, DVec3};

use super::primitives::corner;

/// Returns the signed distance to a polygon, m. The corners may be in either orientation.
pub fn polygon(point: DVec2, points: &[DVec2]) -> f64 {
    let mut squared = f64::INFINITY;
    let mut inside = false;
    for (index, &a) in points.iter().enumerate() {
        let b = points[(index + 1) % points.len()];
        squared = squared.min(squared_distance(point, a, b));
        inside ^= crosses_ray(point, a, b);
    }
    let distance = squared.sqrt();
    if inside { -distance } else { distance }
}

/// Returns the squared distance to the edge from a to b, m².
pub fn squared_distance(point: DVec2, a: DVec2, b: DVec2) -> f64 {
    let edge = b - a;
    let along = ((point - a).dot(edge) / edge.length_squared()).clamp(0.0, 1.0);
    (point - a - along * edge).length_squared()
}

/// Returns true if the ray from a point to +x crosses the edge from a to b. The edge is half-open
/// in y, so that a corner counts once.
pub fn crosses_ray(point: DVec2, a: DVec2, b: DVec2) -> bool {
    let is_level = (a.y > point.y) == (b.y > point.y);
    !is_level && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x)
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
            if edges_touch(edge(i), edge(j)) {
                return Some((i, j));
            }
        }
    }
    None
}

/// Returns true if the edges from a to b and from c to d cross or touch.
pub fn edges_touch((a, b): (DVec2, DVec2), (c, d): (DVec2, DVec2)) -> bool {
    // Of edges on one line the boxes tell whether they overlap.
    let meet = a.min(b).cmple(c.max(d)) & c.min(d).cmple(a.max(b));
    let side = |p: DVec2, q: DVec2, r: DVec2| (q - p).perp_dot(r - p);
    meet.all() && side(a, b, c) * side(a, b, d) <= 0.0 && side(c, d, a) * side(c, d, b) <= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edges_on_one_line_touch_only_if_they_overlap() {
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0], [3.0, 3.0], [0.0, 1.0]];
        assert_eq!(crossing_edges(&square.map(DVec2::from)), None);
        let edge = |from: f64, to: f64| (DVec2::new(from, 0.0), DVec2::new(to, 0.0));
        assert!(edges_touch(edge(0.0, 3.0), edge(2.0, 1.0)) && edges_touch(edge(0.0, 1.0), edge(1.0, 2.0)));
        assert!(!edges_touch(edge(0.0, 1.0), edge(2.0, 3.0)));
        let on_itself = [[0.0, 0.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [2.0, 0.0], [1.0, 0.0], [1.0, 1.0]];
        assert_eq!(crossing_edges(&on_itself.map(DVec2::from)), Some((0, 3)));
    }
}
