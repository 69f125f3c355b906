//! Pieces of the surface of an emitter in 2D: equal parts of its smooth curves.
//!
//! The curves end at the corners of the wall, which are found where the tangents on both sides
//! meet. What lies on the border of the region is not in it: of a box whose region ends at its
//! corners only the face inside emits.

use glam::DVec3;

use super::Piece;
use crate::layers::surface_curves;
use crate::model::Scene;
use crate::movers::Wall;
use crate::wall_particles::surface_of;

/// Cosine of the largest angle between the normals of neighbouring points of a smooth curve.
const SMOOTH: f64 = 0.9;

/// Depth in the region that a part of the surface must reach, in spacings.
const INSIDE: f64 = 1e-3;

/// Length of the shortest part of a curve, in spacings.
const SHORTEST: f64 = 0.25;

/// Distance of the points between which the curvature is found from the ends of a piece, as a share
/// of its length: a corner may be at its end.
const INSET: f64 = 0.1;

/// Returns the pieces of the surface of a wall in a region, whose signed distance is given, m.
pub fn pieces(scene: &Scene, wall: Wall, region: &dyn Fn(DVec3) -> f64) -> Vec<Piece> {
    let curves = surface_curves(scene, wall);
    let smooth = curves.iter().flat_map(|curve| smooth_parts(scene, wall, curve));
    let is_inside = |part: &Vec<DVec3>| {
        let middles = part.windows(2).map(|pair| region(pair[0].midpoint(pair[1])));
        middles.fold(f64::INFINITY, f64::min) < -INSIDE * scene.spacing
    };
    let parts = smooth.flat_map(|curve| clipped(&curve, region)).filter(is_inside);
    parts.flat_map(|part| cut(scene, wall, &part)).collect()
}

/// Divides a curve at its corners, m.
fn smooth_parts(scene: &Scene, wall: Wall, curve: &[DVec3]) -> Vec<Vec<DVec3>> {
    let normals: Vec<DVec3> = curve.iter().map(|point| wall.gradient(scene, *point)).collect();
    let mut parts = vec![vec![curve[0]]];
    for at in 1..curve.len() {
        if normals[at].dot(normals[at - 1]) < SMOOTH {
            let corner = meeting((curve[at - 1], normals[at - 1]), (curve[at], normals[at]));
            if let Some(part) = parts.last_mut() {
                part.push(corner);
            }
            parts.push(vec![corner]);
        }
        if let Some(part) = parts.last_mut() {
            part.push(curve[at]);
        }
    }
    let is_closed = curve.len() > 2 && curve[0] == curve[curve.len() - 1];
    if is_closed && parts.len() > 1 {
        // The last part continues in the first.
        let first = parts.remove(0);
        if let Some(last) = parts.last_mut() {
            last.extend(first.into_iter().skip(1));
        }
    }
    parts
}

/// Returns the point where the tangents of two points with their normals meet, m.
fn meeting((a, of_a): (DVec3, DVec3), (b, of_b): (DVec3, DVec3)) -> DVec3 {
    let along = DVec3::new(-of_a.y, of_a.x, 0.0);
    let slope = along.dot(of_b);
    let reach = a.distance(b);
    if slope.abs() < 1e-3 {
        a.midpoint(b)
    } else {
        a + along * ((b - a).dot(of_b) / slope).clamp(-reach, reach)
    }
}

/// Returns the parts of a curve in a region, m.
fn clipped(curve: &[DVec3], region: &dyn Fn(DVec3) -> f64) -> Vec<Vec<DVec3>> {
    let is_inside: Vec<bool> = curve.iter().map(|point| region(*point) <= 0.0).collect();
    if is_inside.iter().all(|inside| *inside) {
        return vec![curve.to_vec()];
    }
    let mut parts: Vec<Vec<DVec3>> = Vec::new();
    let mut part: Vec<DVec3> = Vec::new();
    for (index, point) in curve.iter().enumerate() {
        if index > 0 && is_inside[index] != is_inside[index - 1] {
            part.push(border(curve[index - 1], *point, region));
            if !is_inside[index] {
                parts.push(std::mem::take(&mut part));
            }
        }
        if is_inside[index] {
            part.push(*point);
        }
    }
    let is_closed = curve.len() > 2 && curve[0] == curve[curve.len() - 1];
    match parts.first_mut() {
        // The part that holds the first point of a closed curve begins at its end.
        Some(first) if is_closed && is_inside[0] && !part.is_empty() => {
            part.extend(first.iter().skip(1));
            *first = part;
        }
        _ if part.len() > 1 => parts.push(part),
        _ => {}
    }
    parts
}

/// Returns the point between two points on different sides of the border of a region, m.
fn border(from: DVec3, to: DVec3, region: &dyn Fn(DVec3) -> f64) -> DVec3 {
    let side = region(from) <= 0.0;
    let (mut low, mut high) = (0.0, 1.0);
    for _ in 0..50 {
        let middle = 0.5 * (low + high);
        if (region(from.lerp(to, middle)) <= 0.0) == side {
            low = middle;
        } else {
            high = middle;
        }
    }
    from.lerp(to, 0.5 * (low + high))
}

/// Cuts a part of a curve into equal pieces of about a spacing.
fn cut(scene: &Scene, wall: Wall, part: &[DVec3]) -> Vec<Piece> {
    let mut ends = vec![0.0];
    for pair in part.windows(2) {
        ends.push(ends[ends.len() - 1] + pair[0].distance(pair[1]));
    }
    let total = ends[ends.len() - 1];
    if total < SHORTEST * scene.spacing {
        return Vec::new();
    }
    let count = (total / scene.spacing).round().max(1.0);
    let length = total / count;
    let at = |passed: f64| {
        let index = ends.partition_point(|end| *end < passed).clamp(1, part.len() - 1);
        let share = (passed - ends[index - 1]) / (ends[index] - ends[index - 1]).max(f64::MIN_POSITIVE);
        part[index - 1].lerp(part[index], share.clamp(0.0, 1.0))
    };
    let piece = |index: usize| {
        let place = |share: f64| at((index as f64 + share) * length);
        let (foot, normal, _) = surface_of(scene, wall, place(0.5));
        let [first, last] = [INSET, 1.0 - INSET].map(|share| surface_of(scene, wall, place(share)));
        let way = last.0 - first.0;
        Piece {
            foot,
            normal,
            area: length,
            curvature_sum: (last.1 - first.1).dot(way) / way.length_squared().max(f64::MIN_POSITIVE),
            curvature_product: 0.0,
        }
    };
    (0..count as usize).map(piece).collect()
}
