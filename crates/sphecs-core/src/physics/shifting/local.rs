//! Shifting down the concentration gradient, with the particle's own speed.
//!
//! ```text
//! δx_a = −A h |v_a| Δt ∇C_a,   v_a → v_a + δx_a·∇v
//! ```
//!
//! Skillen et al. (2013). ∇C and its drift correction: [`concentration`]. For flows with fast and
//! slow regions: slow ones are not disturbed by the shift that fast ones need.

use serde::{Deserialize, Serialize};

use super::concentration::{self, DriftCorrection, smaller};
use super::{ShiftStep, ShiftingMethod, ShiftingNeeds};

/// Parameters of the method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Local {
    /// Strength A, dimensionless.
    #[serde(default = "usual_coefficient")]
    pub coefficient: f64,
    /// Treatment of the part that neighbours share.
    #[serde(default)]
    pub drift_correction: DriftCorrection,
}

fn usual_coefficient() -> f64 {
    32.0
}

impl Default for Local {
    fn default() -> Self {
        Self { coefficient: usual_coefficient(), drift_correction: DriftCorrection::Off }
    }
}

impl ShiftingMethod for Local {
    fn strength(&self) -> f64 {
        self.coefficient
    }

    fn strength_field(&self) -> &'static str {
        "coefficient"
    }

    fn needs(&self) -> ShiftingNeeds {
        let concentration_gradient = self.drift_correction == DriftCorrection::On;
        ShiftingNeeds { velocity_gradient: true, concentration_gradient, ..ShiftingNeeds::default() }
    }

    #[inline(always)]
    fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep) {
        for scale in squared_speeds {
            let speed = smaller(scale.sqrt(), step.largest_speed);
            *scale = concentration::scale(self.coefficient, speed, step);
        }
    }
}
