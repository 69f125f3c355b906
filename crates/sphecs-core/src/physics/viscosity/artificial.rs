//! Artificial viscosity of a particle pair.
//!
//! ```text
//! (dv_a/dt)_b = −m_b Π_ab ∇W,   Π_ab = −α c̄_ab μ_ab/ρ̄_ab where v_ab·x_ab < 0, else 0
//! μ_ab = h v_ab·x_ab/(r² + η²),   η² = 0.01 h²
//! ```
//!
//! Monaghan (1992), without the quadratic term. Acts on approaching pairs along their line, so it
//! conserves linear and angular momentum and never adds energy. The fluid's own ν does not act.

use serde::{Deserialize, Serialize};

use super::{ViscosityNeeds, ViscousMethod, ViscousTerms};
use crate::math::lanes::Lanes;
use crate::math::lattice::LatticeSums;
use crate::physics::eos;
use crate::physics::pair::PairDensities;
use crate::physics::parameter_fault::ParameterFault;

/// Parameter of the artificial viscosity.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Artificial {
    /// Strength α, dimensionless.
    pub alpha: f64,
}

impl ViscousMethod for Artificial {
    fn needs(&self) -> ViscosityNeeds {
        ViscosityNeeds::default()
    }

    fn pair_viscosity(&self, _viscosity: f64, _lattice: &LatticeSums) -> f64 {
        0.0
    }

    fn pair_terms(&self) -> ViscousTerms {
        ViscousTerms { artificial_alpha: self.alpha, ..ViscousTerms::default() }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let alpha = ParameterFault::unless_within(0.0..=f64::MAX, "alpha", self.alpha);
        alpha.map(|fault| fault.advise("`0.01` to `0.1` is usual")).into_iter().collect()
    }
}

/// Returns −Π_ab/α = (c_a + c_b)/(ρ_a + ρ_b) μ_ab over c0/ρ0³ for approaching pairs, to be
/// multiplied by α m ∇W.
///
/// `product` is v_ab·x_ab/h, m/s, with the image velocity in walls.
#[inline(always)]
pub fn pair_term<L: Lanes>(densities: &PairDensities<L>, product: L) -> L {
    let approach = product * densities.inverse_softened_q2;
    factor(eos::stiffness(densities.own, densities.own_square, densities.other), approach)
}

/// Returns −Π_ab/α from the stiffness (c_a + c_b)/(ρ_a + ρ_b), m⁴/(kg s), and from
/// `approach` = h v_ab·x_ab/(r² + η²), m/s.
#[inline(always)]
fn factor<L: Lanes>(stiffness: L, approach: L) -> L {
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
