//! Resistance of the conduits beyond an opening.
//!
//! ```text
//! p_t = p_d + R Q
//! ```
//!
//! Q is the volume flow out of the domain, p_d the pressure at the far end of the conduits. Long
//! narrow vessels without elasticity or inertia: Vignon-Clementel et al. (2006), Sec. 2.2.

use serde::{Deserialize, Serialize};

use super::{OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Resistance {
    /// Resistance R of a volume flow, Pa s/m³, in 2D Pa s/m²; at least 0.
    pub resistance: f64,
    /// Pressure p_d beyond the resistance, Pa, default 0.
    #[serde(default)]
    pub distal_pressure: f64,
}

impl OutletParameters for Resistance {
    fn name(&self) -> &str {
        "Resistance"
    }

    fn needs(&self) -> Needs {
        super::needs()
    }

    fn references(&self) -> References {
        References { velocity: 0.0, pressure: self.distal_pressure }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let resistance = super::unless_not_negative("resistance", self.resistance, "Pa s/m³");
        let pressure = ParameterFault::unless_finite("distal_pressure", self.distal_pressure, "Pa");
        resistance.into_iter().chain(pressure).collect()
    }
}

impl PressureLaw for Resistance {
    type State = ();

    fn pressure(&self, opening: &OpeningFlow, _state: &mut ()) -> f64 {
        self.distal_pressure + self.resistance * opening.rate()
    }
}

#[cfg(test)]
mod tests {
    use super::super::opening_at;
    use super::*;

    #[test]
    fn pressure_rises_with_the_flow_out_of_the_domain() {
        let law = Resistance { resistance: 2e4, distal_pressure: 5.0 };
        // Q = 0.01 m² × 0.1 m/s.
        assert!((law.pressure(&opening_at(0.1, 0.0), &mut ()) - 25.0).abs() < 1e-12);
        assert!((law.pressure(&opening_at(-0.1, 0.0), &mut ()) + 15.0).abs() < 1e-12);
        assert_eq!(law.faults(), []);
        assert_eq!(Resistance { resistance: -1.0, distal_pressure: f64::NAN }.faults().len(), 2);
    }
}
