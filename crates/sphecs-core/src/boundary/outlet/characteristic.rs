//! Outgoing characteristic about reference values; no wave enters.
//!
//! ```text
//! J2 = ρ0 c0 (v_n − u_ref) + (p − p_ref)     outgoing: Σ V_b J2,b W_ob / Σ V_b W_ob over the fluid
//! J3 = −ρ0 c0 (v_n − u_ref) + (p − p_ref)    incoming: 0
//! v_n = u_ref + J2/(2 ρ0 c0),   p = p_ref + J2/2
//! ```
//!
//! Negi et al. (2020), Eqs. 25–27, after Lastiwka et al. (2009). The velocity components in the
//! plane keep the values of the crossing; a particle moves along the normal with v_n. Particles
//! without fluid in their support take the mean J2 of the others in the same step; as published, in
//! the previous step.
//!
//! * The impedance is ρ0 c0 throughout; the paper has the local density, which differs by the Mach
//!   number squared.
//! * J1 = −c0² (ρ − ρ0) + (p − p_ref), which gives the density, is not carried. The density follows
//!   from the pressure (`Wcsph`, for which J1 is of second order) or from the positions
//!   (`EdacTvf`).
//! * The condition takes a stream whose velocity is not u_ref for sound: it keeps a pressure of ρ0
//!   c0 (v_n − u_ref). So the references have no default. It takes a vortex for sound as well,
//!   whose pressure at the outlet is wrong by ½ ρ0 c0 v'.
//! * Backflow meets the pressure of J2, not that of a real inflow. It enters with the tangential
//!   velocity of the outflow particle, since entropy and vorticity of the surroundings are not
//!   known. A uniform inflow is preserved if u_ref is its velocity (tests/outlets.rs).

use std::iter::empty;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::method::{Needs, OutflowState, OutletMethod, OutletParameters, References};
use super::outflow_zone::OutflowZone;
use crate::pass::fits::PointFit;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of the condition. They have no default, since a stream of another velocity gets a
/// pressure of ρ0 c0 times the difference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Characteristic {
    /// Reference velocity along the outlet's normal, m/s.
    pub velocity: f64,
    /// Reference pressure, Pa.
    pub pressure: f64,
}

impl OutletParameters for Characteristic {
    fn name(&self) -> &str {
        "Characteristic"
    }

    fn needs(&self) -> Needs {
        // A stream that is meant to enter has its reference.
        Needs { is_one_way: self.velocity >= 0.0, ..Needs::default() }
    }

    fn references(&self) -> References {
        References { velocity: self.velocity, pressure: self.pressure }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let velocity = ParameterFault::unless_finite("velocity", self.velocity, "m/s");
        let pressure = ParameterFault::unless_finite("pressure", self.pressure, "Pa");
        velocity.into_iter().chain(pressure).collect()
    }
}

impl OutletMethod for Characteristic {
    type Memory = ();

    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut OutflowZone<'_, R, D>, _memory: &mut ()) {
        let (normal, impedance, references) = (zone.normal(), zone.flow.impedance(), self.references());
        // The impedance is the same for all, so that the mean of J2 is that of velocity and
        // pressure.
        zone.fit_fluid(PointFit::Mean { normal }, |point| point, empty());
        let outgoing = |velocity: f64, pressure: f64| references.outgoing(velocity, pressure, impedance);
        let others = zone
            .mean_fitted(|flow| outgoing(flow.velocity, flow.pressure))
            .unwrap_or_else(|| outgoing(zone.adjacent.velocity, zone.adjacent.pressure));
        for (at, &row) in zone.rows.iter().enumerate() {
            let j2 = zone.fitted()[at].map_or(others, |flow| outgoing(flow.velocity, flow.pressure));
            let (velocity, _) = zone.state(row as usize);
            zone.set(row as usize, references.outflow(velocity, j2, impedance, normal));
        }
    }
}

impl References {
    /// Returns J2 of a flow with a normal velocity (m/s) and a pressure (Pa) for an impedance ρ0 c0
    /// in kg/(m² s), Pa.
    pub fn outgoing(&self, velocity: f64, pressure: f64, impedance: f64) -> f64 {
        impedance * (velocity - self.velocity) + (pressure - self.pressure)
    }

    /// Returns normal velocity (m/s) and pressure (Pa) for an outgoing J2 (Pa) and no incoming
    /// wave.
    pub fn at(&self, outgoing: f64, impedance: f64) -> (f64, f64) {
        (self.velocity + 0.5 * outgoing / impedance, self.pressure + 0.5 * outgoing)
    }

    /// Returns the state of a particle that keeps its tangential velocity (m/s), for an outgoing J2
    /// (Pa).
    pub fn outflow(&self, velocity: DVec3, outgoing: f64, impedance: f64, normal: DVec3) -> OutflowState {
        let (speed, pressure) = self.at(outgoing, impedance);
        OutflowState { velocity, pressure, speed }.at_speed(speed, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REFERENCES: References = References { velocity: 0.2, pressure: 5.0 };

    #[test]
    fn an_outgoing_wave_is_transmitted() {
        // p' = ρ c v'.
        let outgoing = REFERENCES.outgoing(0.2 + 0.003, 5.0 + 30.0, 1e4);
        let (velocity, pressure) = REFERENCES.at(outgoing, 1e4);
        assert!((velocity - 0.203).abs() < 1e-15 && (pressure - 35.0).abs() < 1e-12, "{velocity} {pressure}");
    }

    #[test]
    fn an_incoming_wave_leaves_the_references() {
        // p' = −ρ c v' has no J2.
        let outgoing = REFERENCES.outgoing(0.2 - 0.003, 5.0 + 30.0, 1e4);
        let (velocity, pressure) = REFERENCES.at(outgoing, 1e4);
        assert!((velocity - 0.2).abs() < 1e-14 && (pressure - 5.0).abs() < 1e-10, "{velocity} {pressure}");
    }

    #[test]
    fn only_the_normal_velocity_is_set() {
        let normal = DVec3::new(0.0, 0.6, -0.8);
        let outflow = REFERENCES.outflow(DVec3::new(1.0, 2.0, 3.0), 0.0, 1e4, normal);
        assert!((outflow.velocity.dot(normal) - 0.2).abs() < 1e-15 && outflow.speed == 0.2);
        let along = outflow.velocity - normal * outflow.velocity.dot(normal);
        let before = DVec3::new(1.0, 2.0, 3.0);
        assert!(along.distance(before - normal * before.dot(normal)) < 1e-15);
    }
}
