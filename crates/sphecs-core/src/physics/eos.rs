//! Tait's equation of state.
//!
//! ```text
//! p = p0 [(ρ/ρ0)^γ − 1],   p0 = c0² ρ0/γ,   c = c0 (ρ/ρ0)^((γ−1)/2)
//! ```
//!
//! Monaghan (1994), as in Alvarado-Rodríguez et al. (2017), Eq. 4, with γ = 7.

use crate::math::lanes::Lanes;

/// The exponent γ of water in Tait's equation.
pub const GAMMA: f64 = 7.0;

/// Parameters of Tait's equation.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tait {
    /// Reference density ρ0, kg/m³.
    pub reference_density: f64,
    /// Sound speed c0 at the reference density, m/s.
    pub sound_speed: f64,
}

impl Tait {
    /// Pressure scale p0 = c0² ρ0/γ, Pa.
    #[inline(always)]
    pub fn pressure_scale(&self) -> f64 {
        self.sound_speed * self.sound_speed * self.reference_density / GAMMA
    }

    /// Pressure at a density, Pa.
    #[inline(always)]
    pub fn pressure(&self, density: f64) -> f64 {
        let ratio = density / self.reference_density;
        let cube = ratio * ratio * ratio;
        self.pressure_scale() * (cube * cube * ratio - 1.0)
    }

    /// Density at a pressure, kg/m³: the inverse of [`Self::pressure`]. Pressures below −p0 have
    /// none and are treated as 0.99 p0 of tension.
    pub fn density(&self, pressure: f64) -> f64 {
        let argument = (1.0 + pressure / self.pressure_scale()).max(0.01);
        self.reference_density * argument.powf(1.0 / GAMMA)
    }

    /// Sound speed at a density, m/s.
    pub fn sound_speed_at(&self, density: f64) -> f64 {
        let ratio = density / self.reference_density;
        self.sound_speed * ratio * ratio * ratio
    }
}

/// (c_a + c_b)/(ρ_a + ρ_b) over c0/ρ0³, kg²/m⁶: (ρ_a³ + ρ_b³)/(ρ_a + ρ_b) = ρ_a² + ρ_b (ρ_b − ρ_a),
/// which takes no division. `square_a` is ρ_a².
#[inline(always)]
pub fn stiffness<L: Lanes>(rho_a: L, square_a: L, rho_b: L) -> L {
    rho_b.mul_add(rho_b - rho_a, square_a)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WATER: Tait = Tait { reference_density: 1000.0, sound_speed: 4.0 };

    #[test]
    fn density_inverts_pressure() {
        for density in [970.0, 999.999, 1000.0, 1012.5] {
            let back = WATER.density(WATER.pressure(density));
            assert!((back - density).abs() < 1e-9, "{density} became {back}");
        }
    }

    #[test]
    fn stiffness_is_the_sum_of_sound_speeds_over_that_of_densities() {
        use crate::math::lanes::Array;
        for (rho_a, rho_b) in [(1000.0, 1000.0), (1012.0, 987.0), (700.0, 1300.0)] {
            let speeds = WATER.sound_speed_at(rho_a) + WATER.sound_speed_at(rho_b);
            let Array([found]) = stiffness(Array([rho_a]), Array([rho_a * rho_a]), Array([rho_b]));
            let found = found * WATER.sound_speed / WATER.reference_density.powi(3);
            assert!((found * (rho_a + rho_b) / speeds - 1.0).abs() < 1e-14, "{rho_a} and {rho_b} kg/m³");
        }
    }

    #[test]
    fn slope_at_reference_is_sound_speed_squared() {
        let step = 1e-3;
        let slope = (WATER.pressure(1000.0 + step) - WATER.pressure(1000.0 - step)) / (2.0 * step);
        assert!((slope - 16.0).abs() < 1e-6, "dp/dρ = {slope}");
        let c = WATER.sound_speed_at(1010.0);
        let slope = (WATER.pressure(1010.0 + step) - WATER.pressure(1010.0 - step)) / (2.0 * step);
        assert!((slope - c * c).abs() < 1e-6 * slope, "dp/dρ = {slope}, c² = {}", c * c);
    }
}
