//! Kick–drift–kick with one evaluation of the rates per step.
//!
//! ```text
//! kick       u(n+½) = u(n−½) + ½ (Δt(n−1) + Δt(n)) du/dt(n)
//! drift      x(n+1) = x(n) + Δt(n) (v(n+½) + w)
//! predict    u(n+1) = u(n+½) + ½ Δt(n) du/dt(n),   at which du/dt(n+1) is evaluated
//! ```
//!
//! u is the velocity, and the pressure under `EdacTvf`; w is the difference of the transport
//! velocity and v. These are the kicks of Adami et al. (2013), Sec. 2.5, with one difference: they
//! evaluate the rates at n+1 with v(n+½). Here they are evaluated with a prediction of v(n+1), so
//! that terms that depend on velocity or pressure are of second order too (test
//! `second_order_on_a_damped_oscillator`). Position and velocity are staggered, so that the rates
//! are evaluated once per step.
//!
//! Under `Wcsph` the pressure depends only on positions, and acoustic waves neither grow nor decay
//! (`mod.rs`). With dissipative terms the scheme is stable for λ Δt ≤ 0.7 up to ω Δt = 1.
//!
//! Under `EdacTvf` an acoustic wave is an oscillation between velocity and pressure. The scheme
//! integrates it like the two-step method of Adams and Bashforth: an undamped oscillation of
//! frequency ω grows by (ω Δt)⁴/4 per step. The damping of the pressure outweighs this. At Δt =
//! 0.25 h/c_s a wave of wave number k grows by 1e-3 (k h)⁴ and is damped by 8e-3 (k h)² for α =
//! 0.5. The gradient sum of the quintic spline resolves no wave beyond k h = 0.88 (test
//! `sound_is_stable_at_the_usual_step`). A purely dissipative term is stable up to λ Δt = 1.

use super::Advance;
use crate::math::real::Real;

/// C_λ under `EdacTvf`: a step is at most C_λ over the largest damping rate.
pub const DAMPING: f64 = 0.3;

/// Kick–drift–kick with the sizes of the present and the previous step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickDrift {
    /// Size of the present step, s.
    pub time_step: f64,
    /// Size of the previous step, s.
    pub previous_time_step: f64,
}

impl KickDrift {
    /// Returns the value at n+½, from the value at n−½ and the rate at n; for a row that needs a
    /// restart from the value at n.
    #[inline(always)]
    pub fn half<R: Real>(&self, needs_restart: bool, present: R, before: R, rate: R) -> R {
        if needs_restart {
            present + R::from_f64(0.5 * self.time_step) * rate
        } else {
            before + R::from_f64(0.5 * (self.time_step + self.previous_time_step)) * rate
        }
    }

    /// Predicts the value at n+1, from the value at n+½ and the rate at n.
    #[inline(always)]
    pub fn predict<R: Real>(&self, half: R, rate: R) -> R {
        half + R::from_f64(0.5 * self.time_step) * rate
    }

    /// Returns the position at n+1, m, from the position at n, the velocity at n+½ and the drift w,
    /// m/s.
    #[inline(always)]
    pub fn position(&self, position: f64, velocity: f64, drift: f64) -> f64 {
        position + self.time_step * (velocity + drift)
    }
}

impl Advance for KickDrift {
    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn friction_span(&self, needs_restart: bool) -> f64 {
        self.time_step + if needs_restart { self.time_step } else { self.previous_time_step }
    }

    #[inline(always)]
    fn advance<R: Real>(
        &self,
        needs_restart: bool,
        position: f64,
        [now, half]: [R; 2],
        acceleration: R,
    ) -> (f64, [R; 2]) {
        let half = self.half(needs_restart, now, half, acceleration);
        (self.position(position, half.to_f64(), 0.0), [self.predict(half, acceleration), half])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates dv/dt = −ω² x − λ v over one unit of time from x = 1 at rest, and returns the
    /// error of x. The step size varies by ±`unevenness`.
    fn oscillator(steps: usize, damping: f64, unevenness: f64) -> f64 {
        let (mut x, mut v, mut half, mut last, mut time) = (1.0, 0.0, 0.0, 0.0, 0.0);
        for step in 0..steps {
            let uneven = 1.0 + unevenness * (std::f64::consts::TAU * step as f64 / steps as f64).sin();
            let scheme = KickDrift { time_step: uneven / steps as f64, previous_time_step: last };
            let rate = -25.0 * x - damping * v;
            half = scheme.half(step == 0, v, half, rate);
            v = scheme.predict(half, rate);
            x = scheme.position(x, half, 0.0);
            last = scheme.time_step;
            time += last;
        }
        let (decay, frequency) = (0.5 * damping, (25.0 - 0.25 * damping * damping).sqrt());
        let exact =
            (-decay * time).exp() * ((frequency * time).cos() + decay / frequency * (frequency * time).sin());
        (x - exact).abs()
    }

    #[test]
    fn second_order_on_a_damped_oscillator() {
        for (damping, unevenness) in [(0.0, 0.0), (2.0, 0.0), (2.0, 0.3)] {
            let order = (oscillator(200, damping, unevenness) / oscillator(400, damping, unevenness)).log2();
            assert!(order > 1.9, "damping {damping}, unevenness {unevenness}: order {order}");
        }
    }

    #[test]
    fn constant_force_is_exact_with_varying_steps() {
        let (mut x, mut v, mut half, mut last, mut time) = (0.0, 0.0, 0.0, 0.0, 0.0);
        for step in 0..30 {
            let scheme = KickDrift { time_step: [0.01, 0.02, 0.005][step % 3], previous_time_step: last };
            half = scheme.half(step == 0, v, half, -3.0);
            v = scheme.predict(half, -3.0);
            x = scheme.position(x, half, 0.0);
            last = scheme.time_step;
            time += last;
        }
        assert!((v + 3.0 * time).abs() < 1e-12 && (x + 1.5 * time * time).abs() < 1e-12, "{v} {x}");
    }

    /// Returns the largest amplitude of dv/dt = κ p, dp/dt = −κ v − δ p over 2000 steps.
    fn acoustic_amplitude(kappa: f64, delta: f64) -> f64 {
        let scheme = KickDrift { time_step: 1.0, previous_time_step: 1.0 };
        let (mut now, mut half, mut largest) = ([1.0, 0.0], [1.0, 0.0], 0.0_f64);
        for step in 0..2000 {
            let rate = [kappa * now[1], -kappa * now[0] - delta * now[1]];
            for i in 0..2 {
                half[i] = scheme.half(step == 0, now[i], half[i], rate[i]);
                now[i] = scheme.predict(half[i], rate[i]);
            }
            largest = largest.max(now[0].hypot(now[1]));
        }
        assert!(now[0].hypot(now[1]) <= largest);
        largest
    }

    #[test]
    fn sound_is_stable_at_the_usual_step() {
        // Up to the largest resolved wave number, in units of h and Δt = 0.25 h/c: κ = 0.25 k h,
        // δ = 0.25 α (k h)²/8.
        for step in 1..=20 {
            let kh = 0.05 * f64::from(step);
            assert!(acoustic_amplitude(0.25 * kh, 0.25 * 0.5 * kh * kh / 8.0) < 1.1, "k h = {kh}");
        }
    }
}
