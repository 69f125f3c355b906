//! Curve: a number as a function of time, with its first two derivatives.

use super::MotionFault;
use super::integral::RateIntegral;
use super::spline::MonotoneSpline;
use crate::expression::TimeFunction;

/// A displacement (m) or an angle (rad) in time.
#[derive(Clone, Debug)]
pub enum Curve {
    /// One value at all times.
    Constant(f64),
    /// An expression of t, s.
    Formula(TimeFunction),
    /// The integral of a rate (m/s or 1/s) from t = 0.
    Integral(RateIntegral),
    /// Samples, joined by a spline and at rest beyond them.
    Table(MonotoneSpline),
}

impl Curve {
    /// Returns the integral of a rate from t = 0, for a run to `end`, s.
    ///
    /// # Errors
    /// As for [`RateIntegral::new`].
    pub fn integral(rate: TimeFunction, end: f64) -> Result<Self, MotionFault> {
        RateIntegral::new(rate, end).map(Self::Integral)
    }

    /// Returns the curve through samples of time (s) and value.
    ///
    /// # Errors
    /// As for [`MonotoneSpline::new`].
    pub fn table(samples: &[(f64, f64)]) -> Result<Self, MotionFault> {
        MonotoneSpline::new(samples).map(Self::Table)
    }

    /// Returns the value, its first and its second derivative at a time, s.
    ///
    /// They depend on the time alone, bitwise, not on what was evaluated before.
    pub fn at(&self, time: f64) -> [f64; 3] {
        match self {
            Self::Constant(value) => [*value, 0.0, 0.0],
            Self::Formula(formula) => [formula.value(time), formula.rate(time), formula.acceleration(time)],
            Self::Integral(integral) => integral.at(time),
            Self::Table(spline) => spline.at(time),
        }
    }
}

impl From<TimeFunction> for Curve {
    fn from(function: TimeFunction) -> Self {
        function.constant_value().map_or(Self::Formula(function), Self::Constant)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Constants;

    fn function(text: &str) -> TimeFunction {
        TimeFunction::read(text, &Constants::default()).expect("a function")
    }

    #[test]
    fn every_kind_gives_the_value_and_its_derivatives() {
        assert_eq!(Curve::from(function("3 + 1")).at(5.0), [4.0, 0.0, 0.0]);
        assert!(matches!(Curve::from(function("3 + 1")), Curve::Constant(_)));
        assert_eq!(Curve::from(function("t^2 - t")).at(2.0), [2.0, 3.0, 2.0]);
        let integral = Curve::integral(function("2*t - 1"), 4.0).expect("an integral");
        let [value, rate, acceleration] = integral.at(2.0);
        assert!((value - 2.0).abs() < 1e-14 && rate == 3.0 && acceleration == 2.0);
        let table = Curve::table(&[(0.0, 0.0), (2.0, 2.0)]).expect("a table");
        assert_eq!(table.at(1.0), [1.0, 1.5, 0.0]);
    }
}
