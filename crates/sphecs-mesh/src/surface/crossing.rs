//! Test whether two triangles cross, without rounding.
//!
//! Two triangles cross if each has corners strictly on both sides of the plane of the other, and
//! their intersections with the line of both planes overlap in more than a point: Guigue &
//! Devillers (2003), with strict inequalities. Triangles that touch, or lie in one plane, do not
//! cross: parts of an assembly often touch.

use glam::DVec3;
use robust::{Coord3D, orient3d};

/// Corner with the number of its vertex: signs of equal vertices are 0 without a computation.
pub(crate) type Corner = (u32, DVec3);

/// Returns true for two triangles that cross.
pub(crate) fn cross(p: [Corner; 3], q: [Corner; 3]) -> bool {
    let shared = p.iter().filter(|corner| q.iter().any(|other| corner.0 == other.0)).count();
    if shared > 1 {
        // One corner of each is left, which cannot be on both sides.
        return false;
    }
    let sides_p = sides(q, p);
    if !straddles(sides_p) {
        return false;
    }
    let sides_q = sides(p, q);
    if !straddles(sides_q) {
        return false;
    }
    let (p, is_p_above) = alone_first(p, sides_p);
    let (q, is_q_above) = alone_first(q, sides_q);
    // Turned so that the first corner of each is above the plane of the other.
    let [p1, p2, p3] = if is_q_above { p } else { swapped(p) };
    let [q1, q2, q3] = if is_p_above { q } else { swapped(q) };
    side([p1, p2, q1], q2) < 0.0 && side([p1, p3, q3], q1) < 0.0
}

/// Returns the sides of a plane through three corners on which others are.
fn sides(plane: [Corner; 3], corners: [Corner; 3]) -> [f64; 3] {
    corners.map(|corner| side(plane, corner))
}

/// Returns a number with the exact sign of the volume between a triangle and a corner: positive
/// above the triangle, from where it is counter-clockwise.
fn side(triangle: [Corner; 3], corner: Corner) -> f64 {
    let all = [triangle[0], triangle[1], triangle[2], corner];
    if (0..4).any(|a| (0..a).any(|b| all[a].0 == all[b].0)) {
        return 0.0;
    }
    let [a, b, c, d] = all.map(|(_, place)| Coord3D { x: place.x, y: place.y, z: place.z });
    -orient3d(a, b, c, d)
}

fn straddles(sides: [f64; 3]) -> bool {
    sides.iter().any(|side| *side > 0.0) && sides.iter().any(|side| *side < 0.0)
}

/// Turns the corners so that the one alone on its side is first; true if that is above.
fn alone_first(corners: [Corner; 3], sides: [f64; 3]) -> ([Corner; 3], bool) {
    let is_alone = |at: &usize| {
        let others = [sides[(at + 1) % 3], sides[(at + 2) % 3]];
        let is_above = sides[*at] > 0.0 && others.iter().all(|side| *side <= 0.0);
        is_above || (sides[*at] < 0.0 && others.iter().all(|side| *side >= 0.0))
    };
    let first = (0..3).find(is_alone).unwrap_or_default();
    ([0, 1, 2].map(|offset| corners[(first + offset) % 3]), sides[first] > 0.0)
}

fn swapped([a, b, c]: [Corner; 3]) -> [Corner; 3] {
    [a, c, b]
}
