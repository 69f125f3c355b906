//! Static pressure at an opening.
//!
//! ```text
//! p_t = p_given(t)
//! ```
//!
//! The pressure of the sections of a long pipe at both ends of the domain. Fluid that enters
//! keeps the static pressure, so that a flow which a reservoir at rest supplies takes
//! [`total_pressure`](super::total_pressure) instead.

use serde::{Deserialize, Serialize};

use super::time_function::{Given, TimeFunction};
use super::{Acoustics, OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition: the pressure in one of three forms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Pressure {
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

impl Pressure {
    /// Returns a pressure, Pa: a number or an expression of t.
    pub fn new(value: impl Into<TimeFunction>) -> Self {
        Self { value: Some(value.into()), ..Self::default() }
    }
}

impl OutletParameters for Pressure {
    fn name(&self) -> &str {
        "Pressure"
    }

    fn needs(&self) -> Needs {
        super::needs()
    }

    fn references(&self) -> References {
        match self.value {
            Some(TimeFunction::Number(pressure)) => References { velocity: 0.0, pressure },
            _ => References::default(),
        }
    }

    fn given(&self) -> Option<Given<'_>> {
        Some(Given { value: self.value.as_ref(), rows: self.rows.as_deref(), file: self.file.as_deref() })
    }

    fn faults(&self) -> Vec<ParameterFault> {
        self.given().map_or(Vec::new(), |given| given.faults("Pa"))
    }
}

impl PressureLaw for Pressure {
    type State = ();

    fn pressure(&self, opening: &OpeningFlow, _state: &mut ()) -> f64 {
        opening.given
    }

    fn acoustics(&self) -> Acoustics {
        self.acoustics
    }
}

#[cfg(test)]
mod tests {
    use super::super::opening_at;
    use super::*;

    #[test]
    fn the_pressure_is_the_given_one_whatever_the_flow() {
        for velocity in [-0.3, 0.0, 0.3] {
            assert_eq!(Pressure::new(4.0).pressure(&opening_at(velocity, 4.0), &mut ()), 4.0);
        }
    }
}
