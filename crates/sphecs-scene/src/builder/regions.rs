//! Shapes of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::{Number, Vector};
use crate::meshes::LengthUnit;

/// A region of space.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
#[must_use = "a description does nothing until it is part of a scene"]
pub struct Shape(Kind);

/// The shapes as a scene file names them and their fields.
#[derive(Clone, Debug, PartialEq, Serialize)]
enum Kind {
    Box {
        min: Vector,
        max: Vector,
    },
    Circle {
        center: Vector,
        radius: Number,
    },
    Sphere {
        center: Vector,
        radius: Number,
    },
    Cylinder {
        from: Vector,
        to: Vector,
        radius: Number,
    },
    Polygon {
        points: Vec<Vector>,
    },
    Extruded {
        points: Vec<Vector>,
        from: Number,
        to: Number,
    },
    Bend {
        start: Vector,
        direction: Vector,
        center: Vector,
        angle: Number,
        section: BendSection,
    },
    Mesh {
        #[serde(skip_serializing_if = "Option::is_none")]
        file: Option<String>,
        #[serde(skip_serializing_if = "Option::is_none")]
        files: Option<Vec<String>>,
        unit: LengthUnit,
    },
    Outline {
        file: String,
        unit: LengthUnit,
    },
    Union(Vec<Shape>),
    Intersection(Vec<Shape>),
    Difference(Vec<Shape>),
    Translated {
        by: Vector,
        shape: Box<Shape>,
    },
    Rotated {
        #[serde(skip_serializing_if = "Option::is_none")]
        angle: Option<Number>,
        #[serde(skip_serializing_if = "Option::is_none")]
        axis: Option<Vector>,
        #[serde(skip_serializing_if = "Option::is_none")]
        about: Option<Vector>,
        shape: Box<Shape>,
    },
    Scaled {
        factor: Number,
        shape: Box<Shape>,
    },
}

impl Shape {
    /// Returns the axis-aligned rectangle or, in 3D, box between two corners, m: `Box`.
    pub fn cuboid(min: impl Into<Vector>, max: impl Into<Vector>) -> Self {
        Self(Kind::Box { min: min.into(), max: max.into() })
    }

    /// Returns the inside of a closed surface, in 3D: path of its file and unit of its coordinates.
    pub fn mesh(file: impl Into<String>, unit: LengthUnit) -> Self {
        Self(Kind::Mesh { file: Some(file.into()), files: None, unit })
    }

    /// Returns the inside of the closed surface that several files form together, in 3D.
    pub fn mesh_of<P: Into<String>>(files: impl IntoIterator<Item = P>, unit: LengthUnit) -> Self {
        let files = files.into_iter().map(P::into).collect();
        Self(Kind::Mesh { file: None, files: Some(files), unit })
    }

    /// Returns the inside of closed polylines, in 2D: path of their file and unit of its
    /// coordinates.
    pub fn outline(file: impl Into<String>, unit: LengthUnit) -> Self {
        Self(Kind::Outline { file: file.into(), unit })
    }

    /// Returns a circle, in 2D: centre and radius, m.
    pub fn circle(center: impl Into<Vector>, radius: impl Into<Number>) -> Self {
        Self(Kind::Circle { center: center.into(), radius: radius.into() })
    }

    /// Returns a sphere, in 3D: centre and radius, m.
    pub fn sphere(center: impl Into<Vector>, radius: impl Into<Number>) -> Self {
        Self(Kind::Sphere { center: center.into(), radius: radius.into() })
    }

    /// Returns a cylinder with flat ends, in 3D: middle of either end and radius, m.
    pub fn cylinder(from: impl Into<Vector>, to: impl Into<Vector>, radius: impl Into<Number>) -> Self {
        Self(Kind::Cylinder { from: from.into(), to: to.into(), radius: radius.into() })
    }

