//! Plane Couette flow from rest.
//!
//! ```text
//! u(y, t) = V y/L + Σ_n (2 V/(n π)) (−1)ⁿ sin(n π y/L) exp(−ν n² π² t/L²),   n = 1, 2, …
//! ```
//!
//! Morris et al. (1997), Eq. 21: the wall at y = 0 is at rest, the wall at y = L moves with V from
//! t = 0 on.

use std::f64::consts::PI;

/// Largest number of terms: enough for 1e-12 of V from t = 1e-4 L²/ν on.
const TERMS: u32 = 2000;

/// Returns the velocity, m/s, at height y (m) above the wall at rest and time t (s).
///
/// `gap` L in m, `velocity` V in m/s, `viscosity` ν in m²/s.
pub fn startup_velocity(y: f64, t: f64, gap: f64, velocity: f64, viscosity: f64) -> f64 {
    let mut sum = velocity * y / gap;
    for n in 1..TERMS {
        let k = f64::from(n) * PI;
        let decay = (-viscosity * k * k * t / (gap * gap)).exp();
        if decay < 1e-17 {
            break;
        }
        let sign = if n % 2 == 0 { 1.0 } else { -1.0 };
        sum += sign * 2.0 * velocity / k * (k * y / gap).sin() * decay;
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::*;

    const GAP: f64 = 1e-3;
    const SPEED: f64 = 1.25e-5;
    const NU: f64 = 1e-6;

    fn u(y: f64, t: f64) -> f64 {
        startup_velocity(y, t, GAP, SPEED, NU)
    }

    #[test]
    fn satisfies_the_diffusion_equation_and_the_wall_velocities() {
        let (dy, dt) = (1e-6, 1e-5);
        for t in [0.02, 0.1, 0.4] {
            assert!(u(0.0, t).abs() < 1e-18 && (u(GAP, t) - SPEED).abs() < 1e-18);
            for y in [2e-4, 5e-4, 9e-4] {
                let rate = (u(y, t + dt) - u(y, t - dt)) / (2.0 * dt);
                let curvature = (u(y + dy, t) - 2.0 * u(y, t) + u(y - dy, t)) / (dy * dy);
                assert!((rate - NU * curvature).abs() < 1e-5 * SPEED / 0.1, "at {y}, {t}");
            }
        }
    }

    #[test]
    fn starts_at_rest_and_ends_linear() {
        assert!(u(0.5 * GAP, 1e-4).abs() < 1e-12 * SPEED);
        assert!((u(0.3 * GAP, 10.0) - 0.3 * SPEED).abs() < 1e-12 * SPEED);
    }
}
