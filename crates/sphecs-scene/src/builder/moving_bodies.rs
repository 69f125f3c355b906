//! Bodies that move, of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::{Formula, Vector, VectorFormula};
use super::regions::Shape;
use super::walls::WallFill;
use sphecs_core::physics::wall::Slip;

description! {
    /// A body with a prescribed motion, taken out of the domain.
    pub struct Mover {
        /// Sets the name for outputs and messages.
        name: String,
        /// Sets the shape in its place without displacement.
        shape: Shape,
        /// Sets the motion.
        motion: Motion,
        /// Sets the slip condition, default that of the walls.
        slip: Slip,
        /// Sets the arrangement of its particles behind the surface, default on the lattice of the
        /// fluid.
        fill: WallFill,
    }
}

impl Mover {
    /// Returns the body with a name, a shape and a motion.
    pub fn new(name: impl Into<String>, shape: Shape, motion: impl Into<Motion>) -> Self {
        Self::default().name(name).shape(shape).motion(motion)
    }
}

/// A prescribed motion: a function of time alone.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Motion {
    /// A motion without rotation.
    Translation(Translation),
    /// A rotation about a point, in 3D about an axis.
    Rotation(Turning),
    /// Motions one after the other: each moves what those before it have moved.
    Chain(Vec<Motion>),
}

impl Motion {
    /// Returns motions one after the other.
    pub fn chain(motions: impl IntoIterator<Item = Motion>) -> Self {
        Self::Chain(motions.into_iter().collect())
    }
}

impl From<Translation> for Motion {
    fn from(translation: Translation) -> Self {
        Self::Translation(translation)
    }
}

impl From<Turning> for Motion {
    fn from(turning: Turning) -> Self {
        Self::Rotation(turning)
    }
}

description! {
    /// A motion without rotation, given in one of the ways.
    pub struct Translation {
        /// Sets the displacement, m.
        displacement: VectorFormula,
        /// Sets the velocity, m/s; the displacement is 0 at t = 0.
        velocity: VectorFormula,
        /// Sets the CSV file with the columns time (s) and displacement (m) along the axes.
        file: String,
    }
}

impl Translation {
    /// Returns the motion by a displacement, m.
    pub fn by(displacement: impl Into<VectorFormula>) -> Self {
        Self::default().displacement(displacement)
    }

    /// Returns the motion with a velocity, m/s.
    pub fn with_velocity(velocity: impl Into<VectorFormula>) -> Self {
        Self::default().velocity(velocity)
    }
}

description! {
    /// A rotation about a point, in 3D about an axis, given in one of the ways.
    pub struct Turning {
        /// Sets a point of the axis, m.
        about: Vector,
        /// Sets the direction of the axis in 3D, default z.
        axis: Vector,
        /// Sets the angle, rad.
        radians: Formula,
        /// Sets the angular velocity, rad/s; the angle is 0 at t = 0.
        rate: Formula,
        /// Sets the CSV file with the columns time (s) and angle (rad).
        file: String,
    }
}

impl Turning {
    /// Returns the rotation about a point, m, with an angular velocity, rad/s.
    pub fn at_rate(about: impl Into<Vector>, rate: impl Into<Formula>) -> Self {
        Self::default().about(about).rate(rate)
    }

    /// Returns the rotation about a point, m, by an angle, rad.
    pub fn by(about: impl Into<Vector>, radians: impl Into<Formula>) -> Self {
        Self::default().about(about).radians(radians)
    }
}
