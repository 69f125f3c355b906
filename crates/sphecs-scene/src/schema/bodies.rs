//! Bodies of a scene file.

use serde::Deserialize;

use super::{Number, Text, Vector};
use crate::notation::typed::Spanned;

/// A part of the walls whose force and torque are written into `forces.nc`.
#[derive(Clone, Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Body", deny_unknown_fields)]
pub struct BodyFile {
    /// Name of a part of the walls; `"walls"` is the remaining surface.
    pub part: Text,
    /// Reference point of torques, m, default the centre of the region of the part.
    #[serde(default)]
    pub about: Option<Vector>,
    /// Velocity u∞ of the coefficients of drag and lift, m/s, default none; without velocity and
    /// area no coefficients are written.
    #[serde(default)]
    pub velocity: Option<Number>,
    /// Area A of the coefficients, m², default none. In 2D it is the area per metre of depth in m,
    /// such as the diameter.
    #[serde(default)]
    pub area: Option<Number>,
    /// Length of the Strouhal number, m, default `area` in 2D, required in 3D with a velocity and
    /// an area.
    #[serde(default)]
    pub length: Option<Number>,
    /// Interval of the time mean of the coefficients and of the lift's spectrum, s, default the
    /// second half of the run.
    #[serde(default)]
    pub mean: Option<Spanned<(Number, Number)>>,
    /// True if means, amplitudes and spectrum are those of the running mean over five rows, default
    /// false.
    #[serde(default)]
    pub five_point_mean: bool,
}
