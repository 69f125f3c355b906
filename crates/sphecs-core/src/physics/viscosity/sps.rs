//! Laminar viscosity and sub-particle-scale stress of a particle pair.
//!
//! ```text
//! S_ij = ½ (∂v_i/∂x_j + ∂v_j/∂x_i),   |S| = √(2 S_ij S_ij),   ν_t = (C_s Δ)² |S|
//! T_ij = ρ (2 ν_t S_ij − ⅔ ν_t S_kk δ_ij) − ⅔ ρ C_I Δ² |S|² δ_ij
//! dv_a/dt = Σ_b m_b (T_a/ρ_a² + T_b/ρ_b²) · ∇W,   in addition to the laminar term
//! ```
//!
//! These are Eqs. 7, 8 and 10 of Alvarado-Rodríguez et al. (2017) with the misprints corrected.
//! There S_ij has a minus sign, and C_I is 0.00066 for 0.0066. The factor ν_t is missing in the
//! second term of T and |S|² in the third, without which the units are wrong. The third term only
//! shifts the pressure.

use serde::{Deserialize, Serialize};

use super::{ViscosityNeeds, ViscousMethod, ViscousTerms, yes};
use crate::math::lanes::Lanes;
use crate::math::lattice::LatticeSums;
use crate::math::symmetric::{self, component};
use crate::physics::parameter_fault::ParameterFault;

/// Constants of the model.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Sps {
    /// Smagorinsky constant C_s, dimensionless.
    #[serde(default = "usual_smagorinsky")]
    pub smagorinsky: f64,
    /// Constant C_I of the isotropic part, dimensionless.
    #[serde(default = "usual_isotropic")]
    pub isotropic: f64,
    /// True if ν is divided by its lattice coefficient, so that the sum returns ν on the initial
    /// lattice, default true.
    #[serde(default = "yes")]
    pub lattice_normalised: bool,
}

fn usual_smagorinsky() -> f64 {
    0.12
}

fn usual_isotropic() -> f64 {
    0.0066
}

impl Default for Sps {
    fn default() -> Self {
        Self { smagorinsky: usual_smagorinsky(), isotropic: usual_isotropic(), lattice_normalised: true }
    }
}

impl ViscousMethod for Sps {
    fn needs(&self) -> ViscosityNeeds {
        ViscosityNeeds { fluid_viscosity: true, stress: true }
    }

    fn pair_viscosity(&self, viscosity: f64, lattice: &LatticeSums) -> f64 {
        if self.lattice_normalised { viscosity / lattice.viscosity } else { viscosity }
    }

    fn pair_terms(&self) -> ViscousTerms {
        ViscousTerms::default()
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let smagorinsky = ParameterFault::unless_within(0.0..=f64::MAX, "smagorinsky", self.smagorinsky);
        let isotropic = ParameterFault::unless_within(0.0..=f64::MAX, "isotropic", self.isotropic);
        [
            smagorinsky.map(|fault| fault.advise("`0.12` is usual")),
            isotropic.map(|fault| fault.advise("`0.0066` is usual")),
        ]
        .into_iter()
        .flatten()
        .collect()
    }

    fn stress_model(&self) -> Option<Sps> {
        Some(*self)
    }
}

impl Sps {
    /// Returns T/ρ², m⁵/(kg s²), by component (the rest of the six is zero), and ν_t, m²/s.
    ///
    /// `gradient[i][j]` is ∂v_i/∂x_j, 1/s; `density` is in kg/m³; `spacing`, the filter width Δ,
    /// is in m.
    pub fn stress<const D: usize>(
        &self,
        gradient: [[f64; D]; D],
        density: f64,
        spacing: f64,
    ) -> ([f64; 6], f64) {
        let strain = |i: usize, j: usize| 0.5 * (gradient[i][j] + gradient[j][i]);
        let mut square = 0.0;
        let mut trace = 0.0;
        for i in 0..D {
            trace += strain(i, i);
            for j in 0..D {
                square += strain(i, j) * strain(i, j);
            }
        }
        let square = 2.0 * square;
        let eddy = (self.smagorinsky * spacing).powi(2) * square.sqrt();
        let isotropic = 2.0 / 3.0 * (eddy * trace + self.isotropic * spacing.powi(2) * square);
        let mut stress = [0.0; 6];
        for i in 0..D {
            for j in 0..=i {
                let diagonal = if i == j { isotropic } else { 0.0 };
                stress[component::<D>(i, j)] = (2.0 * eddy * strain(i, j) - diagonal) / density;
            }
        }
        (stress, eddy)
    }
}

/// Returns (T_a/ρ_a² + T_b/ρ_b²)·x_ab/h, to be multiplied by m F h, of the stresses over ρ² of
/// both particles.
#[inline(always)]
pub fn pair_term<L: Lanes, const D: usize>(own: [L; 6], other: [L; 6], x: [L; D]) -> [L; D] {
    symmetric::product(symmetric::sum::<L, D>(own, other), x)
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: Sps = Sps { smagorinsky: 0.12, isotropic: 0.0066, lattice_normalised: true };
    const SPACING: f64 = 0.01;

    #[test]
    fn plane_shear_has_the_smagorinsky_stress() {
        let shear = 30.0;
        let (stress, eddy) = MODEL.stress([[0.0, shear], [0.0, 0.0]], 1000.0, SPACING);
        let expected = (0.12f64 * 0.01).powi(2) * shear;
        assert!((eddy - expected).abs() < 1e-15);
        assert!((stress[2] - expected * shear / 1000.0).abs() < 1e-15);
        let isotropic = -2.0 / 3.0 * 0.0066 * 1e-4 * shear * shear / 1000.0;
        assert!((stress[0] - isotropic).abs() < 1e-15 && (stress[1] - isotropic).abs() < 1e-15);
    }

    #[test]
    fn solid_rotation_has_no_stress() {
        let (stress, eddy) =
            MODEL.stress([[0.0, -2.0, 1.0], [2.0, 0.0, 3.0], [-1.0, -3.0, 0.0]], 998.0, SPACING);
        assert_eq!((stress, eddy), ([0.0; 6], 0.0));
    }
}
