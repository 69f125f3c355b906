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

use super::given_pressure::GivenPressure;
use super::time_function::{Given, TimeFunction};
use super::{Acoustics, OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Pressure of the reservoir at rest.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(inline))]
#[serde(transparent)]
pub struct TotalPressure(pub GivenPressure);

impl TotalPressure {
    /// Returns a pressure, Pa: a number or an expression of t.
    pub fn new(value: impl Into<TimeFunction>) -> Self {
        Self(GivenPressure::new(value))
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
        self.0.references()
    }

    fn given(&self) -> Option<Given<'_>> {
        Some(self.0.given())
    }

    fn faults(&self) -> Vec<ParameterFault> {
        self.0.faults()
    }
}

impl PressureLaw for TotalPressure {
    type State = ();

    fn pressure(&self, opening: &OpeningFlow, _state: &mut ()) -> f64 {
        opening.given
    }

    fn acoustics(&self) -> Acoustics {
        self.0.acoustics
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
