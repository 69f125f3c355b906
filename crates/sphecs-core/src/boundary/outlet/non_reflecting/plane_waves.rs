//! Outlet pressure that transmits plane acoustic waves along the normal.
//!
//! ```text
//! J2 = (p̄ − p_t) + ρ0 c0 (v̄ − U − u)    outgoing
//! J3 = (p  − p_t) − ρ0 c0 (v  − U − u)    incoming: 0
//! p  = p_t + ½ J2,     du/dt = (w − u)/½τ,  dw/dt = (v̄ − U − w)/½τ
//! ```
//!
//! p̄ and v̄ are means over uniform points of the section a layer inside the plane, U is the
//! velocity that the prescribed inflow causes there, see
//! [`prescribed_flow`](super::prescribed_flow).
//!
//! These are the characteristic variables of Negi et al. (2020), Eqs. 25–27, after Lastiwka et al.
//! (2009), for the mean over the section only. In a nearly incompressible flow the velocity of a
//! passing vortex is orders of magnitude too large to be taken for sound. For a jet with v' = 0.1
//! m/s at c0 = 4 m/s, ½ ρ0 c0 v' is 200 Pa, its true pressure 5 Pa. A channel carries only plane
//! waves below its cut-on frequency c0/(2 width), and the mean over the section is exactly that
//! part.
//!
//! What remains of the mean velocity, u, follows the flow over a time τ, so that the target p_t
//! holds in the long run. It does so in two stages, so that a passing pulse leaves no offset. A
//! fixed pressure would reflect every wave and, with a prescribed inlet velocity, turn the channel
//! into a resonator.

use serde::{Deserialize, Serialize};

/// State of the plane waves at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlaneWaves {
    /// Followed mean velocity u less the prescribed one, m/s. None before the first step, which
    /// takes that of the flow: a flow already in motion is not a wave.
    pub mean_velocity: Option<f64>,
    /// First stage w of the following velocity, m/s.
    pub first_stage: f64,
}

impl PlaneWaves {
    /// Advances the followed velocity by a step (s) and returns the pressure at the outlet, Pa. It
    /// follows from the section means of pressure (Pa) and of normal velocity, less the prescribed
    /// one (m/s), of the adjacent fluid.
    pub fn advance(
        &mut self,
        setting: &PlaneSetting,
        mean_pressure: f64,
        mean_velocity: f64,
        time_step: f64,
    ) -> f64 {
        let impedance = setting.density * setting.sound_speed;
        let followed = self.mean_velocity.unwrap_or_else(|| {
            self.first_stage = mean_velocity;
            mean_velocity
        });
        let outgoing = mean_pressure - setting.target + impedance * (mean_velocity - followed);
        let share = -(-2.0 * time_step / setting.time).exp_m1();
        self.mean_velocity = Some(followed + share * (self.first_stage - followed));
        self.first_stage += share * (mean_velocity - self.first_stage);
        setting.target + 0.5 * outgoing
    }
}

/// Constants of the plane waves at an outlet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PlaneSetting {
    /// Pressure approached, Pa.
    pub target: f64,
    /// Time constant τ, s.
    pub time: f64,
    /// Reference density ρ0, kg/m³.
    pub density: f64,
    /// Sound speed c0, m/s.
    pub sound_speed: f64,
}

#[cfg(test)]
mod tests {
    use super::*;

    const SETTING: PlaneSetting = PlaneSetting { target: 5.0, time: 0.5, density: 1000.0, sound_speed: 4.0 };

    #[test]
    fn an_outgoing_wave_meets_its_own_pressure() {
        // p' = ρ c v': the outlet must have the pressure of the wave, as if the channel continued.
        let mut state = PlaneWaves { mean_velocity: Some(0.1), first_stage: 0.1 };
        let p = state.advance(&SETTING, 5.0 + 1000.0 * 4.0 * 0.002, 0.102, 1e-9);
        assert!((p - (5.0 + 8.0)).abs() < 1e-9, "{p}");
    }

    #[test]
    fn a_steady_flow_approaches_the_target() {
        let mut state = PlaneWaves::default();
        let mut p = 40.0;
        for _ in 0..200_000 {
            p = state.advance(&SETTING, p, 0.035, 1e-4);
        }
        assert!((p - 5.0).abs() < 1e-6, "{p}");
        assert!(state.mean_velocity.is_some_and(|velocity| (velocity - 0.035).abs() < 1e-9));
    }

    #[test]
    fn initial_velocity_is_not_taken_for_a_wave() {
        let p = PlaneWaves::default().advance(&SETTING, 5.0, 3.0, 1e-4);
        assert_eq!(p, 5.0);
    }
}
