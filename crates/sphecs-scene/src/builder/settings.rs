//! Filling, initial fields, reservoir, time and references of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::{Formula, Number, Vector, VectorFormula};
use crate::model::WhenEmpty;

/// Arrangement of the fluid particles: made of [`Lattice`], [`Packed`] or
/// [`WallFitted`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Fill {
    /// A square or cubic lattice.
    Lattice(Lattice),
    /// A lattice relaxed onto the walls.
    Packed(Packed),
    /// Rows that follow the walls of a slanted or curved channel along x, in 2D.
    WallFitted(WallFitted),
}

impl From<Lattice> for Fill {
    fn from(lattice: Lattice) -> Self {
        Self::Lattice(lattice)
    }
}

impl From<Packed> for Fill {
    fn from(packed: Packed) -> Self {
        Self::Packed(packed)
    }
}

impl From<WallFitted> for Fill {
    fn from(rows: WallFitted) -> Self {
        Self::WallFitted(rows)
    }
}

description! {
    /// A square or cubic lattice of fluid particles.
    pub struct Lattice {
        /// Sets the angle by which its axes are turned anticlockwise from those of the scene,
        /// degrees; default that of the walls where one angle serves them.
        angle: Number,
        /// Sets the axis of the rotation in 3D, default z.
        axis: Vector,
        /// Sets a corner at which cells of the lattice meet, m; default chosen so that walls lie
        /// between cells.
        anchor: Vector,
        /// Sets the largest displacement of fluid particles from the lattice at the start, over the
        /// spacing, along each axis; reproducible. Default 0, at most 0.2.
        jitter: Number,
    }
}

impl Lattice {
    /// Returns a lattice with cells between the walls.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// A lattice relaxed onto the walls, with layers of wall particles along all of them.
    pub struct Packed {
        /// Sets the angle by which the axes of the lattice in the midst of the fluid are turned
        /// anticlockwise from those of the scene, degrees; default that of the walls where one
        /// angle serves them.
        angle: Number,
        /// Sets the axis of the rotation in 3D, default z.
        axis: Vector,
        /// Sets a corner at which cells of the lattice meet, m; default chosen so that walls lie
        /// between cells.
        anchor: Vector,
    }
}

impl Packed {
    /// Returns a lattice with cells between the walls, relaxed onto those it does not fit.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// Rows that follow the walls of a slanted or curved channel along x, in 2D.
    pub struct WallFitted {
        /// Sets y of the lower wall as a function of x, m.
        lower: Formula,
        /// Sets y of the upper wall as a function of x, m.
        upper: Formula,
    }
}

impl WallFitted {
    /// Returns rows between y of the lower and of the upper wall as functions of x, m.
    pub fn new(lower: impl Into<Formula>, upper: impl Into<Formula>) -> Self {
        Self::default().lower(lower).upper(upper)
    }
}

description! {
    /// Fields at t = 0, default rest.
    pub struct Initial {
        /// Sets the velocity, m/s.
        velocity: VectorFormula,
        /// Sets the pressure, Pa. That of the fluid has no effect: its density is summed before the
        /// first step, and its pressure follows from it. Outflow particles begin with it.
        pressure: Formula,
        /// Sets the passive tag.
        tag: Formula,
    }
}

impl Initial {
    /// Returns a fluid at rest.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// Particles stored for the inlets.
    pub struct Reservoir {
        /// Sets the number of particles, default as many as the inflow zones hold.
        particles: Number,
        /// Sets the action when there are none.
        when_empty: WhenEmpty,
        /// Stores particles that leave and injects them again if true, the default; with false they
        /// are deleted and new ones created, with the free numbers.
        recycle: bool,
    }
}

impl Reservoir {
    /// Returns a reservoir with its defaults.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// End and time step.
    pub struct Time {
        /// Sets the end of the run, s.
        end: Number,
        /// Sets the Courant factor, default 0.5, with `Verlet` 0.3, of `EdacTvf` 0.25.
        cfl: Number,
        /// Sets the viscous factor: Δt ≤ factor h²/ν, default 0.125.
        viscous: Number,
    }
}

impl Time {
    /// Returns a run until a time, s.
    pub fn until(end: impl Into<Number>) -> Self {
        Self::default().end(end)
    }
}

description! {
    /// Velocity and length of the Reynolds number, default estimated.
    pub struct Reference {
        /// Sets the velocity, m/s.
        velocity: Number,
        /// Sets the length, m.
        length: Number,
    }
}

impl Reference {
    /// Returns references that are to be set.
    pub fn new() -> Self {
        Self::default()
    }
}
