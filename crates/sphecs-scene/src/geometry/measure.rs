//! Measures of any shape: bounds, gradient, nearest surface point.

use glam::{DVec2, DVec3};

use super::Shape;

/// Returns the distance along a line at which it leaves the inside, m, by steps and bisection; None
/// beyond `longest`, m.
///
/// `inside` takes the distance along the line. Walls thinner than a step may be passed.
pub fn exit_distance(inside: impl Fn(f64) -> bool, step: f64, longest: f64) -> Option<f64> {
    let mut distance = 0.0;
    while inside(distance + step) {
        distance += step;
        if distance > longest {
            return None;
        }
    }
    let (mut near, mut far) = (distance, distance + step);
    for _ in 0..60 {
        let middle = 0.5 * (near + far);
        if inside(middle) {
            near = middle;
        } else {
            far = middle;
        }
    }
    Some(0.5 * (near + far))
}

/// Returns the distance along a line at which it leaves the inside, m, by steps as long as the
/// clearance allows, and at least `least`; None beyond `longest`, m.
///
/// `signed_distance` and `clearance` take the distance along the line. Walls thinner than `least`
/// may be passed.
pub fn traced_exit(
    signed_distance: impl Fn(f64) -> f64,
    clearance: impl Fn(f64) -> f64,
    least: f64,
    longest: f64,
) -> Option<f64> {
    let (mut near, mut before) = (0.0, 0.0);
    let (mut far, mut behind) = loop {
        let clear = clearance(near);
        if clear > least {
            (near, before) = (near + clear, 0.0);
            if near > longest {
                return None;
            }
            continue;
        }
        let next = near + least;
        let distance = signed_distance(next);
        if distance > 0.0 {
            break (next, distance);
        }
        (near, before) = (next, distance);
        if near > longest {
            return None;
        }
    };
    // Regula falsi with halved ends (Illinois), on the way from inside to outside.
    for _ in 0..60 {
        if far - near <= 1e-9 * least {
            break;
        }
        let middle = far - (far - near) * behind / (behind - before).max(f64::MIN_POSITIVE);
        let distance = signed_distance(middle);
        if distance > 0.0 {
            (far, behind) = (middle, distance);
            before *= 0.5;
        } else {
            (near, before) = (middle, distance);
            behind *= 0.5;
        }
        if distance.abs() <= 1e-9 * least {
            return Some(middle);
        }
    }
    Some(0.5 * (near + far))
}

impl Shape {
    /// Returns the corners of a bounding box, m; z from −∞ to ∞ in 2D.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        match self {
            Shape::Box { min, max } => (*min, *max),
            Shape::Ball { center, radius } => {
                (center - DVec3::splat(*radius), center + DVec3::splat(*radius))
            }
            Shape::Cylinder { from, to, radius } => {
                let axis = (*to - *from).normalize_or_zero();
                let reach = *radius * (DVec3::ONE - axis * axis).max(DVec3::ZERO).map(f64::sqrt);
                (from.min(*to) - reach, from.max(*to) + reach)
            }
            Shape::Prism { points, from, to } => {
                let (mut min, mut max) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                for point in points {
                    min = min.min(point.extend(*from));
                    max = max.max(point.extend(*to));
                }
                (min, max)
            }
            Shape::Outline(outline) => {
                let (low, high) = outline.bounds();
                (low.extend(f64::NEG_INFINITY), high.extend(f64::INFINITY))
            }
            Shape::Bend(bend) => bend.bounds(),
            Shape::Mesh(surface) => surface.bounds(),
            Shape::Union(shapes) => shapes
                .iter()
                .map(Shape::bounds)
                .fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(low, high), (min, max)| {
                    (low.min(min), high.max(max))
                }),
            Shape::Intersection(shapes) => shapes
                .iter()
                .map(Shape::bounds)
                .fold((DVec3::NEG_INFINITY, DVec3::INFINITY), |(low, high), (min, max)| {
                    (low.max(min), high.min(max))
                }),
            Shape::Difference(shape, _) => shape.bounds(),
            Shape::Placed { shape, rotation, scale, origin } => {
                let (min, max) = shape.bounds();
                let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
                for corner in 0..8 {
                    let pick = |axis: usize| {
                        if corner >> axis & 1 == 0 { min[axis] } else { max[axis] }
                    };
                    let local = DVec3::new(pick(0), pick(1), pick(2));
                    // In 2D rotations are about z, so the infinite z does not mix with x and y.
                    let placed = if local.z.is_finite() {
                        *rotation * local * *scale + *origin
                    } else {
                        (*rotation * local.with_z(0.0) * *scale + *origin).with_z(local.z)
                    };
                    low = low.min(placed);
                    high = high.max(placed);
                }
                (low, high)
            }
            Shape::Extension { shape, outwards, length, .. } => {
                let (min, max) = shape.bounds();
                let reach = outwards.abs() * *length;
                (min - reach, max + reach)
            }
        }
    }

    /// Returns true if a part of it is a mesh.
    pub fn has_mesh(&self) -> bool {
        match self {
            Shape::Mesh(_) => true,
            Shape::Union(shapes) | Shape::Intersection(shapes) => shapes.iter().any(Shape::has_mesh),
            Shape::Difference(shape, hole) => shape.has_mesh() || hole.has_mesh(),
            Shape::Placed { shape, .. } | Shape::Extension { shape, .. } => shape.has_mesh(),
            Shape::Box { .. } | Shape::Ball { .. } | Shape::Cylinder { .. } => false,
            Shape::Prism { .. } | Shape::Outline(_) | Shape::Bend(_) => false,
        }
    }

    /// Returns the normalised gradient of the signed distance, exact for meshes and else by central
    /// differences over `step`, m. It is zero where the distance has no gradient, and its z is zero
    /// in 2D.
    pub fn gradient(&self, point: DVec3, step: f64, dimensions: usize) -> DVec3 {
        // A distance to a mesh takes long, and a shape of several has the gradient of the one that
        // decides.
        match self {
            Shape::Mesh(surface) => {
                let nearest = surface.nearest(point);
                return surface.smooth_normal_at(point, &nearest);
            }
            Shape::Union(shapes) if self.has_mesh() => {
                return deciding(shapes, |shape| -shape.signed_distance(point))
                    .map_or(DVec3::ZERO, |shape| shape.gradient(point, step, dimensions));
            }
            Shape::Intersection(shapes) if self.has_mesh() => {
                return deciding(shapes, |shape| shape.signed_distance(point))
                    .map_or(DVec3::ZERO, |shape| shape.gradient(point, step, dimensions));
            }
            Shape::Difference(shape, hole) if self.has_mesh() => {
                return if shape.signed_distance(point) >= -hole.signed_distance(point) {
                    shape.gradient(point, step, dimensions)
                } else {
                    -hole.gradient(point, step, dimensions)
                };
            }
            Shape::Placed { shape, rotation, scale, origin } if shape.has_mesh() => {
                let local = rotation.transpose() * (point - *origin) / *scale;
                return *rotation * shape.gradient(local, step / *scale, dimensions);
            }
            _ => {}
        }
        let mut gradient = DVec3::ZERO;
        for (axis, unit) in DVec3::AXES.iter().enumerate().take(dimensions) {
            gradient[axis] =
                self.signed_distance(point + step * *unit) - self.signed_distance(point - step * *unit);
        }
        gradient.normalize_or_zero()
    }

    /// Returns a surface point nearest to a point outside, m, by steps of the signed distance along
    /// its gradient. One step is enough where the distance is exact.
    pub fn nearest_surface(&self, point: DVec3, step: f64, dimensions: usize) -> DVec3 {
        let mut surface = point;
        for _ in 0..8 {
            let distance = self.signed_distance(surface);
            if distance.abs() < 1e-3 * step {
                break;
            }
            surface -= distance * self.gradient(surface, step, dimensions);
        }
        surface
    }
}

