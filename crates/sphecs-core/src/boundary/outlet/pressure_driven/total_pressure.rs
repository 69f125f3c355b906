//! Total (stagnation) pressure of the reservoir beyond an opening.
//!
//! ```text
//! p_t = p_0(t)                       outflow
//! p_t = p_0(t) − ½ ρ0 v_n²           inflow, at each point of the section
//! ```
//!
//! Fluid that enters from a reservoir at rest has lost the dynamic pressure ½ ρ0 v_n² (Bernoulli);
//! fluid that leaves as a jet has the static pressure of the reservoir. The first makes a flow that
//! enters stable: Braack & Mucha (2014).

use serde::{Deserialize, Serialize};

use super::time_function::{Given, TimeFunction};
use super::{Acoustics, OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition: the pressure in one of three forms.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct TotalPressure {
    /// Pressure of the reservoir at rest, Pa: a number or an expression of t; default none.
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

impl TotalPressure {
    /// Returns a pressure of the reservoir, Pa: a number or an expression of t.
    pub fn new(value: impl Into<TimeFunction>) -> Self {
        Self { value: Some(value.into()), ..Self::default() }
    }
}

impl OutletParameters for TotalPressure {
    fn name(&self) -> &str {
        "TotalPressure"
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

impl PressureLaw for TotalPressure {
    type State = ();

    fn pressure(&self, opening: &OpeningFlow, _state: &mut ()) -> f64 {
        opening.given
    }

    fn acoustics(&self) -> Acoustics {
        self.acoustics
    }

    fn enters_from_rest(&self) -> bool {
        true
    }
}

#[cfg(test)]
mod tests {
    use super::super::opening_at;
    use super::*;
    use crate::boundary::outlet::convection::backflow_pressure;

    #[test]
    fn inflow_has_the_total_pressure_of_the_reservoir() {
        let law = TotalPressure::new(50.0);
        assert!(law.enters_from_rest());
        let reservoir = law.pressure(&opening_at(-0.2, 50.0), &mut ());
        let entering = backflow_pressure(reservoir, -0.2, 1000.0);
        assert!((entering + 0.5 * 1000.0 * 0.04 - 50.0).abs() < 1e-12, "{entering}");
        assert_eq!(backflow_pressure(reservoir, 0.2, 1000.0), 50.0);
    }
}
