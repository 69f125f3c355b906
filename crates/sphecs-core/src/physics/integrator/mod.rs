//! Time integrators and the choice of `Wcsph` among them.
//!
//! - [`friction`]: implicit treatment of fast friction at walls
//! - [`kick_drift`]: kick–drift–kick with one evaluation of the rates per step
//! - [`verlet`]: leapfrog with a corrective step at intervals
//!
//! With a summed density, acoustic waves depend only on positions, and kick–drift–kick is
//! symplectic: a wave of frequency ω neither grows nor decays up to ω Δt = 2. Under Verlet's scheme
//! it grows by 8e-4 per step at ω Δt = 0.3, and by 5e-3 at 0.5, with a corrective step every 50
//! steps (test `sound_grows_under_verlet_and_does_not_under_kick_drift`).

pub mod friction;
pub mod kick_drift;
pub mod verlet;

use serde::{Deserialize, Serialize};

use crate::math::real::Real;

/// Time integrator of `Wcsph`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum Integrator {
    /// Verlet's scheme with a corrective step: Alvarado-Rodríguez et al. (2017). Take it to compare
    /// with them.
    Verlet {
        /// Number of steps from one corrective (Euler) step, which replaces the leapfrog, to the
        /// next, at least 1, default 50.
        #[serde(default = "corrective_step_every")]
        corrective_step_every: u32,
    },
    /// Kick–drift–kick with one evaluation of the rates per step. Take it unless results are
    /// compared with published ones.
    #[default]
    KickDrift,
}

fn corrective_step_every() -> u32 {
    50
}

impl Integrator {
    /// Returns the Courant factor C of a scene that does not give one.
    pub fn courant_factor(self) -> f64 {
        match self {
            Integrator::Verlet { .. } => 0.3,
            Integrator::KickDrift => 0.5,
        }
    }
}

/// Integrator with the size of its present step.
pub trait Advance: Copy + Sync {
    /// Returns the size of the step, s.
    fn time_step(&self) -> f64;

    /// Returns the interval T of [`friction`], s.
    fn friction_span(&self, needs_restart: bool) -> f64;

    /// Advances a particle: returns its position, velocity and previous velocity after the step,
    /// from those before it and the acceleration at its beginning.
    fn advance<R: Real>(
        &self,
        needs_restart: bool,
        position: f64,
        velocities: [R; 2],
        acceleration: R,
    ) -> (f64, [R; 2]);
}

#[cfg(test)]
mod tests {
    use super::kick_drift::KickDrift;
    use super::verlet::Verlet;
    use super::*;

    /// Returns the largest |x| in the last tenth of `steps` of an oscillator that starts from rest
    /// at x = 1. Its ω Δt is `frequency`, its λ Δt `damping`.
    ///
    /// `scheme` returns the integrator and whether the damping uses the previous velocity.
    fn amplitude<A: Advance>(
        scheme: impl Fn(usize) -> (A, bool),
        [frequency, damping]: [f64; 2],
        steps: usize,
    ) -> f64 {
        let (mut x, mut velocities, mut largest) = (1.0, [0.0, 0.0], 0.0_f64);
        for step in 0..steps {
            let (scheme, uses_previous) = scheme(step);
            let [now, previous] = velocities;
            let rate = -frequency * frequency * x - damping * if uses_previous { previous } else { now };
            (x, velocities) = scheme.advance(step == 0, x, velocities, rate);
            if 10 * step >= 9 * steps {
                largest = largest.max(x.abs());
            }
        }
        largest
    }

    fn verlet(step: usize) -> (Verlet, bool) {
        let is_corrective = step.is_multiple_of(50);
        (Verlet { time_step: 1.0, previous_time_step: 1.0, is_corrective }, !is_corrective)
    }

    fn kick_drift(_: usize) -> (KickDrift, bool) {
        (KickDrift { time_step: 1.0, previous_time_step: 1.0 }, false)
    }

    #[test]
    fn sound_grows_under_verlet_and_does_not_under_kick_drift() {
        for (frequency, growth) in [(0.3, 8.0e-4), (0.5, 5.5e-3)] {
            let found = amplitude(verlet, [frequency, 0.0], 1000).ln() / 950.0;
            assert!((found / growth - 1.0).abs() < 0.1, "ω Δt = {frequency}: grows by {found} a step");
            let found = amplitude(kick_drift, [frequency, 0.0], 100_000);
            assert!(found < 1.1, "ω Δt = {frequency}: {found}");
        }
        // ω Δt = 1.9 is far beyond a Courant factor of one.
        assert!(amplitude(kick_drift, [1.9, 0.0], 100_000) < 4.0);
    }

    #[test]
    fn damped_sound_decays_within_the_limits_of_a_step() {
        for damping in [0.01, 0.1, 0.5, 0.7] {
            for frequency in [0.05, 0.3, 0.6, 1.0] {
                let left = amplitude(kick_drift, [frequency, damping], 4000);
                assert!(left < 0.5, "kick-drift, ω Δt = {frequency}, λ Δt = {damping}: {left}");
            }
            let left = amplitude(verlet, [0.3, damping], 4000);
            assert!(left < 0.5, "leapfrog, λ Δt = {damping}: {left}");
        }
    }
}
