//! Fluid and numerical scheme of a scene description.

use serde::Serialize;

use super::description::description;
use super::numbers::Number;
use sphecs_core::math::kernel::Kernel;
use sphecs_core::physics::integrator::Integrator;
use sphecs_core::physics::shifting::Shifting;
use sphecs_core::physics::viscosity::Viscosity;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;

description! {
    /// The fluid; all three properties are required.
    pub struct Fluid {
        /// Sets the reference density ρ0, kg/m³.
        density: Number,
        /// Sets the kinematic viscosity ν, m²/s.
        viscosity: Number,
        /// Sets the sound speed c0, m/s; at least ten times the largest speed of the flow.
        sound_speed: Number,
    }
}

impl Fluid {
    /// Returns a fluid whose properties are to be set.
    pub fn new() -> Self {
        Self::default()
    }
}

/// Numerical scheme: made of [`Wcsph`] or [`EdacTvf`].
#[derive(Clone, Debug, PartialEq, Serialize)]
pub enum Scheme {
    /// Weakly compressible SPH of Alvarado-Rodríguez et al. (2017).
    Wcsph(Wcsph),
    /// Evolved pressure and transport velocity of Negi et al. (2020).
    EdacTvf(EdacTvf),
}

impl From<Wcsph> for Scheme {
    fn from(scheme: Wcsph) -> Self {
        Self::Wcsph(scheme)
    }
}

impl From<EdacTvf> for Scheme {
    fn from(scheme: EdacTvf) -> Self {
        Self::EdacTvf(scheme)
    }
}

description! {
    /// Weakly compressible SPH of Alvarado-Rodríguez et al. (2017).
    pub struct Wcsph {
        /// Sets the smoothing kernel, default `WendlandC2`.
        kernel: Kernel,
        /// Sets h/Δ, default by kernel and dimensions.
        smoothing_ratio: Number,
        /// Sets the viscous term.
        viscosity: Viscosity,
        /// Sets the damping of single particles' noise, default `Off`.
        noise_damping: NoiseDamping,
        /// Sets the particle shifting.
        shifting: Shifting,
        /// Takes p_b − p_a in place of p_a + p_b where p_a < 0 if true, the default.
        tensile_control: bool,
        /// Sets the time integrator, default `KickDrift`.
        integrator: Integrator,
    }
}

impl Wcsph {
    /// Returns the scheme with its defaults.
    pub fn new() -> Self {
        Self::default()
    }
}

description! {
    /// Evolved pressure and transport velocity of Negi et al. (2020).
    pub struct EdacTvf {
        /// Sets the smoothing kernel, default `QuinticSpline`.
        kernel: Kernel,
        /// Sets h/Δ, default by kernel and dimensions.
        smoothing_ratio: Number,
        /// Sets α of the damping of the pressure, ν_edac = α h c0/8, default 0.5.
        alpha: Number,
        /// Sets the background pressure over ρ0 c0², default 1.
        background: Number,
        /// Subtracts the mean pressure of the neighbours if true, the default.
        average_pressure: bool,
        /// Divides ν and ν_edac by their lattice coefficient if true, the default.
        lattice_normalised: bool,
        /// Sets the rate at which the pressure approaches that of the summed density, over c0/h,
        /// default 0, as published.
        relaxation: Number,
        /// Uses the published η² = 0.01 h² in the denominator of the viscous sums if true, default
        /// false.
        as_published: bool,
    }
}

impl EdacTvf {
    /// Returns the scheme with its defaults.
    pub fn new() -> Self {
        Self::default()
    }
}
