//! Developed laminar flow in a rectangular duct, |y| ≤ a, |z| ≤ b.
//!
//! ```text
//! u = (16 G a²/(μ π³)) Σ_i (−1)^((i−1)/2) [1 − cosh(i π z/2a)/cosh(i π b/2a)] cos(i π y/2a)/i³,   i = 1, 3, 5, …
//! ū = (G a²/(3 μ)) [1 − (192 a/(π⁵ b)) Σ_i tanh(i π b/2a)/i⁵]
//! ```
//!
//! White (1991), Eqs. 3-48, with the pressure gradient G that gives the mean velocity ū asked for.

use std::f64::consts::PI;

/// Odd terms: the last is below 1e-7 of the first in the profile, 1e-11 in the mean.
const TERMS: usize = 120;

/// Velocity, m/s, at (y, z), m, for half edges a and b, m, and a mean velocity, m/s.
pub fn developed_velocity(y: f64, z: f64, a: f64, b: f64, mean: f64) -> f64 {
    let odd = || (0..TERMS).map(|n| (2 * n + 1) as f64);
    let flux: f64 = odd().map(|i| (i * PI * b / (2.0 * a)).tanh() / i.powi(5)).sum();
    // G a²/μ.
    let drive = 3.0 * mean / (1.0 - 192.0 * a / (PI.powi(5) * b) * flux);
    let sum: f64 = odd()
        .map(|i| {
            let k = i * PI / (2.0 * a);
            // cosh(k z)/cosh(k b) without overflow.
            let ratio =
                ((k * (z.abs() - b)).exp() + (-k * (z.abs() + b)).exp()) / (1.0 + (-2.0 * k * b).exp());
            let sign = if (i as usize / 2).is_multiple_of(2) { 1.0 } else { -1.0 };
            sign * (1.0 - ratio) * (k * y).cos() / i.powi(3)
        })
        .sum();
    16.0 / PI.powi(3) * drive * sum
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_has_the_known_ratio_of_peak_to_mean() {
        // White (1991), Table 3-5: 2.0963 for the square.
        let peak = developed_velocity(0.0, 0.0, 0.3, 0.3, 1.0);
        assert!((peak - 2.09626).abs() < 1e-4, "{peak}");
    }

    #[test]
    fn a_flat_duct_is_plane_poiseuille_flow() {
        for y in [0.0, 0.03, 0.08] {
            let found = developed_velocity(y, 0.0, 0.1, 100.0, 1.0);
            // The mean of a duct of finite width is a little below that between plates.
            let expected = 1.5 * (1.0 - (y / 0.1_f64).powi(2));
            assert!((found / expected - 1.0).abs() < 1e-3, "{found}, not {expected}");
        }
    }

    #[test]
    fn walls_hold_the_flow_and_its_mean_is_the_given_one() {
        let (a, b) = (0.2, 0.3);
        assert!(developed_velocity(0.2, 0.1, a, b, 1.0).abs() < 1e-12);
        assert!(developed_velocity(0.05, 0.3, a, b, 1.0).abs() < 1e-6);
        let n = 200;
        let at = |i: usize, half: f64| ((i as f64 + 0.5) / n as f64 * 2.0 - 1.0) * half;
        let sum: f64 = (0..n * n).map(|k| developed_velocity(at(k % n, a), at(k / n, b), a, b, 1.0)).sum();
        assert!((sum / (n * n) as f64 - 1.0).abs() < 1e-4);
    }
}
