//! Slow part of a signal that is known in advance, such as the prescribed inflow.
//!
//! ```text
//! q̃(t) = ∫ k(τ/T) q(t − τ) dτ/T,   k(x) = (1/π) ∫ H(ω) cos ωx dω,   H(ω) = exp(−(ω/ω_c)⁸)/cos ω
//! ```
//!
//! H is 1/cos ω for signals that are slow against the time T, the response that an outlet needs
//! (see [`prescribed_flow`](super::outlet::non_reflecting::prescribed_flow)), and 0 for fast ones.
//! The kernel looks as far ahead as back, so that a slow signal is neither delayed nor distorted.
//! That is possible because a scene states the signal as a function of time.
//!
//! The signal is sampled at whole multiples of T/8, the same in every run. So the slow part is a
//! function of time alone, and a checkpoint need not save it.

use std::collections::VecDeque;

/// Cut-off ω_c, over 1/T. A signal with a period of 10 T passes to 3 %, one of 30 T to 0.3 %; of a
/// pulse of T/4 a tenth is left.
const CUT_OFF: f64 = 1.1;

/// Largest frequency of the integral, over 1/T, where H is below 1e-4.
const HIGHEST: f64 = 1.5;

/// Reach of the kernel on both sides, in T; beyond, it is below 1e-3 of its middle.
const REACH: usize = 16;

/// Samples of the signal per T.
const SAMPLES: usize = 8;

/// Entries of the table of the kernel per T.
const ENTRIES: usize = 64;

/// Filter of one signal, with the samples that it needs at the present time.
#[derive(Clone, Debug)]
pub struct SlowPart {
    /// Time T, s.
    passage: f64,
    /// k(x) at x = 0, 1/64, …
    kernel: Vec<f64>,
    /// Number of the first sample.
    first: i64,
    samples: VecDeque<f64>,
}

impl SlowPart {
    /// Returns the filter for a time T, s.
    pub fn new(passage: f64) -> Self {
        let kernel = (0..=REACH * ENTRIES).map(|entry| kernel(entry as f64 / ENTRIES as f64)).collect();
        Self { passage, kernel, first: 0, samples: VecDeque::new() }
    }

    /// Returns the slow part of a signal at a time, s, and its rate.
    ///
    /// `signal` is called at times from 0 on; where it is not finite, beyond the end of a run, its
    /// last finite sample counts.
    pub fn at(&mut self, time: f64, signal: impl Fn(f64) -> f64) -> (f64, f64) {
        let step = self.passage / SAMPLES as f64;
        let place = time / step;
        let reach = (REACH * SAMPLES) as i64;
        // One sample more on both sides for the differences of the rate.
        let (from, to) = (place.floor() as i64 - reach - 1, place.floor() as i64 + reach + 2);
        if from < self.first || from > self.first + self.samples.len() as i64 {
            self.samples.clear();
        }
        if self.samples.is_empty() {
            self.first = from;
        }
        while self.first < from {
            self.samples.pop_front();
            self.first += 1;
        }
        while self.first + (self.samples.len() as i64) <= to {
            let at = self.first + self.samples.len() as i64;
            let found = signal(at.max(0) as f64 * step);
            let last = self.samples.back().copied().unwrap_or(0.0);
            self.samples.push_back(if found.is_finite() { found } else { last });
        }
        let rate = (self.smoothed(place + 0.5) - self.smoothed(place - 0.5)) / step;
        (self.smoothed(place), rate)
    }

    /// Returns the slow part at a place in units of the samples.
    fn smoothed(&self, place: f64) -> f64 {
        let (mut sum, mut weights) = (0.0, 0.0);
        for (index, sample) in self.samples.iter().enumerate() {
            let distance = (place - (self.first + index as i64) as f64).abs() / SAMPLES as f64;
            let entry = distance * ENTRIES as f64;
            let low = entry as usize;
            if low + 1 < self.kernel.len() {
                let share = entry - low as f64;
                let weight = self.kernel[low] + share * (self.kernel[low + 1] - self.kernel[low]);
                sum += weight * sample;
                weights += weight;
            }
        }
        sum / weights
    }
}

/// Returns k(x), by the midpoint rule, with a window that ends it smoothly.
fn kernel(x: f64) -> f64 {
    const PARTS: usize = 400;
    let part = HIGHEST / PARTS as f64;
    let response = |omega: f64| (-(omega / CUT_OFF).powi(8)).exp() / omega.cos();
    let sum: f64 = (0..PARTS)
        .map(|index| {
            let omega = (index as f64 + 0.5) * part;
            response(omega) * (omega * x).cos()
        })
        .sum();
    let window = (std::f64::consts::FRAC_PI_2 * x / REACH as f64).cos().powi(2);
    sum * part / std::f64::consts::PI * window
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const PASSAGE: f64 = 0.1;

    /// Returns the largest difference from an exact function over some time.
    fn worst(signal: impl Fn(f64) -> f64, exact: impl Fn(f64) -> f64) -> f64 {
        let mut filter = SlowPart::new(PASSAGE);
        (2000..6000)
            .map(|step| {
                let time = f64::from(step) * 1e-3;
                (filter.at(time, &signal).0 - exact(time)).abs()
            })
            .fold(0.0, f64::max)
    }

    #[test]
    fn slow_signal_is_raised_as_in_a_duct_of_given_pressure() {
        let sine = |time: f64| (TAU * time).sin();
        let found = worst(|time| 0.3 + sine(time), |time| 0.3 + sine(time) / (TAU * PASSAGE).cos());
        assert!(found < 0.03, "{found}");
        let slower = |time: f64| (TAU * time / 3.0).sin();
        let found = worst(slower, |time| slower(time) / (TAU * PASSAGE / 3.0).cos());
        assert!(found < 0.003, "{found}");
    }

    #[test]
    fn short_pulse_is_suppressed() {
        let pulse = |time: f64| (-((time - 4.0) / 0.0125).powi(2)).exp();
        let found = worst(pulse, |_| 0.0);
        assert!((0.02..0.15).contains(&found), "{found}");
    }

    #[test]
    fn constant_signal_is_unchanged_and_a_ramp_has_its_rate() {
        assert!(worst(|_| 0.7, |_| 0.7) < 1e-14);
        let mut filter = SlowPart::new(PASSAGE);
        let (value, rate) = filter.at(4.0, |time| 2.0 * time);
        assert!((value - 8.0).abs() < 1e-9 && (rate - 2.0).abs() < 1e-9, "{value}, {rate}");
    }

    #[test]
    fn slow_part_depends_on_the_time_alone() {
        let signal = |time: f64| (7.0 * time).sin() + time;
        let mut every = SlowPart::new(PASSAGE);
        let all: Vec<_> = (0..500).map(|step| every.at(f64::from(step) * 7e-3, signal)).collect();
        let mut resumed = SlowPart::new(PASSAGE);
        for step in [0, 3, 250, 251, 499, 17] {
            assert_eq!(resumed.at(f64::from(step) * 7e-3, signal), all[step as usize], "step {step}");
        }
    }

    #[test]
    fn end_of_a_signal_counts_on() {
        let mut filter = SlowPart::new(PASSAGE);
        let (value, _) = filter.at(1.0, |time| if time > 1.05 { f64::NAN } else { 0.4 });
        assert!((value - 0.4).abs() < 1e-12, "{value}");
    }
}
