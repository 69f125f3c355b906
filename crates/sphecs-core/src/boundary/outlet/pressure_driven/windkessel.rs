//! Three-element Windkessel model of the vessels beyond an opening.
//!
//! ```text
//! p_t = p_c + R_p Q
//! C dp_c/dt = Q − (p_c − p_d)/R_d
//! ```
//!
//! Westerhof et al. (2009), Sec. 2: R_p is the proximal (characteristic) resistance, C the
//! compliance and R_d the distal (peripheral) resistance of the vessels, p_c the pressure in them
//! and p_d that behind them. Q is the volume flow out of the domain. The equation is integrated
//! exactly over a step in which Q is constant:
//!
//! ```text
//! p_c(t + Δt) = p_∞ + (p_c(t) − p_∞) exp(−Δt/(R_d C)),   p_∞ = p_d + R_d Q
//! ```

use serde::{Deserialize, Serialize};

use super::{OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters, References};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Windkessel {
    /// Proximal resistance R_p, Pa s/m³, in 2D Pa s/m²; at least 0.
    pub proximal: f64,
    /// Compliance C, m³/Pa, in 2D m²/Pa; greater than 0.
    pub compliance: f64,
    /// Distal resistance R_d, Pa s/m³, in 2D Pa s/m²; greater than 0.
    pub distal: f64,
    /// Pressure p_d behind the vessels, Pa, default 0.
    #[serde(default)]
    pub distal_pressure: f64,
    /// Pressure p_c in the vessels at the start, Pa, default that behind them.
    #[serde(default)]
    pub initial: Option<f64>,
}

/// Pressure p_c in the vessels, Pa; None before the first step.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct VesselPressure(pub Option<f64>);

impl OutletParameters for Windkessel {
    fn name(&self) -> &str {
        "Windkessel"
    }

    fn needs(&self) -> Needs {
        super::needs()
    }

    fn references(&self) -> References {
        References { velocity: 0.0, pressure: self.initial.unwrap_or(self.distal_pressure) }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let proximal = super::unless_not_negative("proximal", self.proximal, "Pa s/m³");
        let positive = [("compliance", self.compliance, "m³/Pa"), ("distal", self.distal, "Pa s/m³")];
        let positive = positive
            .into_iter()
            .filter_map(|(field, value, unit)| ParameterFault::unless_positive(field, value, unit));
        let pressure = ParameterFault::unless_finite("distal_pressure", self.distal_pressure, "Pa");
        let initial =
            self.initial.and_then(|initial| ParameterFault::unless_finite("initial", initial, "Pa"));
        proximal.into_iter().chain(positive).chain(pressure).chain(initial).collect()
    }
}

impl PressureLaw for Windkessel {
    type State = VesselPressure;

    fn pressure(&self, opening: &OpeningFlow, state: &mut VesselPressure) -> f64 {
        let rate = opening.rate();
        let before = state.0.unwrap_or(self.initial.unwrap_or(self.distal_pressure));
        let steady = self.distal_pressure + self.distal * rate;
        let fade = -(-opening.time_step / (self.distal * self.compliance)).exp_m1();
        let vessels = before + fade * (steady - before);
        state.0 = Some(vessels);
        vessels + self.proximal * rate
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OpeningFlow, opening_at};
    use super::*;

    const LAW: Windkessel =
        Windkessel { proximal: 1e4, compliance: 2e-6, distal: 5e4, distal_pressure: 3.0, initial: None };

    #[test]
    fn a_constant_flow_charges_the_vessels_exponentially() {
        let (mut state, opening) = (VesselPressure::default(), opening_at(0.1, 0.0));
        let mut pressure = 0.0;
        for _ in 0..200 {
            pressure = LAW.pressure(&opening, &mut state);
        }
        // Q = 1e-3 m³/s, R_d C = 0.1 s, t = 0.2 s.
        let exact = 3.0 + 50.0 * (1.0 - (-2.0f64).exp()) + 10.0;
        assert!((pressure - exact).abs() < 1e-9, "{pressure}, not {exact}");
    }

    #[test]
    fn the_result_does_not_depend_on_the_time_step() {
        let run = |steps: u32| {
            let mut state = VesselPressure::default();
            let opening = OpeningFlow { time_step: 0.05 / f64::from(steps), ..opening_at(0.1, 0.0) };
            (0..steps).fold(0.0, |_, _| LAW.pressure(&opening, &mut state))
        };
        assert!((run(1) - run(100)).abs() < 1e-9);
    }

    #[test]
    fn parameters_out_of_range_are_all_named() {
        let wrong = Windkessel {
            proximal: -1.0,
            compliance: 0.0,
            distal: -2.0,
            distal_pressure: f64::NAN,
            initial: Some(f64::NAN),
        };
        let fields: Vec<_> = wrong.faults().iter().map(|fault| fault.field).collect();
        assert_eq!(fields, ["proximal", "compliance", "distal", "distal_pressure", "initial"]);
        assert_eq!(LAW.faults(), []);
    }
}
