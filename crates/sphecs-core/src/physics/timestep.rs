//! Size of a time step.
//!
//! ```text
//! Δt = min( C min_a √(h/|dv_a/dt|),  C min_a h/(c_a + max_b |h x_ab·v_ab/(r² + η²)|),
//!          C_ν h²/ν,  C_λ/max_a λ_a )
//! λ_a = Σ 4 ν m_b/(ρ_a + ρ_b) |F| (1 + d_b/d_a)
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eq. 18, with C = 0.3, or 0.5 under kick–drift–kick
//! ([`Integrator`]). Their text announces a viscous limit that the equation lacks. C_ν adds it,
//! 0.125 as for any explicit scheme. The limit by λ_a is sharper: λ_a is the rate at which the
//! viscous sum damps a particle among neighbours at rest. The leapfrog damps by 1 − 2 λ Δt in two
//! steps (`integrator/verlet.rs`), and C_λ = ½ keeps this positive. Shear that alternates from
//! particle to particle is damped at 1.06 to 1.36 λ (lattices in 2D and 3D, h from 1.33 to 2.2 Δ).
//! For this the leapfrog is stable up to λ Δt = 0.7, together with acoustic waves at C = 0.3.
//!
//! Under `Wcsph` the largest λ_a is that of particles with no wall in their support. The image
//! velocities of a no-slip wall damp the particles next to it several times as fast; the part that
//! a step does not resolve is treated implicitly ([`friction`]).
//!
//! Under `EdacTvf` the signal velocity is c_s + max |v|, C = 0.25 and the acceleration at least the
//! body force, as its authors describe it. For λ_a the larger of the damping rates of velocity and
//! pressure is taken, over all particles, with C_λ = 0.3. With C_λ = ½ a start at C = 1 diverges
//! (test `longest_allowed_time_steps_keep_all_values_finite`).
//!
//! [`friction`]: super::integrator::friction
//! [`Integrator`]: super::integrator::Integrator

/// Limits of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TimeStepLimits {
    /// Courant factor C.
    pub cfl: f64,
    /// Viscous factor C_ν.
    pub viscous: f64,
    /// Damping factor C_λ of the integrator.
    pub damping: f64,
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Largest kinematic viscosity, eddy viscosity included, m²/s.
    pub viscosity: f64,
}

impl TimeStepLimits {
    /// Returns the step size, s, for the largest |dv/dt|, m/s², the largest signal velocity c_a +
    /// max_b …, m/s, and the largest damping rate λ_a, 1/s.
    pub fn time_step(&self, largest_acceleration: f64, largest_signal: f64, largest_damping: f64) -> f64 {
        let h = self.smoothing_length;
        let force = self.cfl * (h / largest_acceleration.max(f64::MIN_POSITIVE)).sqrt();
        let sound = self.cfl * h / largest_signal;
        let viscous = self.viscous * h * h / self.viscosity.max(f64::MIN_POSITIVE);
        let damping = self.damping / largest_damping.max(f64::MIN_POSITIVE);
        force.min(sound).min(viscous).min(damping)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_smallest_limit_wins() {
        let limits = TimeStepLimits {
            cfl: 0.3,
            viscous: 0.0125,
            damping: 0.5,
            smoothing_length: 1e-3,
            viscosity: 1e-6,
        };
        assert!((limits.time_step(0.0, 4.0, 0.0) - 0.3e-3 / 4.0).abs() < 1e-18);
        assert!((limits.time_step(1e6, 4.0, 0.0) - 0.3 * 1e-9_f64.sqrt()).abs() < 1e-15);
        assert!((limits.time_step(0.0, 0.01, 1.0) - 0.0125).abs() < 1e-15);
        assert!((limits.time_step(0.0, 0.01, 1e4) - 5e-5).abs() < 1e-15);
    }
}
