//! Directions of the plane and straight surfaces of a shape, and the shape as seen by a turned
//! observer.

use glam::{DMat3, DVec2, DVec3};

use super::Shape;

/// A direction that a part of the surface has.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Direction {
    /// A plane across a unit normal, with its distance from the origin along it, m.
    Plane {
        /// Unit normal.
        normal: DVec3,
        /// Coordinate along the normal, m.
        offset: f64,
    },
    /// The side of a cylinder along a unit vector, with its area, m².
    Side {
        /// Unit vector along the axis.
        axis: DVec3,
        /// Area, m².
        area: f64,
    },
}

impl Shape {
    /// Collects the directions of planes and of sides of cylinders that touch the surface.
    pub fn directions(&self, found: &mut Vec<Direction>) {
        match self {
            Shape::Box { min, max } => {
                for (axis, unit) in DVec3::AXES.into_iter().enumerate() {
                    found.extend(
                        [min[axis], max[axis]].map(|offset| Direction::Plane { normal: unit, offset }),
                    );
                }
            }
            Shape::Ball { .. } | Shape::Extension { .. } => {}
            Shape::Cylinder { from, to, radius } => {
                let axis = (*to - *from).normalize_or_zero();
                found.extend([from, to].map(|end| plane(axis, *end)));
                let area = std::f64::consts::TAU * radius * from.distance(*to);
                found.push(Direction::Side { axis, area });
            }
            Shape::Prism { points, from, to } => {
                let edge = |(index, a): (usize, &DVec2)| edge(*a, points[(index + 1) % points.len()]);
                found.extend(points.iter().enumerate().map(edge));
                found.extend([from, to].map(|z| Direction::Plane { normal: DVec3::Z, offset: *z }));
            }
            Shape::Outline(outline) => found.extend(outline.straight().iter().map(|(a, b)| edge(*a, *b))),
            Shape::Bend(bend) => {
                let axis = bend.outwards.cross(bend.direction);
                let half = bend.section.half_height() * axis;
                found.extend([-half, half].map(|aside| plane(axis, bend.center + aside)));
            }
            Shape::Mesh(surface) => {
                let planes = surface.planes().into_iter();
                found.extend(
                    planes.map(|plane| Direction::Plane { normal: plane.normal, offset: plane.offset }),
                );
            }
            Shape::Union(shapes) | Shape::Intersection(shapes) => {
                for shape in shapes {
                    shape.directions(found);
                }
            }
            Shape::Difference(shape, hole) => {
                shape.directions(found);
                hole.directions(found);
            }
            Shape::Placed { shape, rotation, scale, origin } => {
                let mut local = Vec::new();
                shape.directions(&mut local);
                found.extend(local.into_iter().map(|direction| match direction {
                    Direction::Plane { normal, offset } => {
                        let normal = *rotation * normal;
                        Direction::Plane { normal, offset: offset * scale + origin.dot(normal) }
                    }
                    Direction::Side { axis, area } => {
                        Direction::Side { axis: *rotation * axis, area: area * scale * scale }
                    }
                }));
            }
        }
    }

    /// Returns the shape rotated about the origin.
    ///
    /// Rotations that cancel leave no trace, so that planes which come to lie across an axis are
    /// found as such.
    pub fn rotated(&self, by: DMat3) -> Shape {
        let each = |shapes: &[Shape]| shapes.iter().map(|shape| shape.rotated(by)).collect();
        match self {
            Shape::Union(shapes) => Shape::Union(each(shapes)),
            Shape::Intersection(shapes) => Shape::Intersection(each(shapes)),
            Shape::Difference(shape, hole) => Shape::Difference(
                std::boxed::Box::new(shape.rotated(by)),
                std::boxed::Box::new(hole.rotated(by)),
            ),
            Shape::Placed { shape, rotation, scale, origin } => Shape::Placed {
                shape: shape.clone(),
                rotation: clean(by * *rotation),
                scale: *scale,
                origin: by * *origin,
            },
            other => Shape::Placed {
                shape: std::boxed::Box::new(other.clone()),
                rotation: by,
                scale: 1.0,
                origin: DVec3::ZERO,
            },
        }
    }
}

/// Returns the plane of the edge from a to b.
fn edge(a: DVec2, b: DVec2) -> Direction {
    let edge = b - a;
    plane(DVec2::new(edge.y, -edge.x).normalize_or_zero().extend(0.0), a.extend(0.0))
}

fn plane(normal: DVec3, point: DVec3) -> Direction {
    Direction::Plane { normal, offset: normal.dot(point) }
}

/// Returns a rotation without the rounding errors of components that are 0 or ±1.
pub fn clean(rotation: DMat3) -> DMat3 {
    DMat3::from_cols_array(
        &rotation.to_cols_array().map(|c| if (c - c.round()).abs() < 1e-12 { c.round() } else { c }),
    )
}
