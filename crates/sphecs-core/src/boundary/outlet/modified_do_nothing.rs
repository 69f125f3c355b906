//! Particles that keep what they had when they crossed and are carried away by the fluid.
//!
//! ```text
//! x_o(n) = x_o(n−1) + v_ex Δt n,   v_ex = Σ V_b v_n,b W_ob / Σ V_b W_ob over the fluid;   p_o(n) = p_o(n−1)
//! ```
//!
//! Negi et al. (2020), Eqs. 17 and 18, with volumes in the mean, which single precision and uneven particles like better than bare kernels.
//! Particles that see no fluid take the mean v_ex of those that do, in the same step. The zone moves along the normal only.
//!
//! The fluid goes on seeing the velocity of the crossing, `shown: Frozen`, as printed: what the zone says is not what it does. One might
//! think that the pressure of `EdacTvf`, which is driven by the divergence, would rather see v_ex, `shown: Carried`. It is the other way
//! round: a zone that gives way to sound as the fluid does, under a pressure that stays as it is, is the open end of a pipe and throws
//! a pulse back whole; one whose velocity stays as it is too is half an open and half a closed end (docs/outlets.md has the figures).
//! Under `Wcsph`, which looks at densities, both are the same open end.
//!
//! The zone starts with the flow, so nothing blocks it; the pressure has no anchor.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Outflow;

/// Normal velocity that the fluid sees of the zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum ShownVelocity {
    /// That of the crossing, as printed.
    #[default]
    Frozen,
    /// That with which the zone moves.
    Carried,
}

/// The particle with its velocity (m/s) and pressure (Pa), carried by the normal velocity of the fluid (m/s).
pub fn carried(
    velocity: DVec3,
    pressure: f64,
    fluid_velocity: f64,
    shown: ShownVelocity,
    normal: DVec3,
) -> Outflow {
    let outflow = Outflow { velocity, pressure, speed: fluid_velocity };
    match shown {
        ShownVelocity::Carried => outflow.at_speed(fluid_velocity, normal),
        ShownVelocity::Frozen => outflow,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fluid_moves_it_and_the_rest_is_kept() {
        let (normal, velocity) = (DVec3::Y, DVec3::new(0.3, 1.0, -0.1));
        let printed = carried(velocity, 7.0, 2.0, ShownVelocity::Frozen, normal);
        assert_eq!(printed, Outflow { velocity, pressure: 7.0, speed: 2.0 });
        let shown = carried(velocity, 7.0, 2.0, ShownVelocity::Carried, normal);
        assert_eq!(shown, Outflow { velocity: DVec3::new(0.3, 2.0, -0.1), pressure: 7.0, speed: 2.0 });
    }

    #[test]
    fn a_uniform_stream_is_the_same_in_both_ways() {
        let velocity = DVec3::new(0.2, 0.0, 0.0);
        let of = |shown| carried(velocity, 0.0, 0.2, shown, DVec3::X);
        assert_eq!(of(ShownVelocity::Carried), of(ShownVelocity::Frozen));
    }
}
