//! Parameters that a condition cannot work with, as data: a scene adds the place in its text.

use std::fmt;

/// A parameter out of its range.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ConditionFault {
    /// Name of the parameter in the scene notation.
    pub field: &'static str,
    /// The value, with its unit.
    pub value: String,
    /// The range that it must be in, as it continues "must be".
    pub must_be: &'static str,
    /// Advice on how to choose a value; empty where the range says it all.
    pub advice: &'static str,
}

impl ConditionFault {
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
        (!is_met).then_some(Self { field, value, must_be, advice: "" })
    }

    /// Adds advice on how to choose a value.
    #[must_use]
    pub fn advise(mut self, advice: &'static str) -> Self {
        self.advice = advice;
        self
    }
}

impl fmt::Display for ConditionFault {
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
        let fault = ConditionFault::unless_positive("time", -0.5, "s").expect("a fault");
        assert_eq!(fault.to_string(), "`time` is -0.5 s, must be finite and greater than 0");
        let advised = fault.advise("leave it out");
        assert!(advised.to_string().ends_with("; leave it out"), "{advised}");
    }

    #[test]
    fn values_in_their_range_have_no_fault() {
        assert_eq!(ConditionFault::unless_finite("pressure", -3.0, "Pa"), None);
        assert_eq!(ConditionFault::unless_positive("time", 3.0, "s"), None);
        let text = |fault: Option<ConditionFault>| fault.expect("a fault").to_string();
        let unbounded = ConditionFault::unless_finite("pressure", f64::NAN, "Pa");
        assert_eq!(text(unbounded), "`pressure` is NaN Pa, must be finite");
        let endless = ConditionFault::unless_positive("time", f64::INFINITY, "s");
        assert_eq!(text(endless), "`time` is inf s, must be finite and greater than 0");
    }
}
