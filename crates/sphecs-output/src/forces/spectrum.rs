//! Amplitude spectrum of an unevenly sampled coefficient.
//!
//! ```text
//! a(f) = 2 |Σ w_k y_k exp(−2πi f t_k)|/Σ w_k,   w_k = h(t_k) Δt_k,   h = (1 − cos 2π(t − t_0)/T)/2
//! ```
//!
//! y is the series minus its linear trend, T its length, h the window of Hann. A sine of amplitude
//! A at f has a(f) = A. Without the window, a drift that is not linear would leak into all
//! frequencies. Times are uneven, so the sum has the weights Δt_k of an integral.

use std::f64::consts::TAU;

/// Largest number of rows after averaging in groups.
const MAX_ROWS: usize = 16_384;

/// Rows per period of the highest frequency of interest after averaging.
const ROWS_PER_PERIOD: f64 = 32.0;

/// Least number of rows of a spectrum.
const LEAST_ROWS: usize = 32;

/// Trial frequencies per frequency resolution of the series, 1/T.
const OVERSAMPLING: f64 = 4.0;

/// Half the width of a line in the spectrum over 1/T: beyond, the window has removed it.
pub const HALF_WIDTH: f64 = 2.5;

/// Series without its trend, with the weights of its rows.
#[derive(Clone, Debug)]
pub struct Series {
    times: Vec<f64>,
    values: Vec<f64>,
    weights: Vec<f64>,
    /// Length T, s.
    pub length: f64,
    /// True if only rounding errors are left after the trend.
    pub is_constant: bool,
}

impl Series {
    /// Returns the series of times, s, and values for frequencies up to `highest`, 1/s; None with
    /// less than 32 rows.
    ///
    /// Rows are averaged in groups that are much shorter than a period of `highest`.
    pub fn new(times: &[f64], values: &[f64], highest: f64) -> Option<Self> {
        let length = times.last()? - times.first()?;
        if times.len() < LEAST_ROWS || length.is_nan() || length <= 0.0 {
            return None;
        }
        let wanted = (ROWS_PER_PERIOD * highest * length).clamp(LEAST_ROWS as f64, MAX_ROWS as f64);
        let size = (times.len() / wanted as usize).max(1);
        let means = |numbers: &[f64]| -> Vec<f64> {
            numbers.chunks_exact(size).map(|group| group.iter().sum::<f64>() / size as f64).collect()
        };
        let (times, mut values) = (means(times), means(values));
        let squares = |values: &[f64]| values.iter().map(|value| value * value).sum::<f64>();
        let before = squares(&values);
        remove_trend(&times, &mut values);
        // Sums of this size are rounding errors of the mean and of the trend.
        let is_constant = squares(&values) <= 1e-22 * before;
        let last = times.len() - 1;
        let weight = |k: usize| {
            let interval = times[(k + 1).min(last)] - times[k.saturating_sub(1)];
            interval * (1.0 - (TAU * (times[k] - times[0]) / (times[last] - times[0])).cos())
        };
        let weights = (0..=last).map(weight).collect();
        Some(Self { times, values, weights, length, is_constant })
    }

    /// Returns the highest frequency with four rows a period, 1/s.
    pub fn resolved(&self) -> f64 {
        self.times.len() as f64 / (4.0 * self.length)
    }

    /// Returns the squared amplitude at a frequency, 1/s.
    pub fn power(&self, frequency: f64) -> f64 {
        let mut sums = [0.0; 3];
        for ((t, y), w) in self.times.iter().zip(&self.values).zip(&self.weights) {
            let (s, c) = (TAU * frequency * (t - self.times[0])).sin_cos();
            for (sum, term) in sums.iter_mut().zip([w * y * c, w * y * s, *w]) {
                *sum += term;
            }
        }
        4.0 * (sums[0] * sums[0] + sums[1] * sums[1]) / (sums[2] * sums[2])
    }

