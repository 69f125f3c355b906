//! Pair terms of `EdacTvf`: an evolved pressure and a transport velocity.
//!
//! ```text
//! V_a     = S0/Σ W,   ρ_a = m/V_a,   S_ab = V_a² + V_b²
//! dv_a/dt = (1/m) Σ S_ab [−p̃_ab ∇W + ½ (A_a + A_b)·∇W + η̃_ab v_ab F]
//! p̃_ab    = (ρ_b p_a + ρ_a p_b)/(ρ_a + ρ_b) − p̄_a,
//! A = ρ v ⊗ w,   η̃_ab = 2 ν ρ_a ρ_b/(ρ_a + ρ_b)
//! dp_a/dt = ρ_a c_s² Σ V_b v_ab·∇W + (1/m) Σ S_ab η̃ᵉ_ab (p_a − p_b) F
//!           + (r c_s/h) [c_s² (ρ_a − ρ0) − p_a],
//!           ν_edac = α h c_s/8 in η̃ᵉ,   r = 0 by default
//! dx_a/dt = v_a + w_a,   w_a = −Δt (p_b/m) Σ S_ab ∇W,   F = (dW/dr)/r ≤ 0
//! ```
//!
//! Negi et al. (2020), Eqs. 3, 4, 6–11; p̄_a is the mean pressure of all particles in the support,
//! p_b the background pressure. Deviations from the paper:
//!
//! * The last term of the pressure's equation is our own, the option `relaxation`. Without it the
//!   volumes drift: the pressure follows the divergence of v, but the particles move with v + w. In
//!   a strained flow their distances grow by 3 % (docs/book/src/theory/edac.md). An acoustic wave
//!   keeps p = c_s² (ρ − ρ0), so the term does not act on it. The difference decays at the rate r
//!   c_s/h.
//! * As p̄_a is the same for all pairs of a particle, Σ S p̃ ∇W = Σ S p_ab ∇W − p̄_a Σ S ∇W. The
//!   last sum is also that of the transport velocity, so the mean pressure needs no extra pass. The
//!   loop sums differences to p_a: in single precision the pressures themselves would cancel. The
//!   particle's own half of the stress, ρ_a v_a (w_a·Σ S ∇W)/2, comes from the same sum.
//! * The published viscous factor F r²/(r² + η²), η² = 0.01 h², is the option `as_published`: F is
//!   finite at r = 0 without it.
//! * ν and ν_edac are divided by the lattice coefficient of the viscous sum (`math/lattice.rs`).
//!   The quintic spline at h = 1.2 Δ returns 0.9994 ν in 2D, and 0.9917 ν with the published
//!   factor.
//! * The divergence takes the velocity of the wall itself, as in Adami et al. (2012), not of its
//!   image. The image factor 1 + d_b/d_a is 30 for a particle 0.1 Δ from a wall, and here the
//!   divergence drives the pressure. With the factor the fluid of `scenes/quickstart.ron` thinned
//!   by 20 % within a second at its smoke spacing.
//! * The volumes are divided by the lattice sum S0, which Wendland's kernel needs: without it
//!   forces at h = 1.3 Δ are 2 % off. For the quintic spline at 1.2 Δ the difference is 6e-5.

use serde::{Deserialize, Serialize};

use crate::math::lanes::Lanes;

/// Parameters of the pressure equation, of the transport velocity and of the viscous term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Edac {
    /// α of the damping of the pressure, ν_edac = α h c_s/8, dimensionless.
    pub alpha: f64,
    /// Background pressure p_b over ρ0 c_s², dimensionless.
    pub background: f64,
    /// True if the mean pressure of the neighbours is subtracted.
    pub average_pressure: bool,
    /// True if ν and ν_edac are divided by their lattice coefficient.
    pub lattice_normalised: bool,
    /// r, the rate at which the pressure relaxes to that of the summed density, over c_s/h,
    /// dimensionless; 0 as published.
    pub relaxation: f64,
    /// True if the viscous sums have the published η² = 0.01 h² in the denominator.
    pub as_published: bool,
}

impl Default for Edac {
    fn default() -> Self {
        Self {
            alpha: 0.5,
            background: 1.0,
            average_pressure: true,
            lattice_normalised: true,
            relaxation: 0.0,
            as_published: false,
        }
    }
}

