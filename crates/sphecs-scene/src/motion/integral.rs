//! Integral of a rate over time, as a function of the time alone.
//!
//! ```text
//! x(t) = Σ_(k < n) G(k w, (k + 1) w) + G(n w, t),   n = ⌊t/w⌋
//! w = the largest power of two of at most T/4096, T the end of the run
//! ```
//!
//! G is the Gauss–Legendre quadrature with five points. It is halved where the halves disagree with
//! the whole by 1e-13: a rate such as `min(t/0.2, 1)` has a kink within a panel. The panels do not
//! depend on the time steps, and their sums are computed once, so that x is bitwise the same
//! whatever times were evaluated before. A power of two makes k w exact; it changes with T only
//! where T passes a power of two. The panels continue before 0 and after T.

use std::sync::Arc;

use super::MotionFault;
use crate::expression::TimeFunction;

/// Least number of panels of a run.
const PANELS: f64 = 4096.0;

/// Disagreement of a panel with its halves, over its ∫ |rate| dt, that is accepted.
const TOLERANCE: f64 = 1e-13;

/// Most halvings of a panel: they find a jump of the rate to 2⁻³² w, and rounding errors of a rate
/// that nearly cancels must not take more.
const MOST_HALVINGS: u32 = 32;

/// Points and weights of the Gauss–Legendre quadrature on −1 … 1, except those at 0.
const POINTS: [(f64, f64); 2] =
    [(0.538_469_310_105_683_1, 0.478_628_670_499_366_47), (0.906_179_845_938_664, 0.236_926_885_056_189_1)];

/// Weight of the point at 0.
const MIDDLE_WEIGHT: f64 = 128.0 / 225.0;

/// The integral of a rate from t = 0.
#[derive(Clone, Debug)]
pub struct RateIntegral {
    rate: TimeFunction,
    /// Length of a panel w, s.
    panel: f64,
    /// Integral from 0 to the beginning of each panel until the end of the run.
    sums: Arc<[f64]>,
}

impl RateIntegral {
    /// Returns the integral of a rate in a run to `end`, s.
    ///
    /// # Errors
    /// An end that is not finite and greater than 0, or a rate that is not finite in the run.
    pub fn new(rate: TimeFunction, end: f64) -> Result<Self, MotionFault> {
        let panel = power_of_two(end / PANELS);
        if !end.is_finite() || end <= 0.0 || panel == 0.0 {
            return Err(MotionFault::End(end));
        }
        let mut integral = Self { rate, panel, sums: Arc::new([]) };
        let count = (end / panel).ceil() as usize;
        let mut sums = Vec::with_capacity(count + 1);
        // Compensated sums: the error of thousands of additions is that of one.
        let (mut sum, mut lost) = (0.0, 0.0);
        sums.push(sum);
        for index in 0..count {
            let start = index as f64 * panel;
            let added = integral.over(start, start + panel);
            if !added.is_finite() {
                return Err(MotionFault::RateNotFinite { time: start });
            }
            let corrected = added - lost;
            let next = sum + corrected;
            lost = (next - sum) - corrected;
            sum = next;
            sums.push(sum);
        }
        integral.sums = sums.into();
        Ok(integral)
    }

    /// Returns the integral from 0 to a time (s), the rate and its derivative at the time.
    pub fn at(&self, time: f64) -> [f64; 3] {
        [self.value(time), self.rate.value(time), self.rate.rate(time)]
    }

    fn value(&self, time: f64) -> f64 {
        if !time.is_finite() {
            return f64::NAN;
        }
        let index = (time.abs() / self.panel).floor() as usize;
        let beginning = |index: usize| (index as f64 * self.panel).copysign(time);
        let panel = |index: usize| self.over(beginning(index), beginning(index + 1));
        // Before the start and after the end the panels are not stored.
        let known = if time < 0.0 { 0 } else { index.min(self.sums.len() - 1) };
        let sum = (known..index).map(panel).fold(self.sums[known], |sum, added| sum + added);
        sum + self.over(beginning(index), time)
    }

    /// Returns the integral between two times, s.
    fn over(&self, from: f64, to: f64) -> f64 {
        if from == to {
            return 0.0;
        }
        let whole = self.quadrature(from, to, |rate| rate);
        let tolerance = TOLERANCE * self.quadrature(from, to, f64::abs).abs();
        let mut halvings = MOST_HALVINGS;
        self.halved([from, to], whole, tolerance, &mut halvings)
    }

