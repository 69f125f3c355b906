//! Viscous terms: the door lists the rooms and holds the closed choice.

pub mod artificial;
pub mod laminar;
pub mod reconstructed;

use serde::{Deserialize, Serialize};

/// The viscous term of the momentum equation. The kinematic viscosity ν is the fluid's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Viscosity {
    /// Lo & Shao (2002): `4 ν m_b v_ab/(ρ_a + ρ_b) F`.
    Laminar {
        /// Divide ν by its lattice coefficient, so that the sum returns ν on the initial lattice.
        #[serde(default = "yes")]
        lattice_normalised: bool,
        /// With the η² = 0.01 h² that Alvarado-Rodríguez et al. (2017), Eq. 10, print in the denominator.
        #[serde(default)]
        printed: bool,
    },
    /// Monaghan (1992) artificial viscosity in place of the laminar term.
    Artificial {
        /// Strength α, dimensionless.
        alpha: f64,
    },
    /// The laminar term plus the sub-particle stress of Alvarado-Rodríguez et al. (2017), Eqs. 7 and 8.
    Sps {
        /// Smagorinsky constant C_s, dimensionless.
        #[serde(default = "smagorinsky")]
        smagorinsky: f64,
        /// Constant C_I of the isotropic part, dimensionless.
        #[serde(default = "isotropic")]
        isotropic: f64,
        /// As for `Laminar`.
        #[serde(default = "yes")]
        lattice_normalised: bool,
    },
}

fn yes() -> bool {
    true
}

fn smagorinsky() -> f64 {
    0.12
}

fn isotropic() -> f64 {
    0.0066
}

impl Default for Viscosity {
    fn default() -> Self {
        Viscosity::Laminar { lattice_normalised: true, printed: false }
    }
}
