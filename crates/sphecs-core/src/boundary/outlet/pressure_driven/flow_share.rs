//! A share of the prescribed inflow at one of several outlets.
//!
//! ```text
//! U = s Q_in(t)/A
//! dp_t/dt = ρ0 c0 (v̄ − U)/τ
//! ```
//!
//! Q_in is the volume flow that all inlets prescribe. The pressure is whatever drives the share s
//! through the outlet: what flows in excess of it is answered at once as sound is, with
//! ρ0 c0 (v̄ − U), and its integral sets the level. τ is the time after which sound has left the
//! domain.

use serde::{Deserialize, Serialize};

use super::{OpeningFlow, PressureLaw};
use crate::boundary::outlet::method::{Needs, OutletParameters};
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct FlowShare {
    /// Share s of the volume flow of all inlets, dimensionless, from 0 to 1.
    pub share: f64,
}

/// Level p_t of the pressure, Pa.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level(pub f64);

impl OutletParameters for FlowShare {
    fn name(&self) -> &str {
        "FlowShare"
    }

    fn needs(&self) -> Needs {
        Needs { uses_through_flow: false, ..super::needs() }
    }

    fn share(&self) -> Option<f64> {
        Some(self.share)
    }

    fn faults(&self) -> Vec<ParameterFault> {
        ParameterFault::unless_within(0.0..=1.0, "share", self.share).into_iter().collect()
    }
}

impl PressureLaw for FlowShare {
    type State = Level;

    fn pressure(&self, opening: &OpeningFlow, state: &mut Level) -> f64 {
        let excess = opening.impedance * (opening.measured_velocity - opening.velocity);
        state.0 += excess * opening.time_step / opening.settling_time;
        state.0
    }

    fn velocity(&self, opening: &OpeningFlow) -> Option<f64> {
        Some(self.share * opening.total_inflow.unwrap_or(0.0) / opening.area)
    }
}

#[cfg(test)]
mod tests {
    use super::super::{OpeningFlow, opening_at};
    use super::*;

    #[test]
    fn the_level_rises_until_the_share_is_met() {
        let law = FlowShare { share: 0.25 };
        // A quarter of 4e-3 m³/s through 0.01 m².
        let velocity = law.velocity(&opening_at(0.0, 0.0)).expect("a prescribed velocity");
        assert!((velocity - 0.1).abs() < 1e-15);
        let at = |measured_velocity| OpeningFlow { measured_velocity, ..opening_at(velocity, 0.0) };
        let mut state = Level::default();
        assert!(law.pressure(&at(0.12), &mut state) > 0.0);
        let level = state.0;
        assert_eq!(law.pressure(&at(0.1), &mut state), level);
        assert!(law.pressure(&at(0.05), &mut state) < level);
        assert_eq!(FlowShare { share: 1.5 }.faults().len(), 1);
    }
}
