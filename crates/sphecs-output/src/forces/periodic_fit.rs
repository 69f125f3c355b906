//! Amplitude of a coefficient by a periodic function fitted to it.
//!
//! ```text
//! c(t) ≈ b_0 + b_1 t + Σ_{k=1}^{4} (p_k cos 2πk f t + q_k sin 2πk f t)
//! ```
//!
//! Least squares over all rows, f being the frequency of vortex shedding. The amplitude is half of
//! the largest minus the smallest value of the sum over a period. The drag of a cylinder oscillates
//! with 2 f. Sound and noise do not repeat with f, so that they average out over the interval.

use std::f64::consts::TAU;

use sphecs_core::math::linear::solve;

/// Harmonics of the fit.
const HARMONICS: usize = 4;

/// Unknowns of the fit.
const UNKNOWNS: usize = 2 + 2 * HARMONICS;

/// Points of a period at which the fitted function is evaluated.
const POINTS: usize = 720;

/// Returns the amplitude of values at times, s, by a fit with a frequency, 1/s; NaN with less than
/// two rows per period of the highest harmonic, or if the values are not finite.
pub fn fitted_amplitude(times: &[f64], values: &[f64], frequency: f64) -> f64 {
    let (Some(first), Some(last)) = (times.first(), times.last()) else { return f64::NAN };
    let length = last - first;
    if times.len() < UNKNOWNS || (times.len() as f64) < 2.0 * HARMONICS as f64 * frequency * length {
        return f64::NAN;
    }
    let (mut matrix, mut right) = ([[0.0; UNKNOWNS]; UNKNOWNS], [0.0; UNKNOWNS]);
    for (t, value) in times.iter().zip(values) {
        let basis = basis(2.0 * (t - first) / length - 1.0, TAU * frequency * (t - first));
        for ((row, right), a) in matrix.iter_mut().zip(&mut right).zip(basis) {
            for (sum, b) in row.iter_mut().zip(basis) {
                *sum += a * b;
            }
            *right += a * value;
        }
    }
    let Some(solution) = solve(matrix, right) else { return f64::NAN };
    let at = |k: usize| {
        let basis = basis(0.0, TAU * k as f64 / POINTS as f64);
        (2..UNKNOWNS).map(|i| basis[i] * solution[i]).sum::<f64>()
    };
    let (low, high) = (0..POINTS).map(at).fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| {
        // `min` and `max` would hide a force that is not finite.
        if value.is_nan() { (f64::NAN, f64::NAN) } else { (low.min(value), high.max(value)) }
    });
    0.5 * (high - low)
}

/// Returns 1, the time from −1 to 1, and the cosines and sines of multiples of a phase.
fn basis(time: f64, phase: f64) -> [f64; UNKNOWNS] {
    let (s, c) = phase.sin_cos();
    let mut basis = [0.0; UNKNOWNS];
    (basis[0], basis[1]) = (1.0, time);
    let mut turned = [c, s];
    for pair in basis[2..].chunks_exact_mut(2) {
        pair.copy_from_slice(&turned);
        turned = [turned[0] * c - turned[1] * s, turned[0] * s + turned[1] * c];
    }
    basis
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amplitude_is_that_of_the_periodic_part() {
        let times: Vec<f64> = (0..4000).map(|k| 0.01 * (f64::from(k) + 0.3 * f64::from(k % 3))).collect();
        let of = |value: fn(f64) -> f64, frequency: f64| {
            let values: Vec<f64> = times.iter().copied().map(value).collect();
            fitted_amplitude(&times, &values, frequency)
        };
        // 7.7 periods, which whole-period means would not separate.
        let lift = of(|t| 0.02 * t + 0.7 * (TAU * 0.1921 * t + 1.0).sin(), 0.1921);
        assert!((lift - 0.7).abs() < 1e-4, "{lift}");
        let drag = of(|t| 1.4 + 0.05 * (TAU * 2.0 * 0.1921 * t).cos(), 0.1921);
        assert!((drag - 0.05).abs() < 1e-5, "{drag}");
        // Sound of twice the amplitude, between harmonics.
        let noisy = of(|t| 0.7 * (TAU * 0.1921 * t).sin() + 1.4 * (TAU * 3.07 * t).sin(), 0.1921);
        assert!((noisy - 0.7).abs() < 0.02, "{noisy}");
    }

    #[test]
    fn few_rows_and_values_that_are_not_finite_give_nan() {
        let times: Vec<f64> = (0..40).map(f64::from).collect();
        assert!(fitted_amplitude(&times, &[0.0; 40], 0.2).is_nan());
        assert!(fitted_amplitude(&times, &[f64::NAN; 40], 0.05).is_nan());
        assert!(fitted_amplitude(&[], &[], 0.05).is_nan());
    }
}