    /// Returns frequencies, 1/s, from 1/T to `highest` in steps of 1/(4 T), and their squared
    /// amplitudes.
    pub fn spectrum(&self, highest: f64) -> Vec<(f64, f64)> {
        let step = 1.0 / (OVERSAMPLING * self.length);
        let count = (highest.min(self.resolved()) / step) as usize;
        let total: f64 = self.weights.iter().sum();
        // Each row turns by the same angle from one frequency to the next; one sine and cosine per
        // row and frequency would take ten times as long.
        let turn = |times: f64, t: f64| {
            let (s, c) = (TAU * times * step * (t - self.times[0])).sin_cos();
            [c, s]
        };
        let turns: Vec<[f64; 2]> = self.times.iter().map(|&t| turn(1.0, t)).collect();
        let start = |((&t, y), w): ((&f64, &f64), &f64)| turn(OVERSAMPLING, t).map(|part| w * y * part);
        let mut now: Vec<[f64; 2]> =
            self.times.iter().zip(&self.values).zip(&self.weights).map(start).collect();
        let mut found = Vec::with_capacity(count);
        for k in OVERSAMPLING as usize..=count {
            let mut sums = [0.0; 2];
            for (part, [c, s]) in now.iter_mut().zip(&turns) {
                sums[0] += part[0];
                sums[1] += part[1];
                *part = [part[0] * c - part[1] * s, part[0] * s + part[1] * c];
            }
            found.push((k as f64 * step, 4.0 * (sums[0] * sums[0] + sums[1] * sums[1]) / (total * total)));
        }
        found
    }

    /// Returns the frequency, 1/s, of the maximum next to one of [`Self::spectrum`].
    pub fn refined(&self, frequency: f64) -> f64 {
        let step = 1.0 / (OVERSAMPLING * self.length);
        let (mut low, mut high) = (frequency - step, frequency + step);
        // Golden-section search.
        let ratio = 0.5 * (5.0_f64.sqrt() - 1.0);
        for _ in 0..24 {
            let (a, b) = (high - ratio * (high - low), low + ratio * (high - low));
            if self.power(a) < self.power(b) { low = a } else { high = b }
        }
        0.5 * (low + high)
    }

    /// Returns the largest amplitude within one frequency resolution of `frequency`, 1/s.
    pub fn amplitude_near(&self, frequency: f64) -> f64 {
        let near = (-4..=4).map(|k| frequency + f64::from(k) / (OVERSAMPLING * self.length));
        near.map(|near| self.power(near)).fold(0.0, f64::max).sqrt()
    }
}

/// Subtracts the least-squares line.
fn remove_trend(times: &[f64], values: &mut [f64]) {
    let count = times.len() as f64;
    let middle = times.iter().sum::<f64>() / count;
    let mean = values.iter().sum::<f64>() / count;
    let (mut product, mut square) = (0.0, 0.0);
    for (t, y) in times.iter().zip(&*values) {
        product += (t - middle) * (y - mean);
        square += (t - middle) * (t - middle);
    }
    for (t, y) in times.iter().zip(values) {
        *y -= mean + product / square * (t - middle);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(frequency: f64, drift: f64) -> Series {
        let times: Vec<f64> =
            (0..600).map(|k| 0.1 * (f64::from(k) + 0.25 * f64::from(k % 7) / 7.0)).collect();
        let lift = |t: &f64| 0.7 * (TAU * frequency * t + 0.4).sin() + 0.1 + drift * t * t;
        let values: Vec<f64> = times.iter().map(lift).collect();
        Series::new(&times, &values, 1.0).expect("enough rows")
    }

    #[test]
    fn sine_has_its_own_amplitude() {
        for frequency in [0.11, 0.2053, 0.77] {
            let power = series(frequency, 0.0).power(frequency);
            // The negative frequency leaks by 1e-3 where a record has six periods.
            assert!((power.sqrt() - 0.7).abs() < 2e-3, "{}", power.sqrt());
        }
    }

    #[test]
    fn spectrum_agrees_with_single_powers() {
        let series = series(0.3, 0.01);
        let spectrum = series.spectrum(1.0);
        assert!((spectrum[0].0 - 1.0 / series.length).abs() < 1e-12);
        for (frequency, power) in spectrum {
            let single = series.power(frequency);
            assert!((power - single).abs() < 1e-9 * single.max(1.0), "{frequency}: {power}, not {single}");
        }
    }

    #[test]
    fn curved_drift_does_not_reach_the_line() {
        let series = series(0.3, 0.01);
        // The drift is 50 times as large as the sine.
        assert!((series.power(0.3).sqrt() - 0.7).abs() < 0.02, "{}", series.power(0.3).sqrt());
        assert!((series.refined(0.304) - 0.3).abs() < 1e-3);
    }

    #[test]
    fn trend_leaves_rounding_only() {
        let times: Vec<f64> = (0..100).map(f64::from).collect();
        let line: Vec<f64> = times.iter().map(|t| 3.0 - 0.2 * t).collect();
        assert!(Series::new(&times, &line, 1.0).expect("enough rows").is_constant);
        assert!(Series::new(&times, &[0.0; 100], 1.0).expect("enough rows").is_constant);
        assert!(Series::new(&times[..31], &line[..31], 1.0).is_none());
        assert!(Series::new(&[1.0; 50], &[2.0; 50], 1.0).is_none());
    }
}
