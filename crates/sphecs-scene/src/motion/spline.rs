//! Monotone cubic spline through samples in time, at rest before the first and after the last.
//!
//! ```text
//! x(t) = x_i + h s (m_i + s (3δ − 2m_i − m_(i+1) + s (m_i + m_(i+1) − 2δ)))
//! s = (t − t_i)/h,   h = t_(i+1) − t_i,   δ = (x_(i+1) − x_i)/h
//!
//! m_i = 3 (h⁻ + h)/((2h + h⁻)/δ⁻ + (h + 2h⁻)/δ)   if δ⁻ δ > 0, else 0;   h⁻, δ⁻ of the step before
//! m = 0 at the first and at the last sample
//! ```
//!
//! Slopes by Fritsch & Butland (1984): x rises and falls with the samples and is nowhere beyond
//! them, so that a wall does not pass the end of its stroke. The velocity is continuous and the
//! acceleration bounded. The slopes at both ends are ours: there the wall is at rest, and a motion
//! of constant speed between two samples has 3/2 of that speed in the middle.

use std::sync::Arc;

use super::MotionFault;

/// Value and slope at a time.
#[derive(Clone, Copy, Debug)]
struct Knot {
    /// Time, s.
    time: f64,
    /// Value.
    value: f64,
    /// Derivative of the value, 1/s of its unit.
    slope: f64,
}

/// A monotone cubic spline in time.
#[derive(Clone, Debug)]
pub struct MonotoneSpline {
    knots: Arc<[Knot]>,
}

impl MonotoneSpline {
    /// Returns the spline through samples of time (s) and value.
    ///
    /// # Errors
    /// Less than two samples, a number that is not finite, or times that do not rise.
    pub fn new(samples: &[(f64, f64)]) -> Result<Self, MotionFault> {
        if samples.len() < 2 {
            return Err(MotionFault::TooFewSamples(samples.len()));
        }
        if let Some(sample) = samples.iter().position(|(t, x)| !t.is_finite() || !x.is_finite()) {
            return Err(MotionFault::SampleNotFinite { sample });
        }
        if let Some(before) = samples.windows(2).position(|pair| pair[1].0 <= pair[0].0) {
            let (time, previous) = (samples[before + 1].0, samples[before].0);
            return Err(MotionFault::TimesDoNotRise { sample: before + 1, time, previous });
        }
        let knot = |index: usize| {
            let (time, value) = samples[index];
            let inside = index > 0 && index + 1 < samples.len();
            let slope = if inside { slope([index - 1, index, index + 1].map(|i| samples[i])) } else { 0.0 };
            Knot { time, value, slope }
        };
        Ok(Self { knots: (0..samples.len()).map(knot).collect() })
    }

    /// Returns the value, its first and its second derivative at a time, s.
    ///
    /// The second derivative jumps at the samples; there it is that of the step after.
    pub fn at(&self, time: f64) -> [f64; 3] {
        let next = self.knots.partition_point(|knot| knot.time <= time);
        if next == 0 || next == self.knots.len() {
            return [self.knots[next.saturating_sub(1)].value, 0.0, 0.0];
        }
        let (a, b) = (self.knots[next - 1], self.knots[next]);
        let step = b.time - a.time;
        let (s, mean) = ((time - a.time) / step, (b.value - a.value) / step);
        let quadratic = 3.0 * mean - 2.0 * a.slope - b.slope;
        let cubic = a.slope + b.slope - 2.0 * mean;
        [
            a.value + step * s * (a.slope + s * (quadratic + s * cubic)),
            a.slope + s * (2.0 * quadratic + 3.0 * s * cubic),
            (2.0 * quadratic + 6.0 * s * cubic) / step,
        ]
    }
}

