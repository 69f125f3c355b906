//! Laminar viscosity between two particles.
//!
//! ```text
//! (dv_a/dt)_b = 4 ν m_b v_ab/(ρ_a + ρ_b) F,   F = (dW/dr)/r ≤ 0
//! ```
//!
//! Lo & Shao (2002), as in Alvarado-Rodríguez et al. (2017), Eq. 10. Printed there with F r²/(r² + η²), η² = 0.01 h²:
//! that is the option `printed`, which loses 1 to 1.5 % of ν, since F is finite at r = 0 without it. Conserves linear
//! momentum exactly, angular momentum not.

use crate::math::lanes::Lanes;

/// F/(ρ_a + ρ_b), to be multiplied by 4 ν m v_ab; `slope` is F.
#[inline(always)]
pub fn factor<L: Lanes>(slope: L, inverse_density_sum: L) -> L {
    slope * inverse_density_sum
}

/// The same with the printed denominator: F q²/(q² + 0.01)/(ρ_a + ρ_b), q = r/h.
#[inline(always)]
pub fn printed_factor<L: Lanes>(slope: L, inverse_density_sum: L, q2: L, inverse_softened_q2: L) -> L {
    slope * inverse_density_sum * (q2 * inverse_softened_q2)
}
