//! Fields of the fluid at a point of space.

use glam::DVec3;

/// Fields of the fluid at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sample {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Density, kg/m³.
    pub density: f64,
}
