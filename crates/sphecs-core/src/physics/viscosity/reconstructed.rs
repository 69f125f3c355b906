//! Damping of particle noise: artificial viscosity of the relative velocity that a linear flow does
//! not explain.
//!
//! ```text
//! (dv_a/dt)_b = −m_b Π_ab ∇W,   Π_ab = −α c̄_ab h w_ab/((r² + η²) ρ̄_ab),   η² = 0.01 h²
//! w_ab = v_ab·x_ab − ½ x_ab·(S_a + S_b)·x_ab,   S = ½ (∇v + ∇vᵀ)
//! ```
//!
//! The form of Monaghan (1992) with the velocities of both particles extrapolated to the middle of
//! the pair along their gradients: Frontiere et al. (2017); Rosswog (2020). Only the symmetric
//! part of ∇v enters w_ab. Here the term acts on receding pairs as on approaching ones, without a
//! limiter: there are no shocks to capture.
//!
//! At a cell Reynolds number u Δ/ν of 100 the viscosity of water does not damp the velocity that
//! disordered neighbours give a particle. This noise accumulates to a tenth of the flow's velocity,
//! mixes momentum like an eddy viscosity of 10 ν and smears every jet and boundary layer. A
//! viscosity that damps it within a shear time would be 50 ν; this term has it for the noise and,
//! by construction, none for a linear flow. It acts along the line of a pair and is antisymmetric:
//! linear and angular momentum are conserved. Pairs with walls are not damped.

use serde::{Deserialize, Serialize};

use crate::math::lanes::{Lanes, dot};
use crate::math::symmetric;
use crate::physics::eos;
use crate::physics::pair::{PairDensities, PairGeometry};
use crate::physics::parameter_fault::ParameterFault;

/// Damping of the velocities that single particles have in addition to the flow's.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum NoiseDamping {
    /// No damping. Take it for flows whose own viscosity dominates at the size of a particle.
    #[default]
    Off,
    /// Artificial viscosity between linearly reconstructed velocities. Take it for jets and shear
    /// layers.
    Reconstructed {
        /// Strength α, dimensionless, from 0 to 0.5.
        #[serde(default = "usual_strength")]
        alpha: f64,
    },
}

fn usual_strength() -> f64 {
    0.2
}

impl NoiseDamping {
    /// Largest α whose damping rate, 1.75 α c0/h, the acoustic limit of the time step covers.
    pub const LARGEST_ALPHA: f64 = 0.5;

    /// Returns α, 0 where it is off.
    pub fn alpha(self) -> f64 {
        match self {
            NoiseDamping::Off => 0.0,
            NoiseDamping::Reconstructed { alpha } => alpha,
        }
    }

    /// Returns the parameters that are out of bounds.
    pub fn faults(self) -> Vec<ParameterFault> {
        let alpha = ParameterFault::unless_within(0.0..=Self::LARGEST_ALPHA, "alpha", self.alpha());
        alpha.map(|fault| fault.advise("`0.05` to `0.3` is usual")).into_iter().collect()
    }
}

/// Returns −Π_ab/α over c0/ρ0³, to be multiplied by α m ∇W.
///
/// `own` and `other` are the rates of strain of both particles, 1/s, by component
/// ([`symmetric::component`]); `product` is x_ab·v_ab/h, m/s; `h` is in m.
#[inline(always)]
pub fn pair_term<L: Lanes, const D: usize>(
    pair: &PairGeometry<L, D>,
    densities: &PairDensities<L>,
    [own, other]: [[L; 6]; 2],
    product: L,
    h: f64,
) -> L {
    let strain_sum = symmetric::sum::<L, D>(own, other);
    let approach = unexplained(product, strain_sum, pair.x, h) * densities.inverse_softened_q2;
    factor(eos::stiffness(densities.own, densities.own_square, densities.other), approach)
}

/// Returns w_ab/h, m/s: `x` is x_ab/h, `product` is x_ab·v_ab/h (m/s), `strain_sum` the
/// components of S_a + S_b (1/s).
#[inline(always)]
fn unexplained<L: Lanes, const D: usize>(product: L, strain_sum: [L; 6], x: [L; D], h: f64) -> L {
    dot(symmetric::product(strain_sum, x), x).mul_add(L::constant(-0.5 * h), product)
}

/// Returns −Π_ab/α = (c_a + c_b) h w_ab/((r² + η²)(ρ_a + ρ_b)). The stiffness is (c_a + c_b)/(ρ_a +
/// ρ_b), m⁴/(kg s), and `approach` is h w_ab/(r² + η²), m/s.
#[inline(always)]
fn factor<L: Lanes>(stiffness: L, approach: L) -> L {
    stiffness * approach
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::lanes::Array;

    #[test]
    fn a_linear_flow_is_not_damped_and_the_rest_is() {
        let (x, h) = ([0.6, -0.8], 0.25);
        // v = G x with G = [[2, -1], [4, 0.5]]: its rotation does not show.
        let velocity = |x: [f64; 2]| [h * (2.0 * x[0] - x[1]), h * (4.0 * x[0] + 0.5 * x[1])];
        let strain = [2.0, 0.5, 1.5, 0.0, 0.0, 0.0].map(|s| Array([2.0 * s]));
        let left = |v: [f64; 2]| {
            unexplained(Array([x[0] * v[0] + x[1] * v[1]]), strain, x.map(|x| Array([x])), h).0[0]
        };
        let [u, v] = velocity(x);
        assert!(left([u, v]).abs() < 1e-15);
        assert!((left([u + 3.0, v - 1.0]) - (0.6 * 3.0 + 0.8)).abs() < 1e-14);
    }

    #[test]
    fn receding_pairs_are_damped_like_approaching_ones() {
        let damping = |approach: f64| factor(Array([8.0 / 2000.0]), Array([approach])).0[0];
        assert_eq!(damping(-0.5), -0.002);
        assert_eq!(damping(0.5), 0.002);
    }
}
