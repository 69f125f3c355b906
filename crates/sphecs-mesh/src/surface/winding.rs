//! Generalised winding number, the inside test of surfaces that need not be perfect.
//!
//! ```text
//! w(q) = 1/(4π) Σ_t Ω_t(q),   tan(Ω_t/2) = a·(b × c)/(|a||b||c| + (a·b)|c| + (b·c)|a| + (c·a)|b|)
//! ```
//!
//! Jacobson et al. (2013), with a, b, c the corners of a triangle from q; w is 1 inside and 0
//! outside a closed surface that is counter-clockwise seen from outside. Triangles of a node of the
//! tree that are farther from q than β times its radius, β = 2, are summed at once by the expansion
//! of Barill et al. (2018), up to the first moment:
//!
//! ```text
//! Σ Ω_t ≈ A·d/|d|³ + tr M/|d|³ − 3 d·M d/|d|⁵,   d = p − q,  M = Σ (x_t − p) A_tᵀ
//! ```
//!
//! Its error is below 0.08 (test `expansion_is_near_the_exact_sum`). Where w is farther than 0.2
//! from a whole number, near an opening, all triangles are summed.

use std::f64::consts::PI;

use glam::DVec3;

use super::bvh::{Bvh, Moments, STACK};
use crate::triangulation::Triangulation;

/// Distance in radii from which the expansion of a node is used.
const BETA: f64 = 2.0;

/// Distance from a whole number beyond which the expansion is not accurate enough.
const DOUBTFUL: f64 = 0.2;

/// Returns the winding number at a point: by the expansion, or exactly where that is in doubt.
pub(crate) fn winding(bvh: &Bvh, mesh: &Triangulation, query: DVec3) -> f64 {
    let expanded = expanded(bvh, mesh, query);
    if (expanded - expanded.round()).abs() > DOUBTFUL { exact(bvh, mesh, query) } else { expanded }
}

/// Returns the winding number by the expansion.
pub(crate) fn expanded(bvh: &Bvh, mesh: &Triangulation, query: DVec3) -> f64 {
    let mut sum = 0.0;
    let mut stack = [0_u32; STACK];
    let mut held = 1;
    while held > 0 {
        held -= 1;
        let index = stack[held] as usize;
        let (node, moments) = (&bvh.nodes[index], &bvh.moments[index]);
        let away = moments.centre - query;
        let distance_squared = away.length_squared();
        if distance_squared > BETA * BETA * moments.radius * moments.radius {
            sum += far_field(moments, away, distance_squared);
        } else if node.count > 0 {
            sum += bvh.leaf(node).iter().map(|t| solid_angle(mesh, *t, query)).sum::<f64>();
        } else {
            stack[held] = index as u32 + 1;
            stack[held + 1] = node.first;
            held += 2;
        }
    }
    sum / (4.0 * PI)
}

/// Returns the winding number as the sum over all triangles of the tree.
pub(crate) fn exact(bvh: &Bvh, mesh: &Triangulation, query: DVec3) -> f64 {
    bvh.order.iter().map(|triangle| solid_angle(mesh, *triangle, query)).sum::<f64>() / (4.0 * PI)
}

fn far_field(moments: &Moments, away: DVec3, distance_squared: f64) -> f64 {
    let inverse_cube = 1.0 / (distance_squared * distance_squared.sqrt());
    let trace = moments.first.x_axis.x + moments.first.y_axis.y + moments.first.z_axis.z;
    let quadratic = away.dot(moments.first * away);
    (moments.dipole.dot(away) + trace - 3.0 * quadratic / distance_squared) * inverse_cube
}

/// Returns the solid angle of a triangle seen from a point, sr; positive from behind its normal.
fn solid_angle(mesh: &Triangulation, triangle: u32, query: DVec3) -> f64 {
    let [a, b, c] = mesh.corners(triangle as usize).map(|corner| corner - query);
    let (length_a, length_b, length_c) = (a.length(), b.length(), c.length());
    let triple = a.dot(b.cross(c));
    let sum =
        length_a * length_b * length_c + a.dot(b) * length_c + b.dot(c) * length_a + c.dot(a) * length_b;
    2.0 * triple.atan2(sum)
}
