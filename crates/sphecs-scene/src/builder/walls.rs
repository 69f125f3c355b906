//! Walls and bodies of a scene description.

use serde::Serialize;

use super::description::description;
use super::moving_bodies::Motion;
use super::numbers::{Interval, Number, Vector, VectorFormula};
use super::regions::Shape;
use crate::rings::FirstRing;
use sphecs_core::physics::wall::{Slip, WallModel};

description! {
    /// The walls: everything at the domain's surface that is neither patch nor periodic.
    pub struct Walls {
        /// Sets the treatment of walls in the sums.
        model: WallModel,
        /// Sets the slip condition, default no slip.
        slip: Slip,
        /// Sets the surface velocity, m/s, default rest.
        velocity: VectorFormula,
        /// Sets the motion of all walls together but the movers, default rest.
        motion: Motion,
        /// Sets the arrangement of the particles behind the surface, default on the lattice of the
        /// fluid.
        fill: WallFill,
        /// Separates the fluid on the two sides of walls thinner than the support, if true, default
        /// false.
        one_sided: bool,
    } lists {
        /// Adds a part that differs from the rest.
        part -> parts: WallPart,
    }
}

impl Walls {
    /// Returns no-slip walls of images at rest.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// A part of the walls: the surface inside a region. The first part that claims a surface has
    /// it.
    pub struct WallPart {
        /// Sets the name for outputs and messages.
        name: String,
        /// Sets the region whose surface belongs to the part.
        region: Shape,
        /// Sets the slip condition, default that of the walls.
        slip: Slip,
        /// Sets the surface velocity, m/s, default rest.
        velocity: VectorFormula,
        /// Sets the arrangement of the particles behind the surface, default that of the walls.
        fill: WallFill,
    }
}

impl WallPart {
    /// Returns the part with a name for outputs and messages, inside a region.
    pub fn new(name: impl Into<String>, region: Shape) -> Self {
        Self::default().name(name).region(region)
    }
}

/// Arrangement of the particles of a wall part behind its surface.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum WallFill {
    /// In layers along a surface of any shape, a spacing apart.
    Layers,
    /// On rings in a cylinder, in 2D, a spacing apart.
    Concentric(Concentric),
}

impl From<Concentric> for WallFill {
    fn from(rings: Concentric) -> Self {
        Self::Concentric(rings)
    }
}

description! {
    /// Wall particles on rings in a cylinder, in 2D, a spacing apart.
    pub struct Concentric {
        /// Sets the centre of the cylinder, m.
        center: Vector,
        /// Sets the radius of the cylinder, m.
        radius: Number,
        /// Sets the place of the first ring, default half a spacing behind the surface.
        first: FirstRing,
    }
}

impl Concentric {
    /// Returns rings in the cylinder with a centre, m, and a radius, m.
    pub fn new(center: impl Into<Vector>, radius: impl Into<Number>) -> Self {
        Self::default().center(center).radius(radius)
    }
}

description! {
    /// A part of the walls whose force and torque are written into `forces.nc`.
    pub struct Body {
        /// Sets the name of the part among those of the walls; `walls` is the rest.
        part: String,
        /// Sets the point that torques are about, m, default the middle of the part's region.
        about: Vector,
        /// Sets the velocity u∞ of the coefficients, m/s; without velocity and area there are none.
        velocity: Number,
        /// Sets the area A of the coefficients, m²; in 2D the length, m, that it has per metre of
        /// depth, such as the diameter.
        area: Number,
        /// Sets the length of the Strouhal number, m, default in 2D the area.
        length: Number,
        /// Sets the interval of the time mean of the coefficients and of the lift's spectrum, s,
        /// default the second half of the run.
        mean: Interval,
        /// Takes means, amplitudes and spectrum of the coefficients' running mean over five rows if
        /// true, default false.
        five_point_mean: bool,
    }
}

impl Body {
    /// Returns the body that is a part of the walls; the part `walls` is the rest.
    pub fn new(part: impl Into<String>) -> Self {
        Self::default().part(part)
    }
}
