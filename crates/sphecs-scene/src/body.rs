//! Bodies: parts of the wall whose force and torque are written.

use glam::DVec3;

/// A part of the wall as a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Body {
    /// Name of the part.
    pub name: String,
    /// Index of the part.
    pub part: u16,
    /// Reference point of torques, m.
    pub about: DVec3,
    /// Reference that makes forces dimensionless; None: there are no coefficients.
    pub reference: Option<BodyReference>,
    /// Interval of the time mean and of the spectrum, s.
    pub mean: (f64, f64),
    /// True if means, amplitudes and spectrum are those of the running mean over five rows.
    pub five_point_mean: bool,
}

/// References of the coefficients c = F/(½ ρ0 u∞² A) and of the Strouhal number f L/u∞.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct BodyReference {
    /// u∞, m/s, > 0.
    pub velocity: f64,
    /// A, m² (m in 2D), > 0.
    pub area: f64,
    /// L, m, > 0.
    pub length: f64,
}

/// Interval at which the forces on bodies are written.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ForcesEvery {
    /// In every step. Take it for spectra and mean forces.
    #[default]
    Step,
    /// In the steps that begin with a row of the monitor. Take it for smaller files.
    Row,
}
