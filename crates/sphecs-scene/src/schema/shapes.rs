//! Shapes of a scene file.

use serde::Deserialize;

use super::{Number, Vector};
use crate::notation::typed::Spanned;

/// A region of space.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum ShapeFile {
    /// Axis-aligned rectangle or box.
    Box {
        /// Lower corner, m.
        min: Vector,
        /// Upper corner, m.
        max: Vector,
    },
    /// Circle, in 2D.
    Circle {
        /// Centre, m.
        center: Vector,
        /// Radius, m.
        radius: Number,
    },
    /// Sphere, in 3D.
    Sphere {
        /// Centre, m.
        center: Vector,
        /// Radius, m.
        radius: Number,
    },
    /// Cylinder with flat ends, in 3D.
    Cylinder {
        /// Middle of one end, m.
        from: Vector,
        /// Middle of the other end, m.
        to: Vector,
        /// Radius, m.
        radius: Number,
    },
    /// Polygon, in 2D.
    Polygon {
        /// Corners in order, m.
        points: Spanned<Vec<Vector>>,
    },
    /// Polygon in x and y extruded along z, in 3D.
    Extruded {
        /// Corners in order, (x, y) in m.
        points: Spanned<Vec<Vector>>,
        /// Lower end, z in m.
        from: Number,
        /// Upper end, z in m.
        to: Number,
    },
    /// A section swept along an arc, in 3D.
    Bend {
        /// Centre of the section at the beginning, m.
        start: Vector,
        /// Direction of the pipe at the beginning.
        direction: Vector,
        /// Centre of the arc, m.
        center: Vector,
        /// Angle turned through, degrees.
        angle: Number,
        /// Section.
        section: BendSectionFile,
    },
    /// Union of all of them.
    Union(Spanned<Vec<ShapeFile>>),
    /// Intersection of all of them.
    Intersection(Spanned<Vec<ShapeFile>>),
    /// Difference: points in the first shape and in none of the others.
    Difference(Spanned<Vec<ShapeFile>>),
    /// Moved by a vector.
    Translated {
        /// Displacement, m.
        by: Vector,
        /// Shape that is moved.
        shape: std::boxed::Box<ShapeFile>,
    },
    /// Rotated about a point, in 2D, or an axis, in 3D.
    Rotated {
        /// Angle, degrees, anticlockwise.
        angle: Number,
        /// Axis in 3D, default z.
        #[serde(default)]
        axis: Option<Vector>,
        /// Fixed point of the rotation, m, default the origin.
        #[serde(default)]
        about: Option<Vector>,
        /// Shape that is rotated.
        shape: std::boxed::Box<ShapeFile>,
    },
    /// Scaled about the origin.
    Scaled {
        /// Factor.
        factor: Number,
        /// Shape that is scaled.
        shape: std::boxed::Box<ShapeFile>,
    },
}

/// Section of a bend.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum BendSectionFile {
    /// A circle.
    Circular {
        /// Radius, m.
        radius: Number,
    },
    /// A rectangle.
    Rectangular {
        /// Width along the radius of the arc, m.
        width: Number,
        /// Height along the axis of the arc, m.
        height: Number,
    },
}
