//! Frequency of an unevenly sampled lift coefficient by a least-squares periodogram.
//!
//! ```text
//! P(f) = [Σ y cos ω(t − τ)]²/Σ cos² ω(t − τ) + [Σ y sin ω(t − τ)]²/Σ sin² ω(t − τ),
//! tan 2ωτ = Σ sin 2ωt/Σ cos 2ωt
//! ```
//!
//! Lomb (1976), Scargle (1982), of y minus its mean. Time steps vary, so a Fourier transform would
//! need the rows interpolated to even times first. P is the reduction of Σ y² by a fitted sine of
//! the frequency f.

use std::f64::consts::PI;

/// Largest number of rows: longer series are averaged in groups, still far shorter than a period.
const MAX_ROWS: usize = 4096;

/// Trial frequencies per frequency resolution of the series, 1/(length of the series).
const OVERSAMPLING: f64 = 8.0;

/// Returns the frequency, 1/s, with the largest power in a series of times (s) and values.
///
/// None with less than two periods or without oscillation.
pub fn dominant_frequency(times: &[f64], values: &[f64]) -> Option<f64> {
    let (times, values) = averaged(times, values);
    let length = times.last()? - times.first()?;
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let values: Vec<f64> = values.iter().map(|value| value - mean).collect();
    let squares: f64 = values.iter().map(|value| value * value).sum();
    // Smaller sums are rounding errors.
    if times.len() < 8 || length.is_nan() || length <= 0.0 || squares <= 1e-24 * mean * mean || squares == 0.0
    {
        return None;
    }
    let step = 1.0 / (OVERSAMPLING * length);
    // From two periods to four rows a period.
    let first = (2.0 * OVERSAMPLING) as usize;
    let last = (OVERSAMPLING * times.len() as f64 / 4.0) as usize;
    let power = |frequency: f64| periodogram(&times, &values, frequency);
    let found: Vec<f64> = (first..=last).map(|k| power(k as f64 * step)).collect();
    let best = (0..found.len()).max_by(|&a, &b| found[a].total_cmp(&found[b]))?;
    // A power that decreases from the lowest frequency on is a drift.
    if best == 0 {
        return None;
    }
    let middle = (first + best) as f64 * step;
    Some(peak(power, middle - step, middle + step))
}

/// Returns the means of groups of rows, at most [`MAX_ROWS`] of them.
fn averaged(times: &[f64], values: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let size = times.len().div_ceil(MAX_ROWS).max(1);
    let means = |numbers: &[f64]| {
        numbers.chunks_exact(size).map(|group| group.iter().sum::<f64>() / size as f64).collect()
    };
    (means(times), means(values))
}

/// Returns the power of a frequency.
fn periodogram(times: &[f64], values: &[f64], frequency: f64) -> f64 {
    let omega = 2.0 * PI * frequency;
    let (sine, cosine) = times.iter().fold((0.0, 0.0), |(sine, cosine), t| {
        let (s, c) = (2.0 * omega * t).sin_cos();
        (sine + s, cosine + c)
    });
    let shift = 0.5 * f64::atan2(sine, cosine);
    let mut sums = [0.0; 4];
    for (t, y) in times.iter().zip(values) {
        let (s, c) = (omega * t - shift).sin_cos();
        for (sum, term) in sums.iter_mut().zip([y * c, c * c, y * s, s * s]) {
            *sum += term;
        }
    }
    let part = |product: f64, square: f64| if square > 0.0 { product * product / square } else { 0.0 };
    part(sums[0], sums[1]) + part(sums[2], sums[3])
}

/// Returns the maximum of a function that has one between `low` and `high`, by golden-section
/// search.
fn peak(power: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
    for _ in 0..40 {
        let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
        if power(a) < power(b) { low = a } else { high = b }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Times with steps that vary by a half, as after a start.
    fn times(count: u32, step: f64) -> Vec<f64> {
        (0..count).map(|k| step * (f64::from(k) + 0.25 * f64::from(k % 7) / 7.0)).collect()
    }

    #[test]
    fn frequency_of_a_sine_is_found_in_uneven_rows() {
        for (count, step, frequency) in [(600, 0.1, 0.2053), (50_000, 0.002, 0.1021), (300, 0.05, 1.37)] {
            let times = times(count, step);
            let lift = |t: &f64| 0.7 * (2.0 * PI * frequency * t + 0.4).sin() + 0.1 + 0.05 * (40.0 * t).cos();
            let values: Vec<f64> = times.iter().map(lift).collect();
            let found = dominant_frequency(&times, &values).expect("a frequency");
            assert!((found / frequency - 1.0).abs() < 2e-3, "{found}, not {frequency}");
        }
    }

    #[test]
    fn constant_and_drift_have_no_frequency() {
        let times = times(500, 0.1);
        assert_eq!(dominant_frequency(&times, &vec![2.0; 500]), None);
        let drift: Vec<f64> = times.iter().map(|t| 0.3 * t).collect();
        assert_eq!(dominant_frequency(&times, &drift), None);
        assert_eq!(dominant_frequency(&times[..3], &drift[..3]), None);
        assert_eq!(dominant_frequency(&[], &[]), None);
    }
}
