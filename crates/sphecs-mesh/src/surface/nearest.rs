//! Nearest point of a surface.
//!
//! The result is the smallest pair (distance, number of the triangle) over all triangles. The
//! search leaves out a box only if it is farther than the best point found; points are clamped to
//! the box of their triangle, so that rounding cannot make a box farther than a point in it.

use glam::DVec3;

use super::bvh::{Bvh, Node, STACK};
use crate::triangulation::Triangulation;

/// Share of the product of two edges below which a triangle is taken as three edges: its normal is
/// rounding.
const FLAT: f64 = 1e-11;

/// Allowance for the rounding of the square of a bound: a distance that was found is within itself.
const ROUNDING: f64 = 4.0 * f64::EPSILON;

/// Part of a triangle that has the nearest point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The interior.
    Face,
    /// The edge from this corner, 0 to 2, to the next.
    Edge(u8),
    /// This corner, 0 to 2.
    Vertex(u8),
}

/// Nearest point of a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// Position, m.
    pub point: DVec3,
    /// Number of the triangle, the smallest of several at the same distance.
    pub triangle: u32,
    /// Part of the triangle.
    pub feature: Feature,
    /// Distance from the query, m, at least 0.
    pub distance: f64,
}

/// Returns the nearest point within `bound` of `query`; None if there is none.
pub(crate) fn nearest_within(bvh: &Bvh, mesh: &Triangulation, query: DVec3, bound: f64) -> Option<Nearest> {
    let mut best = Nearest {
        point: query,
        triangle: u32::MAX,
        feature: Feature::Face,
        // The square of the distance until the end.
        distance: bound * bound * (1.0 + ROUNDING),
    };
    let limit = best.distance;
    visit_near(bvh, query, 1.0, limit, |triangle| {
        take_nearer(&mut best, mesh, triangle, query);
        best.distance
    });
    best.distance = best.distance.sqrt();
    (best.triangle != u32::MAX && best.distance <= bound).then_some(best)
}

/// Returns a distance from `query`, m, within which there is no surface: at least 1/`slack` of that
/// of the nearest point. From near the centre of a round surface, to which all triangles are as
/// far, the search for the nearest one would visit them all.
pub(crate) fn clearance(bvh: &Bvh, mesh: &Triangulation, query: DVec3, slack: f64) -> f64 {
    let mut best = f64::INFINITY;
    visit_near(bvh, query, slack, best, |triangle| {
        let (point, _) = closest(mesh.corners(triangle as usize), query);
        best = best.min(point.distance_squared(query));
        best
    });
    best.sqrt() / slack
}

/// Calls `visit` with the triangles that may be nearer to `query` than a limit, nearer boxes first.
///
/// The limit is the square of a distance, m², and `visit` returns the next one. Boxes whose
/// distance times `slack` is more than that are left out.
fn visit_near(bvh: &Bvh, query: DVec3, slack: f64, mut limit: f64, mut visit: impl FnMut(u32) -> f64) {
    let mut stack = [(0_u32, box_distance_squared(&bvh.nodes[0], query)); STACK];
    let mut held = 1;
    while held > 0 {
        held -= 1;
        let (index, distance) = stack[held];
        if distance * slack * slack > limit {
            continue;
        }
        let node = &bvh.nodes[index as usize];
        if node.count > 0 {
            for triangle in bvh.leaf(node) {
                limit = visit(*triangle);
            }
            continue;
        }
        let of = |child: u32| (child, box_distance_squared(&bvh.nodes[child as usize], query));
        let (first, second) = (of(index + 1), of(node.first));
        let is_first_nearer = first.1 < second.1;
        (stack[held], stack[held + 1]) = if is_first_nearer { (second, first) } else { (first, second) };
        held += 2;
    }
}

/// Replaces the best point, with the square of its distance, by that of a triangle if it is nearer.
fn take_nearer(best: &mut Nearest, mesh: &Triangulation, triangle: u32, query: DVec3) {
    let (point, feature) = closest(mesh.corners(triangle as usize), query);
    let distance = point.distance_squared(query);
    if distance < best.distance || (distance == best.distance && triangle < best.triangle) {
        *best = Nearest { point, triangle, feature, distance };
    }
}

/// Returns the square of the distance of a point from the box of a node, m².
fn box_distance_squared(node: &Node, point: DVec3) -> f64 {
    (node.low - point).max(point - node.high).max(DVec3::ZERO).length_squared()
}

/// Returns the point of a triangle that is nearest to `query`, and the part that has it.
pub(crate) fn closest(corners: [DVec3; 3], query: DVec3) -> (DVec3, Feature) {
    let [a, b, c] = corners;
    let (point, feature) = closest_unclamped(corners, query);
    (point.clamp(a.min(b).min(c), a.max(b).max(c)), feature)
}

/// Regions of the plane by signs of barycentric coordinates, as in Ericson (2005), section 5.1.5.
fn closest_unclamped(corners: [DVec3; 3], query: DVec3) -> (DVec3, Feature) {
    let [a, b, c] = corners;
    let (ab, ac) = (b - a, c - a);
    let normal = ab.cross(ac);
    let size = normal.length_squared();
    if size <= FLAT * FLAT * ab.length_squared() * ac.length_squared() {
        return closest_on_edges(corners, query);
    }
    let from_a = query - a;
    let (d1, d2) = (ab.dot(from_a), ac.dot(from_a));
    if d1 <= 0.0 && d2 <= 0.0 {
        return (a, Feature::Vertex(0));
    }
    let from_b = query - b;
    let (d3, d4) = (ab.dot(from_b), ac.dot(from_b));
    if d3 >= 0.0 && d4 <= d3 {
        return (b, Feature::Vertex(1));
    }
    let vc = d1 * d4 - d3 * d2;
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        return (a + ab * (d1 / (d1 - d3)), Feature::Edge(0));
    }
    let from_c = query - c;
    let (d5, d6) = (ab.dot(from_c), ac.dot(from_c));
    if d6 >= 0.0 && d5 <= d6 {
        return (c, Feature::Vertex(2));
    }
    let vb = d5 * d2 - d1 * d6;
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        return (a + ac * (d2 / (d2 - d6)), Feature::Edge(2));
    }
    let va = d3 * d6 - d5 * d4;
    if va <= 0.0 && d4 - d3 >= 0.0 && d5 - d6 >= 0.0 {
        return (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6))), Feature::Edge(1));
    }
    // The foot of the perpendicular: barycentric coordinates lose digits in slender triangles, and
    // so does the normal in the direction of the long edges.
    let edge = if ab.length_squared() > ac.length_squared() { ab } else { ac };
    let normal = normal - edge * (normal.dot(edge) / edge.length_squared());
    (query - normal * (normal.dot(from_a) / normal.length_squared()), Feature::Face)
}

fn closest_on_edges(corners: [DVec3; 3], query: DVec3) -> (DVec3, Feature) {
    let mut best = (corners[0], Feature::Vertex(0));
    for edge in 0..3 {
        let next = (edge + 1) % 3;
        let (start, along) = (corners[edge], corners[next] - corners[edge]);
        let share = along.dot(query - start) / along.length_squared();
        let candidate = if share >= 1.0 {
            (corners[next], Feature::Vertex(next as u8))
        } else if share > 0.0 {
            (start + share * along, Feature::Edge(edge as u8))
        } else {
            // Also an edge without length.
            (start, Feature::Vertex(edge as u8))
        };
        if candidate.0.distance_squared(query) < best.0.distance_squared(query) {
            best = candidate;
        }
    }
    best
}
