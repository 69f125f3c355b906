//! Shifting down the concentration gradient, with the largest speed of the fluid.
//!
//! ```text
//! δx_a = −A h v_max Δt ∇C_a
//! ```
//!
//! Lind et al. (2012). ∇C and its drift correction: [`concentration`].

use serde::{Deserialize, Serialize};

use super::concentration::{self, DriftCorrection};
use super::{ShiftStep, ShiftingMethod, ShiftingNeeds};

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Fickian {
    /// Strength A, dimensionless.
    #[serde(default = "usual_coefficient")]
    pub coefficient: f64,
    /// Treatment of the part that neighbours share.
    #[serde(default)]
    pub drift_correction: DriftCorrection,
}

fn usual_coefficient() -> f64 {
    4.0
}

impl Default for Fickian {
    fn default() -> Self {
        Self { coefficient: usual_coefficient(), drift_correction: DriftCorrection::Off }
    }
}

impl ShiftingMethod for Fickian {
    fn strength(&self) -> f64 {
        self.coefficient
    }

    fn strength_field(&self) -> &'static str {
        "coefficient"
    }

    fn needs(&self) -> ShiftingNeeds {
        let concentration_gradient = self.drift_correction == DriftCorrection::On;
        ShiftingNeeds { concentration_gradient, ..ShiftingNeeds::default() }
    }

    #[inline(always)]
    fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep) {
        squared_speeds.fill(concentration::scale(self.coefficient, step.largest_speed, step));
    }
}
