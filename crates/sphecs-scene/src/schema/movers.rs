//! Bodies that move, of a scene file.

use serde::Deserialize;

use super::{Formula, ShapeFile, Text, Vector, WallFillFile};
use crate::notation::typed::Spanned;
use sphecs_core::physics::wall::Slip;

/// A body with a prescribed motion, taken out of the domain.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Mover", deny_unknown_fields)]
pub struct MoverFile {
    /// Name for outputs and messages; `bodies` may name it.
    pub name: Text,
    /// Shape in its place without displacement.
    pub shape: Spanned<ShapeFile>,
    /// Prescribed motion of the body.
    pub motion: Spanned<MotionFile>,
    /// Slip condition, default that of the walls.
    #[serde(default)]
    pub slip: Option<Slip>,
    /// Arrangement of its particles behind the surface, default on the lattice of the fluid.
    #[serde(default)]
    pub fill: Option<Spanned<WallFillFile>>,
}

/// A prescribed motion: a function of time alone.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
#[cfg_attr(feature = "schema", schemars(rename = "Motion"))]
pub enum MotionFile {
    /// A motion without rotation; exactly one of its fields is given. Take it for pistons, gates
    /// and bodies that are towed or oscillate.
    Translation {
        /// Displacement, m, as expressions of t, default from the other fields.
        #[serde(default)]
        displacement: Option<Spanned<Vec<Formula>>>,
        /// Velocity, m/s, as expressions of t, default from the other fields; the displacement
        /// is 0 at t = 0.
        #[serde(default)]
        velocity: Option<Spanned<Vec<Formula>>>,
        /// CSV file in the folder of the scene with the columns time (s) and displacement (m)
        /// along x, y and in 3D z, default from the other fields. Between its rows it is a cubic
        /// spline, before the first and behind the last the body rests.
        #[serde(default)]
        file: Option<Text>,
    },
    /// A rotation about a point, in 3D about an axis; exactly one of `radians`, `rate` and `file`
    /// is given. Take it for stirrers, drums and flaps.
    Rotation {
        /// A point of the axis, m.
        about: Vector,
        /// Direction of the axis in 3D, dimensionless, default z. The rotation is anticlockwise
        /// seen against it.
        #[serde(default)]
        axis: Option<Vector>,
        /// Angle, rad, an expression of t, default from the other fields.
        #[serde(default)]
        radians: Option<Formula>,
        /// Angular velocity, rad/s, an expression of t, default from the other fields; the angle
        /// is 0 at t = 0.
        #[serde(default)]
        rate: Option<Formula>,
        /// CSV file in the folder of the scene with the columns time (s) and angle (rad), default
        /// from the other fields.
        #[serde(default)]
        file: Option<Text>,
    },
    /// Motions one after the other: each moves what those before it have moved, with axes that do
    /// not move themselves. Take it for a body that turns about an axis that moves.
    Chain(Spanned<Vec<MotionFile>>),
}
