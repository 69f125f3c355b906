//! Viscous terms of the momentum equation of `Wcsph`.
//!
//! One file per term holds its equation, parameters, requirements and pair term. To add one: a
//! file, a variant of [`Viscosity`] with its arm of `dispatch!`, and its entry in
//! docs/REFERENCES.md. A term that the pair loop does not have yet is added to [`ViscousTerms`].
//!
//! | file | term |
//! |---|---|
//! | [`laminar`] | laminar viscosity of the fluid |
//! | [`artificial`] | artificial viscosity in its place |
//! | [`sps`] | laminar viscosity and sub-particle-scale stress |
//! | [`reconstructed`] | damping of particle noise, in addition to any of them |

pub mod artificial;
pub mod laminar;
pub mod reconstructed;
pub mod sps;

use serde::{Deserialize, Serialize};

pub use artificial::Artificial;
pub use laminar::Laminar;
pub use sps::Sps;

use super::pair::{PairDensities, PairGeometry};
use super::parameter_fault::ParameterFault;
use crate::math::lanes::Lanes;
use crate::math::lattice::LatticeSums;

/// Parameters of the terms, for scenes that are described in Rust.
pub mod parameters {
    pub use super::reconstructed::NoiseDamping;
    pub use super::{Artificial, Laminar, Sps};
}

/// Viscous term of the momentum equation; the kinematic viscosity ν is the fluid's.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Viscosity {
    /// Laminar viscosity of Lo & Shao (2002). Take it for resolved flows.
    Laminar(Laminar),
    /// Artificial viscosity of Monaghan (1992) in place of the laminar term. Take it to compare
    /// with results that used it.
    Artificial(Artificial),
    /// The laminar term plus the sub-particle-scale stress of Alvarado-Rodríguez et al. (2017).
    /// Take it for turbulent flows.
    Sps(Sps),
}

/// Calls a method of [`ViscousMethod`] on the term of a [`Viscosity`].
macro_rules! dispatch {
    ($viscosity:expr, $method:ident($($argument:expr),*)) => {
        match $viscosity {
            Viscosity::Laminar(term) => term.$method($($argument),*),
            Viscosity::Artificial(term) => term.$method($($argument),*),
            Viscosity::Sps(term) => term.$method($($argument),*),
        }
    };
}

/// Requirements of a viscous term.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ViscosityNeeds {
    /// The fluid's kinematic viscosity acts and limits the time step.
    pub fluid_viscosity: bool,
    /// Velocity gradient and sub-particle-scale stress are found before the pair loop runs.
    pub stress: bool,
}

/// Terms of the pair loop beyond the laminar one; none by default.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ViscousTerms {
    /// α of the artificial viscosity, dimensionless; 0: none.
    pub artificial_alpha: f64,
    /// True if the laminar term has the published denominator r² + η².
    pub as_published: bool,
}

/// One viscous term: what its file says of it.
trait ViscousMethod {
    /// Returns what must be found before the pair loop runs.
    fn needs(&self) -> ViscosityNeeds;

    /// Returns ν of the laminar pair sum, m²/s, for a fluid of viscosity `viscosity`, m²/s.
    fn pair_viscosity(&self, viscosity: f64, lattice: &LatticeSums) -> f64;

    /// Returns the terms of the pair loop.
    fn pair_terms(&self) -> ViscousTerms;

    /// Returns the parameters that are out of bounds.
    fn faults(&self) -> Vec<ParameterFault>;

    /// Returns the model of the sub-particle-scale stress, if the term has one.
    fn stress_model(&self) -> Option<Sps> {
        None
    }
}

impl Viscosity {
    /// Returns what must be found before the pair loop runs.
    pub fn needs(&self) -> ViscosityNeeds {
        dispatch!(self, needs())
    }

    /// Returns ν of the laminar pair sum, m²/s: divided by its lattice coefficient where the scene
    /// asks for it, 0 where no laminar term acts. `viscosity` is the fluid's ν, m²/s.
    pub fn pair_viscosity(&self, viscosity: f64, lattice: &LatticeSums) -> f64 {
        dispatch!(self, pair_viscosity(viscosity, lattice))
    }

    /// Returns the terms of the pair loop beyond the laminar one.
    pub fn pair_terms(&self) -> ViscousTerms {
        dispatch!(self, pair_terms())
    }

    /// Returns the parameters that are out of bounds.
    pub fn faults(&self) -> Vec<ParameterFault> {
        dispatch!(self, faults())
    }

    /// Returns the model of the sub-particle-scale stress, if the term has one.
    pub fn stress_model(&self) -> Option<Sps> {
        dispatch!(self, stress_model())
    }
}

impl Default for Viscosity {
    fn default() -> Self {
        Viscosity::Laminar(Laminar::default())
    }
}

impl ViscousTerms {
    /// Returns the factor of 4 ν m v_ab of the laminar term.
    #[inline(always)]
    pub fn drag<L: Lanes, const D: usize>(
        &self,
        pair: &PairGeometry<L, D>,
        densities: &PairDensities<L>,
    ) -> L {
        if self.as_published {
            laminar::published_factor(pair, densities)
        } else {
            laminar::factor(pair.slope, densities.inverse_sum)
        }
    }
}

/// Value of a parameter that a scene leaves out.
fn yes() -> bool {
    true
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_out_of_bounds_are_named() {
        let faults = Viscosity::Artificial(Artificial { alpha: -0.1 }).faults();
        assert_eq!(faults.iter().map(|fault| fault.field).collect::<Vec<_>>(), ["alpha"]);
        let sps = Sps { smagorinsky: f64::NAN, isotropic: -1.0, ..Sps::default() };
        assert_eq!(Viscosity::Sps(sps).faults().len(), 2);
        assert!(Viscosity::default().faults().is_empty());
    }
}
