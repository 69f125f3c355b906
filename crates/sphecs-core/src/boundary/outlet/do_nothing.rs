//! Outflow particles that keep the state of their crossing.
//!
//! ```text
//! x_o(n) = x_o(n−1) + v_n Δt n,   v_o(n) = v_o(n−1),   p_o(n) = p_o(n−1)
//! ```
//!
//! Negi et al. (2020), Eqs. 14–16: ∂u/∂t + u ∂u/∂x = 0 for the fields that a particle carries,
//! after Federico et al. (2012). A particle moves along the normal n of the outlet only, with its
//! own normal velocity.
//!
//! The initial state of the zone stays. Therefore a zone at rest blocks a flow that starts from
//! rest until the fluid pushes its own particles across. Acoustic waves are reflected, since
//! neither pressure nor velocity of the zone responds. A particle that has crossed never returns,
//! so that a vortex loses its backflow. Nothing anchors the pressure. Particles of one column cross
//! within a few steps of each other, and the acoustic state of that moment stays with the column.
//!
//! The code of the authors moves the zone with the transport velocity of the crossing. Here it is v
//! itself, as published: the other part of the transport velocity redistributes particles and has
//! no mean.

use glam::DVec3;

use super::method::{Needs, OutflowState, OutletMethod, OutletParameters};
use super::outflow_zone::OutflowZone;
use crate::pass::pair_real::PairReal;

/// The condition; it has no parameters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DoNothing;

impl OutletParameters for DoNothing {
    fn name(&self) -> &str {
        "DoNothing"
    }

    fn needs(&self) -> Needs {
        Needs { is_one_way: true, ..Needs::default() }
    }
}

impl OutletMethod for DoNothing {
    type Memory = ();

    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut OutflowZone<'_, R, D>, _memory: &mut ()) {
        let normal = zone.normal();
        for &row in zone.rows {
            let (velocity, pressure) = zone.state(row as usize);
            zone.set(row as usize, frozen(velocity, pressure, normal));
        }
    }
}

/// Returns the state of a particle that keeps velocity (m/s) and pressure (Pa) of its crossing.
pub fn frozen(velocity: DVec3, pressure: f64, normal: DVec3) -> OutflowState {
    OutflowState::moving(velocity, pressure, normal)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_state_is_kept_and_moves_at_the_normal_velocity() {
        let normal = DVec3::new(0.6, 0.8, 0.0);
        let velocity = DVec3::new(1.0, -0.5, 0.25);
        let state = frozen(velocity, -3.0, normal);
        assert_eq!((state.velocity, state.pressure), (velocity, -3.0));
        assert!((state.speed - 0.2).abs() < 1e-15);
        assert_eq!(frozen(state.velocity, state.pressure, normal), state);
    }
}