/// Returns the slope at the middle one of three samples, 1/s of the unit of their values.
fn slope([a, b, c]: [(f64, f64); 3]) -> f64 {
    let steps = [b.0 - a.0, c.0 - b.0];
    let means = [(b.1 - a.1) / steps[0], (c.1 - b.1) / steps[1]];
    if means[0] * means[1] <= 0.0 {
        return 0.0;
    }
    let weights = [2.0 * steps[1] + steps[0], steps[1] + 2.0 * steps[0]];
    3.0 * (steps[0] + steps[1]) / (weights[0] / means[0] + weights[1] / means[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn spline(samples: &[(f64, f64)]) -> MonotoneSpline {
        MonotoneSpline::new(samples).expect("a spline")
    }

    const SAMPLES: [(f64, f64); 7] =
        [(0.1, 0.0), (0.2, 0.0), (0.5, 1.0), (0.6, 1.5), (1.0, 1.6), (1.3, 0.2), (1.4, 0.2)];

    #[test]
    fn spline_passes_through_its_samples_and_rests_outside() {
        let spline = spline(&SAMPLES);
        for (time, value) in SAMPLES {
            assert_eq!(spline.at(time)[0], value, "t = {time}");
        }
        assert_eq!(spline.at(-5.0), [0.0; 3]);
        assert_eq!(spline.at(99.0), [0.2, 0.0, 0.0]);
    }

    #[test]
    fn value_and_velocity_are_continuous() {
        let spline = spline(&SAMPLES);
        for (time, _) in SAMPLES {
            let [before, after] = [time - 1e-9, time + 1e-9].map(|time| spline.at(time));
            // Speeds stay below 15 and accelerations below 200.
            assert!((before[0] - after[0]).abs() < 3e-8, "t = {time}: {before:?} {after:?}");
            assert!((before[1] - after[1]).abs() < 4e-7, "t = {time}: {before:?} {after:?}");
        }
    }

    #[test]
    fn derivatives_are_those_of_differences() {
        const STEP: f64 = 1e-4;
        let spline = spline(&SAMPLES);
        for time in [0.15, 0.3, 0.41, 0.55, 0.77, 0.95, 1.1, 1.35] {
            let [a, b, c] = [-STEP, 0.0, STEP].map(|step| spline.at(time + step));
            // Error h²/6 of the third derivative, which is below 2000.
            assert!(((c[0] - a[0]) / (2.0 * STEP) - b[1]).abs() < 1e-5, "t = {time}");
            assert!(((c[1] - a[1]) / (2.0 * STEP) - b[2]).abs() < 1e-5, "t = {time}");
        }
    }

    #[test]
    fn spline_is_nowhere_beyond_its_samples() {
        let spline = spline(&SAMPLES);
        for pair in SAMPLES.windows(2) {
            let (low, high) = (pair[0].1.min(pair[1].1), pair[0].1.max(pair[1].1));
            for k in 0..=100 {
                let time = pair[0].0 + (pair[1].0 - pair[0].0) * f64::from(k) / 100.0;
                let value = spline.at(time)[0];
                assert!(value >= low - 1e-15 && value <= high + 1e-15, "x({time}) = {value}");
            }
        }
    }

    #[test]
    fn straight_samples_give_a_straight_line_between_the_ends() {
        let samples: Vec<(f64, f64)> =
            [0.0, 0.1, 0.3, 0.7, 1.0].map(|time| (time, 2.0 * time - 1.0)).to_vec();
        let [value, rate, acceleration] = spline(&samples).at(0.45);
        assert!((value + 0.1).abs() < 1e-15 && (rate - 2.0).abs() < 1e-14 && acceleration.abs() < 1e-13);
        // Between two samples the speed in the middle is 3/2 of the mean.
        assert_eq!(spline(&[(0.0, 0.0), (2.0, 2.0)]).at(1.0), [1.0, 1.5, 0.0]);
    }

    #[test]
    fn samples_that_cannot_be_joined_are_faults() {
        let fault = |samples: &[(f64, f64)]| MonotoneSpline::new(samples).expect_err("a fault");
        assert_eq!(fault(&[(0.0, 1.0)]), MotionFault::TooFewSamples(1));
        assert_eq!(fault(&[(0.0, 1.0), (1.0, f64::NAN)]), MotionFault::SampleNotFinite { sample: 1 });
        let repeated = fault(&[(0.0, 1.0), (1.0, 1.0), (1.0, 2.0)]);
        assert_eq!(repeated, MotionFault::TimesDoNotRise { sample: 2, time: 1.0, previous: 1.0 });
        assert_eq!(repeated.to_string(), "the time of sample 3 is 1 s, must be greater than 1 s");
    }
}
