//! Parameters that a method cannot work with, as data: a scene adds the place in its text.

use std::fmt;
use std::ops::RangeInclusive;

/// A parameter out of its range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ParameterFault {
    /// Name of the parameter in the scene notation.
    pub field: &'static str,
    /// The value, with its unit.
    pub value: String,
    /// The range that it must be in, as it continues "must be".
    pub must_be: String,
    /// Advice on how to choose a value; empty where the range says it all.
    pub advice: &'static str,
}

impl ParameterFault {
    /// Returns a fault unless a value, in `unit`, is finite.
    pub fn unless_finite(field: &'static str, value: f64, unit: &str) -> Option<Self> {
        Self::unless(value.is_finite(), field, value, unit, "finite")
    }

    /// Returns a fault unless a value, in `unit`, is finite and greater than 0.
    pub fn unless_positive(field: &'static str, value: f64, unit: &str) -> Option<Self> {
        let is_positive = value.is_finite() && value > 0.0;
        Self::unless(is_positive, field, value, unit, "finite and greater than 0")
    }

    /// Returns a fault unless a condition on a value, in `unit`, is met.
    pub fn unless(
        is_met: bool,
        field: &'static str,
        value: f64,
        unit: &str,
        must_be: &'static str,
    ) -> Option<Self> {
        let value = if unit.is_empty() { format!("{value}") } else { format!("{value} {unit}") };
        (!is_met).then(|| Self { field, value, must_be: must_be.to_owned(), advice: "" })
    }

    /// Returns a fault unless a dimensionless value lies in a range; a range that ends at
    /// [`f64::MAX`] has no upper bound.
    pub fn unless_within(range: RangeInclusive<f64>, field: &'static str, value: f64) -> Option<Self> {
        let (least, most) = (range.start(), range.end());
        let must_be =
            if *most == f64::MAX { format!("at least {least}") } else { format!("from {least} to {most}") };
        let fault = Self { field, value: format!("{value}"), must_be, advice: "" };
        (!range.contains(&value)).then_some(fault)
    }

    /// Adds advice on how to choose a value.
    #[must_use]
    pub fn advise(mut self, advice: &'static str) -> Self {
        self.advice = advice;
        self
    }
}

impl fmt::Display for ParameterFault {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "`{}` is {}, must be {}", self.field, self.value, self.must_be)?;
        if self.advice.is_empty() { Ok(()) } else { write!(formatter, "; {}", self.advice) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_says_what_is_and_what_must_be() {
        let fault = ParameterFault::unless_positive("time", -0.5, "s").expect("a fault");
        assert_eq!(fault.to_string(), "`time` is -0.5 s, must be finite and greater than 0");
        let advised = fault.advise("leave it out");
        assert!(advised.to_string().ends_with("; leave it out"), "{advised}");
    }

    #[test]
    fn values_in_their_range_have_no_fault() {
        assert_eq!(ParameterFault::unless_finite("pressure", -3.0, "Pa"), None);
        assert_eq!(ParameterFault::unless_positive("time", 3.0, "s"), None);
        let text = |fault: Option<ParameterFault>| fault.expect("a fault").to_string();
        let unbounded = ParameterFault::unless_finite("pressure", f64::NAN, "Pa");
        assert_eq!(text(unbounded), "`pressure` is NaN Pa, must be finite");
        let endless = ParameterFault::unless_positive("time", f64::INFINITY, "s");
        assert_eq!(text(endless), "`time` is inf s, must be finite and greater than 0");
        assert_eq!(ParameterFault::unless_within(0.0..=1.0, "alpha", 1.0), None);
        let negative = ParameterFault::unless_within(0.0..=f64::MAX, "alpha", -1.0);
        assert_eq!(text(negative), "`alpha` is -1, must be at least 0");
        let missing = ParameterFault::unless_within(0.0..=1.0, "alpha", f64::NAN);
        assert_eq!(text(missing), "`alpha` is NaN, must be from 0 to 1");
    }
}
