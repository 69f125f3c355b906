//! Verlet's scheme with a corrective step.
//!
//! ```text
//! leapfrog     v(n+1) = v(n−1) + (Δt(n−1) + Δt(n)) dv/dt(n)
//! corrective   v(n+1) = v(n) + Δt(n) dv/dt(n)
//! position     x(n+1) = x(n) + Δt(n) v(n) + ½ Δt(n)² dv/dt(n)
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 16 and 17. They write 2 Δt for a constant step. With a
//! varying step the interval between n−1 and n+1 is Δt(n−1) + Δt(n), and 2 Δt(n) would give a wrong
//! velocity under a constant force (test `constant_force_is_exact_with_varying_steps`). The
//! corrective (Euler) step replaces the leapfrog at regular intervals, and for a particle whose
//! role has just changed, since its v(n−1) is not that of the fluid.
//!
//! The viscous terms use the velocities at n−1 in a leapfrog step and those at n in a corrective
//! step. A leapfrog damped with v(n) has a second solution that grows as exp(λ t) until the next
//! corrective step. With a corrective step every 50 steps it is stable only below 0.0125 h²/ν. Next
//! to a wall, whose images damp faster than the fluid, it is unstable (a Poiseuille flow at h = 2.2
//! Δ diverged within 0.04 s). Damped with v(n−1) it decays for λ Δt < 1 (test
//! `viscous_decay_is_stable_without_corrective_steps`), at the same cost.

use super::Advance;
use crate::math::real::Real;

/// Verlet's scheme with the sizes of the present and the previous step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verlet {
    /// Size of the present step, s.
    pub time_step: f64,
    /// Size of the previous step, s.
    pub previous_time_step: f64,
    /// True if every particle takes a corrective step.
    pub is_corrective: bool,
}

impl Verlet {
    /// Returns the velocity at n+1, m/s, from those at n and n−1, m/s, and the acceleration at n,
    /// m/s².
    #[inline(always)]
    pub fn velocity<R: Real>(
        &self,
        needs_restart: bool,
        velocity: R,
        previous_velocity: R,
        acceleration: R,
    ) -> R {
        if self.is_corrective || needs_restart {
            velocity + R::from_f64(self.time_step) * acceleration
        } else {
            previous_velocity + R::from_f64(self.time_step + self.previous_time_step) * acceleration
        }
    }

    /// Returns the position at n+1, m, from position, velocity and acceleration at n.
    #[inline(always)]
    pub fn position(&self, position: f64, velocity: f64, acceleration: f64) -> f64 {
        position + self.time_step * (velocity + 0.5 * self.time_step * acceleration)
    }
}

impl Advance for Verlet {
    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn friction_span(&self, needs_restart: bool) -> f64 {
        if self.is_corrective || needs_restart {
            self.time_step
        } else {
            self.time_step + self.previous_time_step
        }
    }

    #[inline(always)]
    fn advance<R: Real>(
        &self,
        needs_restart: bool,
        position: f64,
        [now, previous]: [R; 2],
        acceleration: R,
    ) -> (f64, [R; 2]) {
        let next = self.velocity(needs_restart, now, previous, acceleration);
        (self.position(position, now.to_f64(), acceleration.to_f64()), [next, now])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates dv/dt = f(x, v) from rest at x0 over one unit of time with steps from `sizes`,
    /// repeated.
    fn integrate(
        x0: f64,
        sizes: &[f64],
        corrective_every: usize,
        f: impl Fn(f64, f64) -> f64,
    ) -> (f64, f64, f64) {
        let (mut x, mut v, mut before, mut time, mut last) = (x0, 0.0, 0.0, 0.0, 0.0);
        let mut step = 0;
        while time < 1.0 - 1e-12 {
            let scheme = Verlet {
                time_step: sizes[step % sizes.len()],
                previous_time_step: last,
                is_corrective: step.is_multiple_of(corrective_every),
            };
            let a = f(x, v);
            let next = scheme.velocity(false, v, before, a);
            x = scheme.position(x, v, a);
            (before, v) = (v, next);
            last = scheme.time_step;
            time += last;
            step += 1;
        }
        (x, v, time)
    }

    #[test]
    fn constant_force_is_exact_with_varying_steps() {
        let (x, v, time) = integrate(0.0, &[0.01, 0.02, 0.005], 50, |_, _| -3.0);
        assert!((v + 3.0 * time).abs() < 1e-12, "v = {v}");
        assert!((x + 1.5 * time * time).abs() < 1e-12, "x = {x}");
    }

    #[test]
    fn second_order_on_an_oscillator() {
        let error = |n: usize| {
            let (x, _, time) = integrate(1.0, &[1.0 / n as f64], usize::MAX, |x, _| -25.0 * x);
            (x - (5.0 * time).cos()).abs()
        };
        let order = (error(200) / error(400)).log2();
        assert!(order > 1.8, "observed order {order}");
    }

    #[test]
    fn viscous_decay_is_stable_without_corrective_steps() {
        let (rate, time_step) = (100.0, 0.004);
        let scheme = Verlet { time_step, previous_time_step: time_step, is_corrective: false };
        let (mut before, mut now) = (1.0, (-rate * time_step).exp());
        for step in 0..1000 {
            let next = scheme.velocity(false, now, before, -rate * before);
            (before, now) = (now, next);
            assert!(now.abs() <= 1.0, "step {step}: {now}");
        }
        assert!(now.abs() < 1e-12, "{now}");
    }

    #[test]
    fn particle_that_needs_a_restart_ignores_its_previous_velocity() {
        let scheme = Verlet { time_step: 0.1, previous_time_step: 0.1, is_corrective: false };
        assert_eq!(scheme.velocity(true, 2.0, 99.0, 1.0), 2.1);
    }
}
