//! Developed laminar flow in a rectangular duct, |y| ≤ a, |z| ≤ b.
//!
//! ```text
//! u = (16 f a²/(ν π³)) Σ_i (−1)^((i−1)/2) [1 − cosh(i π z/2a)/cosh(i π b/2a)]
//!     cos(i π y/2a)/i³,   i = 1, 3, 5, …
//! ```
//!
//! Shah & London (1978), chapter VII, with the force per mass f in place of the pressure gradient
//! over ρ.

use std::f64::consts::PI;

/// Number of odd terms: the last is below 1e-7 of the first.
const TERMS: usize = 120;

/// Returns the velocity, m/s, at (y, z), m, for half widths a and b, m, and force per mass over
/// viscosity, 1/(m s).
pub fn developed_velocity(y: f64, z: f64, a: f64, b: f64, force_over_viscosity: f64) -> f64 {
    let odd = (0..TERMS).map(|n| (2 * n + 1) as f64);
    let sum: f64 = odd
        .map(|i| {
            let k = i * PI / (2.0 * a);
            // cosh(k z)/cosh(k b) without overflow.
            let ratio =
                ((k * (z.abs() - b)).exp() + (-k * (z.abs() + b)).exp()) / (1.0 + (-2.0 * k * b).exp());
            let sign = if (i as usize / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * (1.0 - ratio) * (k * y).cos() / i.powi(3)
        })
        .sum();
    16.0 / PI.powi(3) * force_over_viscosity * a * a * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns the mean over the section by the midpoint rule.
    fn mean(a: f64, b: f64, drive: f64) -> f64 {
        let n = 200;
        let at = |i: usize, half: f64| ((i as f64 + 0.5) / n as f64 * 2.0 - 1.0) * half;
        (0..n * n).map(|k| developed_velocity(at(k % n, a), at(k / n, b), a, b, drive)).sum::<f64>()
            / (n * n) as f64
    }

    #[test]
    fn square_duct_has_the_published_peak_and_friction() {
        // Shah & London (1978): peak over mean 2.0963, f Re = 56.91, so the mean is 2 G D²/(56.91
        // μ).
        let found = mean(0.3, 0.3, 7.0);
        let peak = developed_velocity(0.0, 0.0, 0.3, 0.3, 7.0);
        assert!((peak / found - 2.09626).abs() < 1e-3, "{}", peak / found);
        assert!((found / (2.0 * 7.0 * 0.6 * 0.6 / 56.90832) - 1.0).abs() < 1e-4, "{found}");
    }

    #[test]
    fn flat_duct_has_plane_poiseuille_flow() {
        for y in [0.0, 0.03, 0.08] {
            let found = developed_velocity(y, 0.0, 0.1, 100.0, 4.0);
            let expected = 2.0 * (0.1 * 0.1 - y * y);
            assert!((found / expected - 1.0).abs() < 1e-6, "{found}, not {expected}");
        }
    }

    #[test]
    fn velocity_vanishes_at_the_walls() {
        assert!(developed_velocity(0.2, 0.1, 0.2, 0.3, 1.0).abs() < 1e-12);
        assert!(developed_velocity(0.05, 0.3, 0.2, 0.3, 1.0).abs() < 1e-12);
    }
}
