//! Properties of the flow and of the domain that boundary conditions refer to.

use std::fmt;

use glam::DVec3;

/// Properties of the flow and of the domain.
#[derive(Clone, Copy)]
pub struct FlowProperties<'a> {
    /// 2 or 3.
    pub dimensions: usize,
    /// Initial particle spacing Δ, m.
    pub spacing: f64,
    /// Reference density ρ0, kg/m³.
    pub density: f64,
    /// Sound speed c0, m/s.
    pub sound_speed: f64,
    /// Kinematic viscosity ν, m²/s.
    pub viscosity: f64,
    /// Velocity for Reynolds and Mach numbers, m/s.
    pub reference_velocity: f64,
    /// For each axis, lower and upper bound of the periodic direction, m.
    pub periodic: [Option<(f64, f64)>; 3],
    /// Returns true if a point (m) lies in the domain, zones not included.
    pub is_in_domain: &'a (dyn Fn(DVec3) -> bool + Sync),
}

impl FlowProperties<'_> {
    /// Returns the acoustic impedance ρ0 c0, kg/(m² s).
    pub fn impedance(&self) -> f64 {
        self.density * self.sound_speed
    }
}

impl fmt::Debug for FlowProperties<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter
            .debug_struct("FlowProperties")
            .field("spacing", &self.spacing)
            .field("density", &self.density)
            .field("sound_speed", &self.sound_speed)
            .field("viscosity", &self.viscosity)
            .finish_non_exhaustive()
    }
}
