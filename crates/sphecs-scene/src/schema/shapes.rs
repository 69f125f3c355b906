//! Shapes of a scene file.

use serde::Deserialize;

use super::{Number, Text, Vector};
use crate::meshes::LengthUnit;
use crate::notation::typed::Spanned;

/// A region of space.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Shape"))]
pub enum ShapeFile {
    /// Axis-aligned rectangle or box. Take it for straight channels and ducts along an axis.
    Box {
        /// Lower corner, m.
        min: Vector,
        /// Upper corner, m.
        max: Vector,
    },
    /// Circle, in 2D. Take it for cylinders across a plane flow.
    Circle {
        /// Centre of the circle, m.
        center: Vector,
        /// Radius of the circle, m.
        radius: Number,
    },
    /// Sphere, in 3D. Take it for round obstacles and chambers.
    Sphere {
        /// Centre of the sphere, m.
        center: Vector,
        /// Radius of the sphere, m.
        radius: Number,
    },
    /// Cylinder with flat ends, in 3D. Take it for straight pipes.
    Cylinder {
        /// Middle of one end, m.
        from: Vector,
        /// Middle of the other end, m.
        to: Vector,
        /// Radius of the cylinder, m.
        radius: Number,
    },
    /// Polygon, in 2D. Take it for plane channels with inclined walls.
    Polygon {
        /// Corners in order, m.
        points: Spanned<Vec<Vector>>,
    },
    /// Polygon in x and y extruded along z, in 3D. Take it for ducts with a polygonal section.
    Extruded {
        /// Corners (x, y) in order, m.
        points: Spanned<Vec<Vector>>,
        /// Lower end along z, m.
        from: Number,
        /// Upper end along z, m.
        to: Number,
    },
    /// Closed surface of triangles from STL, OBJ or PLY files, in 3D. Take it for geometry from
    /// CAD.
    Mesh {
        /// File in the folder of the scene, default none.
        #[serde(default)]
        file: Option<Text>,
        /// Files whose facets together form the closed surface, default none; in place of `file`.
        #[serde(default)]
        files: Option<Vec<Text>>,
        /// Unit of the coordinates in the files.
        unit: Spanned<LengthUnit>,
    },
    /// Closed polylines from a text file of two columns x and y, in 2D: the inside of an odd number
    /// of them. Take it for wing sections and other curves of many points.
    Outline {
        /// File in the folder of the scene.
        file: Text,
        /// Unit of the coordinates in the file.
        unit: Spanned<LengthUnit>,
    },
    /// A section swept along an arc, in 3D. Take it for pipe and duct bends.
    Bend {
        /// Centre of the section at the beginning, m.
        start: Vector,
        /// Direction of the pipe at the beginning, dimensionless.
        direction: Vector,
        /// Centre of the arc, m.
        center: Vector,
        /// Angle turned through, degrees.
        angle: Number,
        /// Section of the pipe.
        section: BendSectionFile,
    },
    /// Union of the shapes of a list. Take it to join parts such as a pipe and its bend.
    Union(Spanned<Vec<ShapeFile>>),
    /// Intersection of the shapes of a list. Take it to cut a shape down to a region.
    Intersection(Spanned<Vec<ShapeFile>>),
    /// Difference: points in the first shape and in none of the others. Take it to cut an obstacle
    /// out of a channel.
    Difference(Spanned<Vec<ShapeFile>>),
    /// A shape moved by a vector. Take it to place a shape elsewhere.
    Translated {
        /// Displacement of the shape, m.
        by: Vector,
        /// Shape that is moved.
        shape: std::boxed::Box<ShapeFile>,
    },
    /// A shape rotated about a point, in 2D, or an axis, in 3D. Take it for a shape oblique to
    /// the axes.
    Rotated {
        /// Angle, degrees, anticlockwise.
        angle: Number,
        /// Axis in 3D, dimensionless, default z.
        #[serde(default)]
        axis: Option<Vector>,
        /// Fixed point of the rotation, m, default the origin.
        #[serde(default)]
        about: Option<Vector>,
        /// Shape that is rotated.
        shape: std::boxed::Box<ShapeFile>,
    },
    /// A shape scaled about the origin. Take it to change the size of a shape without changing its
    /// numbers.
    Scaled {
        /// Factor of all lengths, dimensionless.
        factor: Number,
        /// Shape that is scaled.
        shape: std::boxed::Box<ShapeFile>,
    },
}

/// Section of a bend.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "BendSection"))]
pub enum BendSectionFile {
    /// A pipe of circular section. Take it for pipes.
    Circular {
        /// Radius of the section, m.
        radius: Number,
    },
    /// A duct of rectangular section. Take it for ducts.
    Rectangular {
        /// Width along the radius of the arc, m.
        width: Number,
        /// Height along the axis of the arc, m.
        height: Number,
    },
}
