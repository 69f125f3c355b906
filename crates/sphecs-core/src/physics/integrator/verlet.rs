//! Verlet's scheme with a corrective step.
//!
//! ```text
//! leapfrog   v(n+1) = v(n−1) + (Δt(n−1) + Δt(n)) dv/dt(n)
//! plain      v(n+1) = v(n) + Δt(n) dv/dt(n)
//! position   x(n+1) = x(n) + Δt(n) v(n) + ½ Δt(n)² dv/dt(n)
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 16 and 17. They write 2 Δt for a constant step; with a varying one
//! the interval between n−1 and n+1 is Δt(n−1) + Δt(n), and 2 Δt(n) would accelerate a particle under a
//! constant force wrongly (test `constant_force_is_exact_with_varying_steps`). The plain step replaces the
//! leapfrog every so many steps, and for a particle whose role has just changed, whose v(n−1) means nothing.
//!
//! The viscous terms of a leapfrog step take the velocities at n−1, those of a plain step the velocities at n. A leapfrog that
//! damps with v(n) has a second solution that grows as exp(λ t) until the next plain step cuts it back: with a plain step
//! every 50 steps it holds only below 0.0125 h²/ν, and not next to a wall, whose images damp faster
//! than the fluid (a Poiseuille flow at h = 2.2 Δ blew up in 0.04 s). Damped with v(n−1) it decays for
//! λ Δt < 1 (test `viscous_decay_is_stable_without_plain_steps`), at the same cost.

use super::Advance;
use crate::math::real::Real;

/// Sizes of the present and the previous step, and whether all particles take a plain one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Verlet {
    /// Size of the present step, s.
    pub time_step: f64,
    /// Size of the previous step, s.
    pub time_step_before: f64,
    /// Whether every particle takes a plain step.
    pub plain: bool,
}

impl Verlet {
    /// Velocity at n+1, m/s, from that at n and n−1 and the acceleration at n, m/s².
    #[inline(always)]
    pub fn velocity<R: Real>(&self, fresh: bool, velocity: R, velocity_before: R, acceleration: R) -> R {
        if self.plain || fresh {
            velocity + R::from_f64(self.time_step) * acceleration
        } else {
            velocity_before + R::from_f64(self.time_step + self.time_step_before) * acceleration
        }
    }

    /// Position at n+1, m, from position and velocity at n and the acceleration at n, m/s².
    #[inline(always)]
    pub fn position(&self, position: f64, velocity: f64, acceleration: f64) -> f64 {
        position + self.time_step * (velocity + 0.5 * self.time_step * acceleration)
    }
}

impl Advance for Verlet {
    fn time_step(&self) -> f64 {
        self.time_step
    }

    fn friction_span(&self, fresh: bool) -> f64 {
        if self.plain || fresh { self.time_step } else { self.time_step + self.time_step_before }
    }

    #[inline(always)]
    fn advance<R: Real>(
        &self,
        fresh: bool,
        position: f64,
        [now, before]: [R; 2],
        acceleration: R,
    ) -> (f64, [R; 2]) {
        let next = self.velocity(fresh, now, before, acceleration);
        (self.position(position, now.to_f64(), acceleration.to_f64()), [next, now])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Integrates dv/dt = f(x, v) from rest at x0 over one unit of time with steps from `sizes`, repeated.
    fn integrate(x0: f64, sizes: &[f64], plain_every: usize, f: impl Fn(f64, f64) -> f64) -> (f64, f64, f64) {
        let (mut x, mut v, mut before, mut time, mut last) = (x0, 0.0, 0.0, 0.0, 0.0);
        let mut step = 0;
        while time < 1.0 - 1e-12 {
            let scheme = Verlet {
                time_step: sizes[step % sizes.len()],
                time_step_before: last,
                plain: step.is_multiple_of(plain_every),
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
    fn viscous_decay_is_stable_without_plain_steps() {
        let (rate, time_step) = (100.0, 0.004);
        let scheme = Verlet { time_step, time_step_before: time_step, plain: false };
        let (mut before, mut now) = (1.0, (-rate * time_step).exp());
        for step in 0..1000 {
            let next = scheme.velocity(false, now, before, -rate * before);
            (before, now) = (now, next);
            assert!(now.abs() <= 1.0, "step {step}: {now}");
        }
        assert!(now.abs() < 1e-12, "{now}");
    }

    #[test]
    fn a_fresh_particle_ignores_its_past() {
        let scheme = Verlet { time_step: 0.1, time_step_before: 0.1, plain: false };
        assert_eq!(scheme.velocity(true, 2.0, 99.0, 1.0), 2.1);
    }
}
