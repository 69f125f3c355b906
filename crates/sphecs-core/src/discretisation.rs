//! Spacing, smoothing length, support and mass of the particles of a scene.
//!
//! ```text
//! h = (h/Δ) Δ,   support = κ h,   m = ρ0 Δ^D
//! ```
//!
//! Everybody who needs one of these lengths takes it from here: two products in different orders
//! may differ in their last bit, and results are compared bit by bit.

use crate::math::kernel::Kernel;

/// Lengths and mass that follow from kernel, spacing and smoothing ratio.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discretisation {
    /// Smoothing kernel.
    pub kernel: Kernel,
    /// 2 or 3.
    pub dimensions: usize,
    /// Smoothing ratio h/Δ.
    pub smoothing_ratio: f64,
    /// Initial particle spacing Δ, m.
    pub spacing: f64,
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Radius of the kernel's support κ h, m.
    pub support: f64,
    /// Mass m = ρ0 Δ^D of every particle, kg (per metre of depth in 2D).
    pub mass: f64,
}

impl Discretisation {
    /// Returns the discretisation of a fluid of a reference density (kg/m³) by particles of a
    /// spacing (m).
    pub fn new(
        kernel: Kernel,
        dimensions: usize,
        spacing: f64,
        smoothing_ratio: f64,
        reference_density: f64,
    ) -> Self {
        let smoothing_length = smoothing_ratio * spacing;
        Self {
            kernel,
            dimensions,
            smoothing_ratio,
            spacing,
            smoothing_length,
            support: kernel.support_ratio() * smoothing_length,
            mass: reference_density * spacing.powi(dimensions as i32),
        }
    }

    /// Returns the volume Δ^D of a particle on the initial lattice, m³ (m² in 2D).
    pub fn cell_volume(&self) -> f64 {
        self.spacing.powi(self.dimensions as i32)
    }

    /// Returns the edge of the grid cells with which the passes are fastest, m. It is the support
    /// in 2D, where a cell needs enough rows to amortise its pack. In 3D, where packs are culled,
    /// it is half the support.
    pub fn cell_size(&self) -> f64 {
        if self.dimensions == 2 { self.support } else { 0.5 * self.support }
    }

    /// Returns W(r) over its shape w(q): α_D/h^D, 1/m^D.
    pub fn kernel_scale(&self) -> f64 {
        self.kernel.norm(self.dimensions) / self.smoothing_length.powi(self.dimensions as i32)
    }

    /// Returns F(r) over its shape f(q), times h²: β α_D/h^D, 1/m^D. ∇W is this · f(q) ·
    /// (x_ab/h)/h.
    pub fn slope_scale(&self) -> f64 {
        self.kernel.slope_norm() * self.kernel_scale()
    }

    /// Returns the kernel W(r), 1/m^D.
    #[inline]
    pub fn w(&self, r: f64) -> f64 {
        self.kernel.value(self.dimensions, self.smoothing_length, r)
    }

    /// Returns F(r) = (dW/dr)/r, 1/m^(D+2).
    #[inline]
    pub fn f(&self, r: f64) -> f64 {
        self.kernel.slope(self.dimensions, self.smoothing_length, r)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_and_mass_follow_from_spacing_and_ratio() {
        let water = Discretisation::new(Kernel::QuinticSpline, 3, 1e-3, 1.2, 1000.0);
        assert_eq!(water.smoothing_length, 1.2 * 1e-3);
        assert_eq!(water.support, 3.0 * water.smoothing_length);
        assert_eq!(water.mass, 1000.0 * water.cell_volume());
    }
}
