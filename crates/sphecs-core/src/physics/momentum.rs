//! Pressure force of a particle pair.
//!
//! ```text
//! dv_a/dt = −(1/ρ_a) Σ_b V_b (p_a + p_b) ∇W
//! ```
//!
//! Colagrossi & Landrini (2003), as in Alvarado-Rodríguez et al. (2017), Eq. 10. Conserves linear
//! and angular momentum exactly.
//!
//! Tensile control, Sun et al. (2018): where p_a < 0 and the support is full, p_b − p_a takes the
//! place of p_a + p_b. The two differ by 2 p_a Σ V_b ∇W, which vanishes for an even distribution,
//! but in tension makes an uneven one clump. Conserves momentum only as far as the distribution is
//! even.

use crate::math::lanes::Lanes;

/// Density over ρ0 above which the support of a particle counts as full.
const FULL_SUPPORT: f64 = 0.95;

/// Returns the pressure that a particle adds to that of each neighbour, Pa: p_a, or −p_a under
/// tensile control.
#[inline(always)]
pub fn own_pressure(pressure: f64, density: f64, reference_density: f64, tensile_control: bool) -> f64 {
    if tensile_control && pressure < 0.0 && density >= FULL_SUPPORT * reference_density {
        -pressure
    } else {
        pressure
    }
}

/// Returns V_b (p_a + p_b), to be multiplied by −∇W/ρ_a; N m^(2 − D) per neighbour.
#[inline(always)]
pub fn pressure_term<L: Lanes>(own: L, other: L, volume: L) -> L {
    (own + other) * volume
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tension_changes_sign_where_the_support_is_full() {
        assert_eq!(own_pressure(-50.0, 990.0, 1000.0, true), 50.0);
        assert_eq!(own_pressure(-50.0, 940.0, 1000.0, true), -50.0);
        assert_eq!(own_pressure(-50.0, 990.0, 1000.0, false), -50.0);
        assert_eq!(own_pressure(50.0, 990.0, 1000.0, true), 50.0);
    }
}
