//! Pressure of outflow particles under the conditions that solve a wave equation.

use serde::{Deserialize, Serialize};

use super::outflow_zone::OutflowZone;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// Pressure of outflow particles.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum OutletPressure {
    /// The pressure that the particle had when it crossed the plane. Take it to compare with
    /// conditions that keep it.
    Frozen,
    /// A given pressure, Pa. Take it for a mean flow that the outlets alone determine and that
    /// accelerates for good.
    Reference(f64),
    /// The pressure of the crossing, relaxed towards `target` (Pa) over `time` (s). Take it to
    /// compare with the nonreflecting pressure.
    Relaxed {
        /// Pressure approached, Pa.
        target: f64,
        /// Time constant, s.
        time: f64,
    },
    /// Transmits acoustic waves: the incoming characteristic is held at `target` (Pa) about the
    /// mean velocity. Take it for other flows.
    NonReflecting {
        /// Mean pressure approached, Pa, default 0.
        #[serde(default)]
        target: f64,
        /// Time constant with which the mean velocity is followed, s, default that of the flow from
        /// the inlets: the outlet knows the mean velocity that they cause, so that a slow flow
        /// leaves at `target`, and follows the rest over four travel times of sound through the
        /// domain along its normal. With a long time the outlet acts as a long pipe does.
        #[serde(default)]
        time: Option<f64>,
        /// Acoustic waves that are transmitted.
        #[serde(default)]
        waves: Waves,
    },
}

/// Acoustic waves that a nonreflecting outlet transmits.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Waves {
    /// Plane waves along the normal: the mean over the section. Take it to compare with outlets
    /// that transmit these alone.
    Plane,
    /// Oblique waves as well. Take it unless outlets are compared.
    #[default]
    All,
}

impl Default for OutletPressure {
    fn default() -> Self {
        OutletPressure::NonReflecting { target: 0.0, time: None, waves: Waves::All }
    }
}

impl OutletPressure {
    /// Returns the pressure of the surroundings that the scene gives, Pa; 0 by default.
    pub fn target(self) -> f64 {
        match self {
            OutletPressure::Frozen => 0.0,
            OutletPressure::Reference(target)
            | OutletPressure::Relaxed { target, .. }
            | OutletPressure::NonReflecting { target, .. } => target,
        }
    }

    /// Returns true if the pressure is set in each step, not kept from step to step.
    ///
    /// Only such a pressure may lose its dynamic part in backflow; a kept one would lose it
    /// repeatedly.
    pub fn is_set_each_step(self) -> bool {
        matches!(self, OutletPressure::Reference(_) | OutletPressure::NonReflecting { .. })
    }

    /// Returns the parameters that are out of range.
    pub fn faults(self) -> Vec<ParameterFault> {
        let time = match self {
            OutletPressure::Frozen | OutletPressure::Reference(_) => None,
            OutletPressure::Relaxed { time, .. } => Some(time),
            OutletPressure::NonReflecting { time, .. } => time,
        };
        let time = time.and_then(|time| ParameterFault::unless_positive("time", time, "s"));
        let target = ParameterFault::unless_finite("pressure", self.target(), "Pa");
        time.into_iter().chain(target).collect()
    }

    /// Sets the pressures of a zone where they do not depend on the flow.
    pub fn set<R: PairReal<D>, const D: usize>(self, zone: &mut OutflowZone<'_, R, D>) {
        let (rows, pressures) = (zone.rows, &mut zone.arrays.pressure);
        match self {
            OutletPressure::Reference(pressure) => {
                for &row in rows {
                    pressures[row as usize] = R::from_f64(pressure);
                }
            }
            OutletPressure::Relaxed { target, time } => {
                let share = -(-zone.time_step / time).exp_m1();
                for &row in rows {
                    let pressure = pressures[row as usize].to_f64();
                    pressures[row as usize] = R::from_f64(pressure + share * (target - pressure));
                }
            }
            // A nonreflecting pressure follows from the flow: `non_reflecting`.
            OutletPressure::Frozen | OutletPressure::NonReflecting { .. } => {}
        }
    }
}