    /// Returns the integral between two times (s), from the halves of the interval.
    fn halved(&self, [from, to]: [f64; 2], whole: f64, tolerance: f64, halvings: &mut u32) -> f64 {
        let middle = f64::midpoint(from, to);
        let left = self.quadrature(from, middle, |rate| rate);
        let right = self.quadrature(middle, to, |rate| rate);
        if (left + right - whole).abs() <= tolerance || *halvings == 0 {
            return left + right;
        }
        *halvings -= 1;
        let left = self.halved([from, middle], left, tolerance, halvings);
        left + self.halved([middle, to], right, tolerance, halvings)
    }

    /// Returns the quadrature of a function of the rate between two times, s.
    fn quadrature(&self, from: f64, to: f64, of: impl Fn(f64) -> f64) -> f64 {
        let (middle, half) = (f64::midpoint(from, to), 0.5 * (to - from));
        let at = |offset: f64| of(self.rate.value(middle + offset * half));
        let pairs: f64 = POINTS.iter().map(|(point, weight)| weight * (at(-point) + at(*point))).sum();
        half * (MIDDLE_WEIGHT * at(0.0) + pairs)
    }
}

/// Returns the largest power of two of at most a positive number; 0 below the normal numbers.
fn power_of_two(number: f64) -> f64 {
    const EXPONENT: u64 = 0x7ff0_0000_0000_0000;
    f64::from_bits(number.to_bits() & EXPONENT)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Constants;

    fn rate(text: &str) -> TimeFunction {
        TimeFunction::read(text, &Constants::default()).expect("a function")
    }

    fn check(text: &str, end: f64, exact: impl Fn(f64) -> f64) {
        let integral = RateIntegral::new(rate(text), end).expect("an integral");
        for k in -2..=37 {
            let time = end * f64::from(k) / 31.7;
            let [value, ..] = integral.at(time);
            let expected = exact(time);
            assert!(
                (value - expected).abs() <= 1e-12 * expected.abs().max(1.0),
                "{text} to {time}: {value}, must be {expected}"
            );
        }
    }

    #[test]
    fn integrals_are_the_closed_forms() {
        check("3", 2.0, |t| 3.0 * t);
        check("2*t - 1", 0.7, |t| t * t - t);
        check("cos(2*pi*t)", 100.0, |t| (std::f64::consts::TAU * t).sin() / std::f64::consts::TAU);
        check("exp(-t)", 5.0, |t| 1.0 - (-t).exp());
        check("1 - tanh(t/0.1)^2", 1.0, |t| 0.1 * (t / 0.1).tanh());
    }

    #[test]
    fn kinks_and_jumps_of_the_rate_are_resolved() {
        check("min(max(t, 0)/0.2, 1)", 1.0, |t| {
            if t < 0.0 {
                0.0
            } else if t < 0.2 {
                2.5 * t * t
            } else {
                t - 0.1
            }
        });
        check("(t > 0.123)*7", 1.0, |t| 7.0 * (t - 0.123).max(0.0));
    }

    #[test]
    fn value_is_bitwise_the_same_whatever_was_evaluated_before() {
        let integral = || RateIntegral::new(rate("sin(3*t)^2 + t"), 1.3).expect("an integral");
        let (forwards, backwards) = (integral(), integral());
        let times: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.003_1).collect();
        let first: Vec<u64> = times.iter().map(|time| forwards.at(*time)[0].to_bits()).collect();
        let mut second: Vec<u64> = times.iter().rev().map(|time| backwards.at(*time)[0].to_bits()).collect();
        second.reverse();
        assert_eq!(first, second);
        // The same panels serve all ends between two powers of two.
        let longer = RateIntegral::new(rate("sin(3*t)^2 + t"), 1.9).expect("an integral");
        assert_eq!(longer.at(1.25)[0].to_bits(), forwards.at(1.25)[0].to_bits());
    }

    #[test]
    fn panels_join_continuously() {
        let integral = RateIntegral::new(rate("1 + (t > 0.5001)"), 1.0).expect("an integral");
        for index in [0_u32, 1, 2047, 2048, 2049, 4095, 4096, 4097] {
            let border = f64::from(index) / 4096.0;
            let [before, after] = [border - 1e-13, border + 1e-13].map(|time| integral.at(time)[0]);
            assert!((after - before).abs() < 1e-12, "{border}: {before} {after}");
        }
    }

    #[test]
    fn rates_and_ends_without_an_integral_are_faults() {
        for end in [0.0, -1.0, f64::INFINITY, f64::NAN] {
            assert!(matches!(RateIntegral::new(rate("t"), end), Err(MotionFault::End(_))));
        }
        let fault = RateIntegral::new(rate("1/(t - 0.5)^2 + sqrt(t - 0.25)"), 1.0).expect_err("not finite");
        assert!(matches!(fault, MotionFault::RateNotFinite { time } if time < 0.25), "{fault}");
    }
}
