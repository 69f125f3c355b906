//! Laminar viscosity of a particle pair.
//!
//! ```text
//! (dv_a/dt)_b = 4 ν m_b v_ab/(ρ_a + ρ_b) F,   F = (dW/dr)/r ≤ 0
//! ```
//!
//! Lo & Shao (2002), as in Alvarado-Rodríguez et al. (2017), Eq. 10. The published form has F
//! r²/(r² + η²), η² = 0.01 h². That is the option `as_published`, which loses 1 to 1.5 % of ν; F is
//! finite at r = 0 without it. Conserves linear momentum exactly, angular momentum not.

use serde::{Deserialize, Serialize};

use super::{ViscosityNeeds, ViscousMethod, ViscousTerms, yes};
use crate::math::lanes::Lanes;
use crate::math::lattice::LatticeSums;
use crate::physics::pair::{PairDensities, PairGeometry};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the laminar term.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Laminar {
    /// True if ν is divided by its lattice coefficient, so that the sum returns ν on the initial
    /// lattice, default true.
    #[serde(default = "yes")]
    pub lattice_normalised: bool,
    /// True for the denominator with η² = 0.01 h² of Alvarado-Rodríguez et al. (2017), Eq. 10,
    /// default false.
    #[serde(default)]
    pub as_published: bool,
}

impl Default for Laminar {
    fn default() -> Self {
        Self { lattice_normalised: true, as_published: false }
    }
}

impl ViscousMethod for Laminar {
    fn needs(&self) -> ViscosityNeeds {
        ViscosityNeeds { fluid_viscosity: true, stress: false }
    }

    fn pair_viscosity(&self, viscosity: f64, lattice: &LatticeSums) -> f64 {
        match (self.lattice_normalised, self.as_published) {
            (true, true) => viscosity / lattice.viscosity_printed,
            (true, false) => viscosity / lattice.viscosity,
            (false, _) => viscosity,
        }
    }

    fn pair_terms(&self) -> ViscousTerms {
        ViscousTerms { as_published: self.as_published, ..ViscousTerms::default() }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        Vec::new()
    }
}

/// Returns F/(ρ_a + ρ_b), to be multiplied by 4 ν m v_ab; `slope` is F.
#[inline(always)]
pub fn factor<L: Lanes>(slope: L, inverse_density_sum: L) -> L {
    slope * inverse_density_sum
}

/// Returns the factor with the published denominator: F q²/(q² + 0.01)/(ρ_a + ρ_b), q = r/h.
#[inline(always)]
pub fn published_factor<L: Lanes, const D: usize>(
    pair: &PairGeometry<L, D>,
    densities: &PairDensities<L>,
) -> L {
    pair.slope * densities.inverse_sum * (pair.q2 * densities.inverse_softened_q2)
}
