//! Box and cylinder, exact on both sides.

use glam::DVec3;

/// Returns the signed distance to an axis-aligned box, m. Bounds may be infinite.
pub fn cuboid(point: DVec3, min: DVec3, max: DVec3) -> f64 {
    let beyond = (min - point).max(point - max);
    beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
}

/// Returns the signed distance to a cylinder with flat ends, m.
pub fn cylinder(point: DVec3, from: DVec3, to: DVec3, radius: f64) -> f64 {
    let axis = to - from;
    let length = axis.length();
    let direction = axis / length;
    let along = (point - from).dot(direction);
    let radial = (point - from - along * direction).length() - radius;
    corner(radial, (-along).max(along - length))
}

/// Returns the signed distance to the intersection of two regions with perpendicular surfaces, m;
/// exact if both distances are.
pub fn corner(a: f64, b: f64) -> f64 {
    a.max(0.0).hypot(b.max(0.0)) + a.max(b).min(0.0)
}