    /// Returns the polygon of these corners in order, m, in 2D.
    pub fn polygon(points: impl IntoIterator<Item = impl Into<Vector>>) -> Self {
        Self(Kind::Polygon { points: points.into_iter().map(Into::into).collect() })
    }

    /// Returns the polygon of corners (x, y) in order, m, extruded from one z to another, m, in 3D.
    pub fn extruded(
        points: impl IntoIterator<Item = impl Into<Vector>>,
        from: impl Into<Number>,
        to: impl Into<Number>,
    ) -> Self {
        let points = points.into_iter().map(Into::into).collect();
        Self(Kind::Extruded { points, from: from.into(), to: to.into() })
    }

    /// Returns a section swept along an arc, in 3D. Arguments: centre of the section at the
    /// beginning (m), direction of the pipe there, centre of the arc (m), angle (°).
    pub fn bend(
        start: impl Into<Vector>,
        direction: impl Into<Vector>,
        center: impl Into<Vector>,
        angle: impl Into<Number>,
        section: BendSection,
    ) -> Self {
        Self(Kind::Bend {
            start: start.into(),
            direction: direction.into(),
            center: center.into(),
            angle: angle.into(),
            section,
        })
    }

    /// Returns all that is in any of the shapes.
    pub fn union(shapes: impl IntoIterator<Item = Shape>) -> Self {
        Self(Kind::Union(shapes.into_iter().collect()))
    }

    /// Returns the intersection of all shapes.
    pub fn intersection(shapes: impl IntoIterator<Item = Shape>) -> Self {
        Self(Kind::Intersection(shapes.into_iter().collect()))
    }

    /// Returns the points in the first shape and in none of the others.
    pub fn difference(shapes: impl IntoIterator<Item = Shape>) -> Self {
        Self(Kind::Difference(shapes.into_iter().collect()))
    }

    /// Returns the shape moved by a vector, m.
    pub fn translated(self, by: impl Into<Vector>) -> Self {
        Self(Kind::Translated { by: by.into(), shape: Box::new(self) })
    }

    /// Returns the shape turned by an angle, degrees, about the origin, or by a [`Rotation`].
    pub fn rotated(self, rotation: impl Into<Rotation>) -> Self {
        let Rotation { angle, axis, about } = rotation.into();
        Self(Kind::Rotated { angle, axis, about, shape: Box::new(self) })
    }

    /// Returns the shape enlarged about the origin.
    pub fn scaled(self, factor: impl Into<Number>) -> Self {
        Self(Kind::Scaled { factor: factor.into(), shape: Box::new(self) })
    }
}

description! {
    /// A rotation about a point, in 2D, or an axis, in 3D.
    pub struct Rotation {
        /// Sets the angle, degrees, anticlockwise.
        angle: Number,
        /// Sets the axis in 3D, default z.
        axis: Vector,
        /// Sets a fixed point, m, default the origin.
        about: Vector,
    }
}

impl Rotation {
    /// Returns a rotation by an angle, degrees, anticlockwise.
    pub fn new(angle: impl Into<Number>) -> Self {
        Self::default().angle(angle)
    }
}

impl<N: Into<Number>> From<N> for Rotation {
    fn from(angle: N) -> Self {
        Self::new(angle)
    }
}

/// Section of a bend.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(transparent)]
#[must_use = "a description does nothing until it is part of a scene"]
pub struct BendSection(SectionKind);

#[derive(Clone, Debug, PartialEq, Serialize)]
enum SectionKind {
    Circular { radius: Number },
    Rectangular { width: Number, height: Number },
}

impl BendSection {
    /// Returns a circle of a radius, m.
    pub fn circular(radius: impl Into<Number>) -> Self {
        Self(SectionKind::Circular { radius: radius.into() })
    }

    /// Returns a rectangle: width along the arc's radius and height along the arc's axis, m.
    pub fn rectangular(width: impl Into<Number>, height: impl Into<Number>) -> Self {
        Self(SectionKind::Rectangular { width: width.into(), height: height.into() })
    }
}
