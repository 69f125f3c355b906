//! What a step cannot follow of the friction at walls.
//!
//! A particle next to a no-slip wall is damped by the wall's image at a rate λ that can be many times that of the fluid, and the step
//! need not follow it: what is beyond C_λ/Δt is taken implicitly,
//!
//! ```text
//! dv/dt → dv/dt/(1 + T (λ − C_λ/Δt))
//! ```
//!
//! With T the interval of a kick that is the Rosenbrock form of an implicit Euler step for that part alone: Hairer & Wanner (1996),
//! section IV.7; so it is for Verlet's scheme. Kick–drift–kick finds the rates with a guess at the velocity that
//! has the last kick once more, half of it: with T the interval of two kicks a particle keeps 0.64 of its velocity a step, however
//! large λ is, and does not swing. It changes nothing in a steady flow, and in an unsteady one what happens within a few steps (test
//! `fast_damping_decays_without_swinging`).

use super::Advance;

/// C_λ: a step follows a damping up to this over its rate.
pub const DAMPING: f64 = 0.5;

/// Whether a damping rate (1/s) is beyond what a step follows.
pub fn is_fast<A: Advance>(scheme: &A, damping: f64) -> bool {
    damping * scheme.time_step() > DAMPING
}

/// The share of its acceleration that a particle with a damping rate (1/s) takes: 1 unless that [is fast](is_fast).
pub fn share<A: Advance>(scheme: &A, fresh: bool, damping: f64) -> f64 {
    1.0 / (1.0 + scheme.friction_span(fresh) * (damping - DAMPING / scheme.time_step()).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::integrator::kick_drift::KickDrift;
    use crate::physics::integrator::verlet::Verlet;

    /// Damps a particle from 1 m/s for 200 steps of 4 ms; `earlier`: the rates are found with the earlier velocity.
    fn decay<A: Advance>(rate: f64, scheme: impl Fn(usize) -> (A, bool)) {
        let mut velocities = [1.0, 1.0];
        for step in 0..200 {
            let (scheme, earlier) = scheme(step);
            let [now, before] = velocities;
            let fresh = step == 0;
            let damped = -rate * if earlier { before } else { now } * share(&scheme, fresh, rate);
            velocities = scheme.advance(fresh, 0.0, velocities, damped).1;
            let next = velocities[0];
            assert!(next >= 0.0 && next <= now, "λ = {rate}, step {step}: {now} -> {next}");
        }
        let (left, exact) = (velocities[0], (-rate * 0.004 * 200.0).exp());
        assert!(left <= exact.max(1e-20) * 1.01, "λ = {rate}: {left}");
    }

    #[test]
    fn fast_damping_decays_without_swinging() {
        let (time_step, time_step_before) = (0.004, 0.004);
        for rate in [1.0, 100.0, 1e3, 1e6] {
            decay(rate, |step| {
                let plain = step % 50 == 0;
                (Verlet { time_step, time_step_before, plain }, !plain)
            });
            decay(rate, |_| (KickDrift { time_step, time_step_before }, false));
        }
        let slow = Verlet { time_step, time_step_before, plain: false };
        let unchanged = !is_fast(&slow, 100.0) && share(&slow, false, 100.0) == 1.0;
        assert!(unchanged, "nothing changes what the step follows");
    }
}
