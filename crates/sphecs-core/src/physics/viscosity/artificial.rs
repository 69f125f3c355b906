//! Monaghan's artificial viscosity between two particles.
//!
//! ```text
//! (dv_a/dt)_b = −m_b Π_ab ∇W,   Π_ab = −α c̄_ab μ_ab/ρ̄_ab where v_ab·x_ab < 0, else 0
//! μ_ab = h v_ab·x_ab/(r² + η²),   η² = 0.01 h²
//! ```
//!
//! Monaghan (1992), without the quadratic term. Acts on approaching pairs along their line, so it conserves linear and
//! angular momentum and never adds energy.

use crate::math::lanes::Lanes;

/// −Π_ab/α = (c_a + c_b)/(ρ_a + ρ_b) μ_ab for approaching pairs, to be multiplied by α m ∇W.
///
/// `stiffness` is (c_a + c_b)/(ρ_a + ρ_b), m⁴/(kg s); `approach` is h v_ab·x_ab/(r² + η²), m/s.
#[inline(always)]
pub fn factor<L: Lanes>(stiffness: L, approach: L) -> L {
    stiffness * approach.min(L::constant(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    #[test]
    fn only_approaching_pairs_are_damped() {
        let damping = |approach: f64| factor(Array([8.0 / 2000.0]), Array([approach])).0[0];
        assert_eq!(damping(0.5), 0.0);
        assert_eq!(damping(0.0), 0.0);
        // Times α m ∇W, which points towards the neighbour: a push away from it.
        assert_eq!(damping(-0.5), -0.002);
    }
}
