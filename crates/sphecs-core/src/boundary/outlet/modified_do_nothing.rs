//! Outflow particles that keep the state of their crossing and are advected by the fluid.
//!
//! ```text
//! x_o(n) = x_o(n−1) + v_ex Δt n,   v_ex = Σ V_b v_n,b W_ob / Σ V_b W_ob over the fluid
//! v_o(n) = v_o(n−1),   p_o(n) = p_o(n−1)
//! ```
//!
//! These are Eqs. 17 and 18 of Negi et al. (2020), with volumes in the mean. In single precision
//! and for disordered particles volumes are more accurate than bare kernels. Particles without
//! fluid in their support take the mean v_ex of the others, in the same step. The zone moves along
//! the normal only.
//!
//! With `shown: Frozen`, as published, the fluid sees the velocity of the crossing, which is not
//! the velocity of the motion. One might expect v_ex, `shown: Carried`, to suit the pressure of
//! `EdacTvf` better, since the divergence drives it. The opposite is true. A zone whose particles
//! follow an acoustic wave under a constant pressure is the open end of a pipe and reflects a pulse
//! fully. With a constant velocity as well, it is half an open and half a closed end (figures:
//! docs/notebook/2026-11-24-outlets.md). Under `Wcsph`, whose pressure follows from densities, both
//! are the same open end.
//!
//! The zone starts with the flow, so nothing blocks it; the pressure has no anchor.

use std::iter::empty;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::method::{Needs, OutflowState, OutletMethod, OutletParameters};
use super::outflow_zone::OutflowZone;
use crate::pass::fits::PointFit;
use crate::pass::pair_real::PairReal;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ModifiedDoNothing {
    /// Normal velocity of the outflow particles in the sums of the fluid.
    #[serde(default)]
    pub shown: ShownVelocity,
}

/// Normal velocity of the zone in the sums of the fluid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum ShownVelocity {
    /// The velocity of the crossing, as published. Take it to compare with published results.
    #[default]
    Frozen,
    /// The velocity with which the zone moves. Take it to compare the two readings.
    Carried,
}

impl OutletParameters for ModifiedDoNothing {
    fn name(&self) -> &str {
        "ModifiedDoNothing"
    }

    fn needs(&self) -> Needs {
        Needs { is_one_way: true, ..Needs::default() }
    }
}

impl OutletMethod for ModifiedDoNothing {
    type Memory = ();

    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut OutflowZone<'_, R, D>, _memory: &mut ()) {
        let normal = zone.normal();
        zone.fit_fluid(PointFit::Mean { normal }, |point| point, empty());
        let others = zone.mean_fitted(|flow| flow.velocity).unwrap_or(zone.adjacent.velocity);
        for (at, &row) in zone.rows.iter().enumerate() {
            let fluid = zone.fitted()[at].map_or(others, |flow| flow.velocity);
            let (velocity, pressure) = zone.state(row as usize);
            zone.set(row as usize, self.carried(velocity, pressure, fluid, normal));
        }
    }
}

impl ModifiedDoNothing {
    /// Returns the state of a particle with its velocity (m/s) and pressure (Pa), moved at the
    /// normal velocity of the fluid (m/s).
    pub fn carried(self, velocity: DVec3, pressure: f64, fluid: f64, normal: DVec3) -> OutflowState {
        let state = OutflowState { velocity, pressure, speed: fluid };
        match self.shown {
            ShownVelocity::Carried => state.at_speed(fluid, normal),
            ShownVelocity::Frozen => state,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const FROZEN: ModifiedDoNothing = ModifiedDoNothing { shown: ShownVelocity::Frozen };
    const CARRIED: ModifiedDoNothing = ModifiedDoNothing { shown: ShownVelocity::Carried };

    #[test]
    fn the_fluid_moves_a_particle_and_the_rest_is_kept() {
        let (normal, velocity) = (DVec3::Y, DVec3::new(0.3, 1.0, -0.1));
        let frozen = FROZEN.carried(velocity, 7.0, 2.0, normal);
        assert_eq!(frozen, OutflowState { velocity, pressure: 7.0, speed: 2.0 });
        let carried = CARRIED.carried(velocity, 7.0, 2.0, normal);
        let velocity = DVec3::new(0.3, 2.0, -0.1);
        assert_eq!(carried, OutflowState { velocity, pressure: 7.0, speed: 2.0 });
    }

    #[test]
    fn a_uniform_stream_stays_with_both_shown_velocities() {
        let velocity = DVec3::new(0.2, 0.0, 0.0);
        let state = |method: ModifiedDoNothing| method.carried(velocity, 0.0, 0.2, DVec3::X);
        assert_eq!(state(CARRIED), state(FROZEN));
    }
}