impl Edac {
    /// Largest α of a scene: with it the diffusion of the pressure limits the time step as much as
    /// the speed of sound.
    pub const LARGEST_ALPHA: f64 = 4.0;

    /// Largest background pressure of a scene over ρ0 c_s². The drift is a diffusion of the
    /// particles: with Δt = 0.25 h/c_s it reaches its limit of stability at ten times ρ0 c_s².
    pub const LARGEST_BACKGROUND: f64 = 10.0;

    /// Largest background pressure over ρ0 c_s² times the Courant factor, by the same limit.
    pub const LARGEST_BACKGROUND_STEP: f64 = 0.25 * Self::LARGEST_BACKGROUND;

    /// Largest rate of relaxation of a scene over c_s/h: with it the pressure is that of `Wcsph`,
    /// except for waves shorter than the support.
    pub const LARGEST_RELAXATION: f64 = 1.0;

    /// Returns ν_edac, m²/s, for a smoothing length, m, and a sound speed, m/s.
    pub fn pressure_viscosity(&self, smoothing_length: f64, sound_speed: f64) -> f64 {
        self.alpha * smoothing_length * sound_speed / 8.0
    }

    /// Returns (r c_s/h) [c_s² (ρ − ρ0) − p], Pa/s, for a smoothing length, m, a sound speed, m/s,
    /// the density minus ρ0, kg/m³, and the pressure, Pa.
    pub fn relaxing(&self, smoothing_length: f64, sound_speed: f64, excess: f64, pressure: f64) -> f64 {
        self.relaxation * sound_speed / smoothing_length * (sound_speed * sound_speed * excess - pressure)
    }
}

/// Returns (V_a² + V_b²)/m² times the slope of the kernel, from V_a²/m² and V_b/m.
#[inline(always)]
pub fn weight<L: Lanes>(own_square: L, volume: L, slope: L) -> L {
    volume.mul_add(volume, own_square) * slope
}

/// Returns (p_ab − p_a)/ρ_a = (p_b − p_a)/(ρ_a + ρ_b) times the weight; `shared` is the weight over
/// ρ_a + ρ_b.
#[inline(always)]
pub fn pressure_term<L: Lanes>(shared: L, difference: L) -> L {
    shared * difference
}

/// Returns η̃_ab/(2 ν ρ_a) times the weight; `shared` is the weight over ρ_a + ρ_b.
#[inline(always)]
pub fn viscous_term<L: Lanes>(shared: L, density: L) -> L {
    shared * density
}

/// Returns ρ_b (w_b·x_ab) times the weight, to be multiplied by v_b: the neighbour's half of the
/// stress.
#[inline(always)]
pub fn transport_term<L: Lanes>(weight: L, density: L, drift_along: L) -> L {
    weight * density * drift_along
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    #[test]
    fn pair_terms_are_the_printed_ones() {
        let (rho_a, rho_b, p_a, p_b) = (990.0, 1020.0, 70.0, -30.0);
        let one = |x: f64| Array([x]);
        let shared = 1.0 / (rho_a + rho_b);
        let printed = (rho_b * p_a + rho_a * p_b) / (rho_a + rho_b) - p_a;
        let found = rho_a * pressure_term(one(shared), one(p_b - p_a)).0[0];
        assert!((found - printed).abs() < 1e-12 * printed.abs());
        let (eta_a, eta_b) = (2e-3 * rho_a, 2e-3 * rho_b);
        let printed = 2.0 * eta_a * eta_b / (eta_a + eta_b);
        let found = 2.0 * 2e-3 * rho_a * viscous_term(one(shared), one(rho_b)).0[0];
        assert!((found - printed).abs() < 1e-12 * printed);
        assert_eq!(weight(one(4.0), one(3.0), one(-0.5)).0[0], -6.5);
        assert_eq!(transport_term(one(2.0), one(3.0), one(5.0)).0[0], 30.0);
    }

    #[test]
    fn pressure_is_damped_as_printed() {
        assert_eq!(Edac::default().pressure_viscosity(0.12, 10.0), 0.5 * 0.12 * 10.0 / 8.0);
    }
}
