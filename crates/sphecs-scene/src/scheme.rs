//! Numerical schemes of a checked scene.

use sphecs_core::discretisation::Discretisation;
use sphecs_core::math::kernel::Kernel;
use sphecs_core::physics::edac::Edac;
use sphecs_core::physics::integrator::Integrator;
use sphecs_core::physics::shifting::Shifting;
use sphecs_core::physics::viscosity::Viscosity;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;

/// The numerical scheme.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scheme {
    /// Density by summation, pressure by Tait: Alvarado-Rodríguez et al. (2017).
    Wcsph(Wcsph),
    /// Evolved pressure and transport velocity: Negi et al. (2020).
    EdacTvf(EdacTvf),
}

/// Parameters of the scheme of Alvarado-Rodríguez et al. (2017).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wcsph {
    /// Smoothing kernel.
    pub kernel: Kernel,
    /// h/Δ, > 0.
    pub smoothing_ratio: f64,
    /// Viscous term.
    pub viscosity: Viscosity,
    /// Damping of the noise of single particles.
    pub noise_damping: NoiseDamping,
    /// Particle shifting.
    pub shifting: Shifting,
    /// p_b − p_a in place of p_a + p_b where p_a < 0.
    pub tensile_control: bool,
    /// Time integrator.
    pub integrator: Integrator,
}

/// Parameters of the scheme of Negi et al. (2020).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EdacTvf {
    /// Smoothing kernel.
    pub kernel: Kernel,
    /// h/Δ, > 0.
    pub smoothing_ratio: f64,
    /// Pressure equation, background pressure and viscous term.
    pub terms: Edac,
}

impl Scheme {
    /// Smoothing kernel.
    pub fn kernel(&self) -> Kernel {
        match self {
            Scheme::Wcsph(scheme) => scheme.kernel,
            Scheme::EdacTvf(scheme) => scheme.kernel,
        }
    }

    /// h/Δ, > 0.
    pub fn smoothing_ratio(&self) -> f64 {
        match self {
            Scheme::Wcsph(scheme) => scheme.smoothing_ratio,
            Scheme::EdacTvf(scheme) => scheme.smoothing_ratio,
        }
    }

    /// Returns the reach of inlets, outlets and their zones for particles of a spacing, m: the
    /// support, as (κ h/Δ) Δ.
    ///
    /// `Discretisation::support` is κ (h/Δ Δ), which may differ in its last bit.
    pub fn support(&self, spacing: f64) -> f64 {
        self.kernel().support_ratio() * self.smoothing_ratio() * spacing
    }

    /// Returns the discretisation by particles of a spacing (m) of a fluid of a density (kg/m³).
    pub fn discretisation(&self, dimensions: usize, spacing: f64, density: f64) -> Discretisation {
        Discretisation::new(self.kernel(), dimensions, spacing, self.smoothing_ratio(), density)
    }

    /// The parameters of `Wcsph`, if it is the scheme.
    pub fn wcsph(&self) -> Option<&Wcsph> {
        match self {
            Scheme::Wcsph(scheme) => Some(scheme),
            Scheme::EdacTvf(_) => None,
        }
    }

    /// Returns true if particles carry a sub-particle stress.
    pub fn has_stress(&self) -> bool {
        self.wcsph().is_some_and(|scheme| scheme.viscosity.needs().stress)
    }

    /// Returns true if the fluid's kinematic viscosity ν acts; an artificial viscosity takes its
    /// place.
    pub fn is_viscous(&self) -> bool {
        self.wcsph().is_none_or(|scheme| scheme.viscosity.needs().fluid_viscosity)
    }
}
