//! Implicit treatment of fast friction at walls.
//!
//! A particle next to a no-slip wall is damped by the image velocities of the wall at a rate λ that
//! can be many times that of the fluid. To keep this from limiting the time step, the part of λ
//! beyond C_λ/Δt is treated implicitly:
//!
//! ```text
//! dv/dt → dv/dt/(1 + T (λ − C_λ/Δt))
//! ```
//!
//! With the interval of a kick as T, this is the Rosenbrock form of an implicit Euler step for that
//! part: Hairer & Wanner (1996), section IV.7. Verlet's scheme uses this T. Kick–drift–kick
//! evaluates the rates at a predicted velocity, which contains half of the last kick a second time.
//! It uses the interval of two kicks as T: a particle then keeps 0.64 of its velocity per step,
//! however large λ is, without oscillation. A steady flow is unaffected, and an unsteady one
//! changes only on the scale of a few steps (test `fast_damping_decays_without_oscillation`).

use super::Advance;

/// C_λ: a step resolves damping up to the rate C_λ/Δt.
pub const DAMPING: f64 = 0.5;

/// Returns true if a damping rate, 1/s, is faster than a step resolves.
pub fn is_fast<A: Advance>(scheme: &A, damping: f64) -> bool {
    damping * scheme.time_step() > DAMPING
}

/// Returns the factor of the acceleration of a particle with a damping rate, 1/s: 1 unless the rate
/// [is fast](is_fast).
pub fn implicit_factor<A: Advance>(scheme: &A, needs_restart: bool, damping: f64) -> f64 {
    1.0 / (1.0 + scheme.friction_span(needs_restart) * (damping - DAMPING / scheme.time_step()).max(0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::physics::integrator::kick_drift::KickDrift;
    use crate::physics::integrator::verlet::Verlet;

    /// Damps a particle from 1 m/s for 200 steps of 4 ms. `scheme` returns the integrator and
    /// whether the damping uses the previous velocity.
    fn decay<A: Advance>(rate: f64, scheme: impl Fn(usize) -> (A, bool)) {
        let mut velocities = [1.0, 1.0];
        for step in 0..200 {
            let (scheme, uses_previous) = scheme(step);
            let [now, previous] = velocities;
            let needs_restart = step == 0;
            let velocity = if uses_previous { previous } else { now };
            let damped = -rate * velocity * implicit_factor(&scheme, needs_restart, rate);
            velocities = scheme.advance(needs_restart, 0.0, velocities, damped).1;
            let next = velocities[0];
            assert!(next >= 0.0 && next <= now, "λ = {rate}, step {step}: {now} -> {next}");
        }
        let (left, exact) = (velocities[0], (-rate * 0.004 * 200.0).exp());
        assert!(left <= exact.max(1e-20) * 1.01, "λ = {rate}: {left}");
    }

    #[test]
    fn fast_damping_decays_without_oscillation() {
        let (time_step, previous_time_step) = (0.004, 0.004);
        for rate in [1.0, 100.0, 1e3, 1e6] {
            decay(rate, |step| {
                let is_corrective = step % 50 == 0;
                (Verlet { time_step, previous_time_step, is_corrective }, !is_corrective)
            });
            decay(rate, |_| (KickDrift { time_step, previous_time_step }, false));
        }
        let slow = Verlet { time_step, previous_time_step, is_corrective: false };
        let unchanged = !is_fast(&slow, 100.0) && implicit_factor(&slow, false, 100.0) == 1.0;
        assert!(unchanged, "damping that the step resolves is unchanged");
    }
}
