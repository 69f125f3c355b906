//! Parameters outside the range that their method allows.

use std::ops::RangeInclusive;

/// A parameter of a method that is out of bounds.
#[derive(Clone, Debug, PartialEq)]
pub struct ParameterFault {
    /// Name of the parameter, as a scene file spells it.
    pub field: &'static str,
    /// One line that says which parameter is out of bounds.
    pub message: &'static str,
    /// Value of the parameter, in its own unit.
    pub value: f64,
    /// Allowed values, in the same unit.
    pub allowed: RangeInclusive<f64>,
    /// Usual values, ready to be shown as a hint.
    pub usual: &'static str,
}

impl ParameterFault {
    /// Returns the fault if its value is out of bounds or not a number.
    pub fn if_out_of_bounds(self) -> Option<Self> {
        (!self.allowed.contains(&self.value)).then_some(self)
    }
}
