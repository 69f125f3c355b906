//! Pressure that a scene gives at an opening in time.

use serde::{Deserialize, Serialize};

use super::Acoustics;
use super::time_function::{Given, TimeFunction};
use crate::boundary::outlet::method::References;
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of a condition of given pressure: the pressure in one of three forms. They have one
/// name in a scene whichever condition they belong to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename = "Pressure", deny_unknown_fields)]
pub struct GivenPressure {
    /// Pressure, Pa: a number or an expression of t; default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub value: Option<TimeFunction>,
    /// Rows of time and pressure, linear between rows, s and Pa, default none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rows: Option<Vec<(f64, f64)>>,
    /// CSV file in the folder of the scene with the columns time (s) and pressure (Pa), default
    /// none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub file: Option<String>,
    /// Acoustic waves at the opening, default `Transmitted`.
    #[serde(default)]
    pub acoustics: Acoustics,
}

impl GivenPressure {
    /// Returns a pressure, Pa: a number or an expression of t.
    pub fn new(value: impl Into<TimeFunction>) -> Self {
        Self { value: Some(value.into()), ..Self::default() }
    }

    /// Returns the pressure if it is constant; 0 otherwise.
    pub(super) fn references(&self) -> References {
        match self.value {
            Some(TimeFunction::Number(pressure)) => References { velocity: 0.0, pressure },
            _ => References::default(),
        }
    }

    /// Returns the forms in which the pressure is given.
    pub(super) fn given(&self) -> Given<'_> {
        Given { value: self.value.as_ref(), rows: self.rows.as_deref(), file: self.file.as_deref() }
    }

    /// Returns the parameters that are out of range.
    pub(super) fn faults(&self) -> Vec<ParameterFault> {
        self.given().faults("Pa")
    }
}
