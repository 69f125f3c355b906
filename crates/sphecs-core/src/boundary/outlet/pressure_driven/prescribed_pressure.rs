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

use super::given_pressure::GivenPressure;
use super::time_function::{Given, TimeFunction};
use super::{Acoustics, OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Static pressure of the opening.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[cfg_attr(feature = "schema", schemars(inline))]
#[serde(transparent)]
pub struct Pressure(pub GivenPressure);

impl Pressure {
    /// Returns a pressure, Pa: a number or an expression of t.
    pub fn new(value: impl Into<TimeFunction>) -> Self {
        Self(GivenPressure::new(value))
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
        self.0.references()
    }

    fn given(&self) -> Option<Given<'_>> {
        Some(self.0.given())
    }

    fn faults(&self) -> Vec<ParameterFault> {
        self.0.faults()
    }
}

impl PressureLaw for Pressure {
    type State = ();

    fn pressure(&self, opening: &OpeningFlow, _state: &mut ()) -> f64 {
        opening.given
    }

    fn acoustics(&self) -> Acoustics {
        self.0.acoustics
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
