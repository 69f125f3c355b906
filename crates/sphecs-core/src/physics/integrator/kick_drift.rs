//! Kick–drift–kick with one evaluation of the rates per step.
//!
//! ```text
//! half    u(n+½) = u(n−½) + ½ (Δt(n−1) + Δt(n)) du/dt(n)
//! drift   x(n+1) = x(n) + Δt(n) (v(n+½) + w)
//! guess   u(n+1) = u(n+½) + ½ Δt(n) du/dt(n),   from which du/dt(n+1) is found
//! ```
//!
//! u is the velocity and the evolved pressure, w what the transport velocity has beyond v. The kicks of
//! Adami et al. (2013), Sec. 2.5, with one difference: there the rates at n+1 are found with v(n+½), here with a guess
//! at v(n+1), so that the terms that depend on velocity and pressure themselves are of second order too (test
//! `second_order_on_a_damped_oscillator`). Position and velocity are staggered, so that nothing is evaluated twice.
//!
//! Under `Wcsph` the pressure is a matter of positions, and sound neither grows nor decays (`mod.rs`). Dissipative terms beside it are stable to
//! λ Δt = 0.7 up to ω Δt = 1.
//!
//! Where the pressure evolves, velocity and pressure alone, in which sound swings, are integrated as by the two-step scheme of Adams and Bashforth: an
//! undamped oscillation of frequency ω grows by (ω Δt)⁴/4 per step. The pressure's own damping outweighs that: at
//! Δt = 0.25 h/c_s sound of wave number k grows by 1e-3 (k h)⁴ and is damped by 8e-3 (k h)² for α = 0.5, and the gradient sum of the
//! quintic spline gives no wave more than k h = 0.88 (test `sound_is_stable_at_the_usual_step`). A purely dissipative term is stable up to λ Δt = 1.

use super::Advance;
use crate::math::real::Real;

/// C_λ where the pressure evolves: a step is at most this over the largest damping rate.
pub const DAMPING: f64 = 0.3;

/// Sizes of the present and the previous step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct KickDrift {
    /// Size of the present step, s.
    pub time_step: f64,
    /// Size of the previous step, s.
    pub time_step_before: f64,
}

impl KickDrift {
    /// The value at n+½, from that at n−½, or at n for a row that is `fresh`, and its rate at n.
    #[inline(always)]
    pub fn half<R: Real>(&self, fresh: bool, present: R, before: R, rate: R) -> R {
        if fresh {
            present + R::from_f64(0.5 * self.time_step) * rate
        } else {
            before + R::from_f64(0.5 * (self.time_step + self.time_step_before)) * rate
        }
    }

    /// The guess at the value at n+1, from that at n+½ and the rate at n.
    #[inline(always)]
    pub fn guess<R: Real>(&self, half: R, rate: R) -> R {
        half + R::from_f64(0.5 * self.time_step) * rate
    }

    /// Position at n+1, m, from that at n, the velocity at n+½ and the drift w, m/s.
    #[inline(always)]
    pub fn position(&self, position: f64, velocity: f64, drift: f64) -> f64 {
        position + self.time_step * (velocity + drift)
    }
}

impl Advance for KickDrift {
    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn friction_span(&self, fresh: bool) -> f64 {
        self.time_step + if fresh { self.time_step } else { self.time_step_before }
    }

    #[inline(always)]
    fn advance<R: Real>(
        &self,
        fresh: bool,
        position: f64,
        [now, half]: [R; 2],
        acceleration: R,
    ) -> (f64, [R; 2]) {
        let half = self.half(fresh, now, half, acceleration);
        (self.position(position, half.to_f64(), 0.0), [self.guess(half, acceleration), half])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates dv/dt = −ω² x − λ v over one unit of time from x = 1 at rest, with steps that swing by `unevenness`.
    fn oscillator(steps: usize, damping: f64, unevenness: f64) -> f64 {
        let (mut x, mut v, mut half, mut last, mut time) = (1.0, 0.0, 0.0, 0.0, 0.0);
        for step in 0..steps {
            let uneven = 1.0 + unevenness * (std::f64::consts::TAU * step as f64 / steps as f64).sin();
            let scheme = KickDrift { time_step: uneven / steps as f64, time_step_before: last };
            let rate = -25.0 * x - damping * v;
            half = scheme.half(step == 0, v, half, rate);
            v = scheme.guess(half, rate);
            x = scheme.position(x, half, 0.0);
            last = scheme.time_step;
            time += last;
        }
        let (decay, swing) = (0.5 * damping, (25.0 - 0.25 * damping * damping).sqrt());
        let exact = (-decay * time).exp() * ((swing * time).cos() + decay / swing * (swing * time).sin());
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
            let scheme = KickDrift { time_step: [0.01, 0.02, 0.005][step % 3], time_step_before: last };
            half = scheme.half(step == 0, v, half, -3.0);
            v = scheme.guess(half, -3.0);
            x = scheme.position(x, half, 0.0);
            last = scheme.time_step;
            time += last;
        }
        assert!((v + 3.0 * time).abs() < 1e-12 && (x + 1.5 * time * time).abs() < 1e-12, "{v} {x}");
    }

    /// Largest amplitude of dv/dt = κ p, dp/dt = −κ v − δ p over 2000 steps.
    fn sound(kappa: f64, delta: f64) -> f64 {
        let scheme = KickDrift { time_step: 1.0, time_step_before: 1.0 };
        let (mut now, mut half, mut largest) = ([1.0, 0.0], [1.0, 0.0], 0.0_f64);
        for step in 0..2000 {
            let rate = [kappa * now[1], -kappa * now[0] - delta * now[1]];
            for i in 0..2 {
                half[i] = scheme.half(step == 0, now[i], half[i], rate[i]);
                now[i] = scheme.guess(half[i], rate[i]);
            }
            largest = largest.max(now[0].hypot(now[1]));
        }
        assert!(now[0].hypot(now[1]) <= largest);
        largest
    }

    #[test]
    fn sound_is_stable_at_the_usual_step() {
        // Up to what a gradient sum gives, in units of h and Δt = 0.25 h/c: κ = 0.25 k h, δ = 0.25 α (k h)²/8.
        for step in 1..=20 {
            let kh = 0.05 * f64::from(step);
            assert!(sound(0.25 * kh, 0.25 * 0.5 * kh * kh / 8.0) < 1.1, "k h = {kh}");
        }
    }
}
