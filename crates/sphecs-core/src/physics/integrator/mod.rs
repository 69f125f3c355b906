//! Time integrators: the door lists the rooms and holds the choice of `Wcsph`.
//!
//! - [`friction`]: what a step cannot follow of the friction at walls
//! - [`kick_drift`]: kick–drift–kick with one evaluation of the rates a step
//! - [`verlet`]: leapfrog with a plain step now and then
//!
//! A summed density makes sound a matter of positions, and kick–drift–kick is symplectic: a wave of frequency ω neither grows nor
//! decays in it up to ω Δt = 2. Verlet's scheme lets it grow, by 8e-4 a step at ω Δt = 0.3 and 5e-3 at 0.5 with a plain step every 50 (test
//! `sound_grows_under_verlet_and_does_not_under_kick_drift`).

pub mod friction;
pub mod kick_drift;
pub mod verlet;

use serde::{Deserialize, Serialize};

use crate::math::real::Real;

/// How the particles of `Wcsph` advance.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Integrator {
    /// Verlet's scheme with a corrective step: Alvarado-Rodríguez et al. (2017).
    Verlet {
        /// A plain step replaces the leapfrog every so many steps, ≥ 1.
        #[serde(default = "plain_step_every")]
        plain_step_every: u32,
    },
    /// Kick–drift–kick with one evaluation of the rates a step.
    #[default]
    KickDrift,
}

fn plain_step_every() -> u32 {
    50
}

impl Integrator {
    /// Courant factor C where a scene gives none.
    pub fn courant_factor(self) -> f64 {
        match self {
            Integrator::Verlet { .. } => 0.3,
            Integrator::KickDrift => 0.5,
        }
    }
}

/// One step of an integrator.
pub trait Advance: Copy + Sync {
    /// Size of the step, s.
    fn time_step(&self) -> f64;

    /// T of [`friction`], s.
    fn friction_span(&self, fresh: bool) -> f64;

    /// Position, velocity and earlier velocity after the step, from those before it and the acceleration at its beginning.
    fn advance<R: Real>(
        &self,
        fresh: bool,
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

    /// Largest |x| of an oscillator of ω Δt = `frequency` that is damped by λ Δt = `damping` times its velocity, from 1 at rest, in the last
    /// tenth of `steps`; the scheme comes with whether its damping goes by the earlier velocity.
    fn swing<A: Advance>(
        scheme: impl Fn(usize) -> (A, bool),
        [frequency, damping]: [f64; 2],
        steps: usize,
    ) -> f64 {
        let (mut x, mut velocities, mut largest) = (1.0, [0.0, 0.0], 0.0_f64);
        for step in 0..steps {
            let (scheme, earlier) = scheme(step);
            let [now, before] = velocities;
            let rate = -frequency * frequency * x - damping * if earlier { before } else { now };
            (x, velocities) = scheme.advance(step == 0, x, velocities, rate);
            if 10 * step >= 9 * steps {
                largest = largest.max(x.abs());
            }
        }
        largest
    }

    fn verlet(step: usize) -> (Verlet, bool) {
        let plain = step.is_multiple_of(50);
        (Verlet { time_step: 1.0, time_step_before: 1.0, plain }, !plain)
    }

    fn kick_drift(_: usize) -> (KickDrift, bool) {
        (KickDrift { time_step: 1.0, time_step_before: 1.0 }, false)
    }

    #[test]
    fn sound_grows_under_verlet_and_does_not_under_kick_drift() {
        for (frequency, growth) in [(0.3, 8.0e-4), (0.5, 5.5e-3)] {
            let found = swing(verlet, [frequency, 0.0], 1000).ln() / 950.0;
            assert!((found / growth - 1.0).abs() < 0.1, "ω Δt = {frequency}: grows by {found} a step");
            let found = swing(kick_drift, [frequency, 0.0], 100_000);
            assert!(found < 1.1, "ω Δt = {frequency}: {found}");
        }
        // Far beyond what a Courant factor of one gives.
        assert!(swing(kick_drift, [1.9, 0.0], 100_000) < 4.0);
    }

    #[test]
    fn damped_sound_decays_within_the_limits_of_a_step() {
        for damping in [0.01, 0.1, 0.5, 0.7] {
            for frequency in [0.05, 0.3, 0.6, 1.0] {
                let left = swing(kick_drift, [frequency, damping], 4000);
                assert!(left < 0.5, "kick-drift, ω Δt = {frequency}, λ Δt = {damping}: {left}");
            }
            let left = swing(verlet, [0.3, damping], 4000);
            assert!(left < 0.5, "leapfrog, λ Δt = {damping}: {left}");
        }
    }
}