/// Returns the shape with the largest value.
fn deciding(shapes: &[Shape], value: impl Fn(&Shape) -> f64) -> Option<&Shape> {
    shapes.iter().max_by(|a, b| value(a).total_cmp(&value(b)))
}

impl Shape {
    /// Collects the coordinates of planes across an axis (0, 1, 2) that touch the surface:
    /// candidates for straight walls.
    pub fn planes(&self, found: &mut Vec<(usize, f64)>) {
        match self {
            Shape::Box { .. } | Shape::Ball { .. } | Shape::Cylinder { .. } => {
                let (min, max) = self.bounds();
                for axis in 0..3 {
                    found.extend([(axis, min[axis]), (axis, max[axis])]);
                }
            }
            Shape::Prism { points, from, to } => {
                for (index, a) in points.iter().enumerate() {
                    edge_planes(*a, points[(index + 1) % points.len()], found);
                }
                found.extend([(2, *from), (2, *to)]);
            }
            Shape::Outline(outline) => {
                outline.straight().iter().for_each(|(a, b)| edge_planes(*a, *b, found));
            }
            Shape::Bend(bend) => {
                let axis = bend.outwards.cross(bend.direction);
                let half = bend.section.half_height();
                for (index, unit) in DVec3::AXES.iter().enumerate() {
                    if axis.dot(*unit).abs() > 1.0 - 1e-9 {
                        let middle = bend.center[index];
                        found.extend([(index, middle - half), (index, middle + half)]);
                    }
                }
            }
            Shape::Union(shapes) | Shape::Intersection(shapes) => {
                for shape in shapes {
                    shape.planes(found);
                }
            }
            Shape::Difference(shape, hole) => {
                shape.planes(found);
                hole.planes(found);
            }
            Shape::Placed { shape, rotation, scale, origin } => {
                let mut local = Vec::new();
                shape.planes(&mut local);
                for (axis, coordinate) in local {
                    let normal = *rotation * DVec3::AXES[axis];
                    if let Some(index) = (0..3).find(|i| normal[*i].abs() > 1.0 - 1e-9) {
                        let placed = origin[index] + coordinate * scale * normal[index].signum();
                        found.push((index, placed));
                    }
                }
            }
            Shape::Mesh(surface) => {
                for plane in surface.planes() {
                    if let Some(axis) = (0..3).find(|axis| plane.normal[*axis].abs() > 1.0 - 1e-9) {
                        found.push((axis, plane.offset * plane.normal[axis].signum()));
                    }
                }
            }
            Shape::Extension { .. } => {}
        }
    }
}

/// Collects the plane across an axis on which the edge from a to b lies, if it does.
fn edge_planes(a: DVec2, b: DVec2, found: &mut Vec<(usize, f64)>) {
    let edge = b - a;
    for axis in 0..2 {
        if edge[axis].abs() < 1e-9 * edge.length() {
            found.push((axis, a[axis]));
        }
    }
}
