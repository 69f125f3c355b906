//! A quantity that a scene gives at an opening as a function of time.

use std::fmt;

use serde::de::{self, Deserializer, Visitor};
use serde::{Deserialize, Serialize};

use crate::physics::parameter_fault::ParameterFault;

/// A number, or an expression of the time t (s) in quotes. The scene that holds it compiles it.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub enum TimeFunction {
    /// A number.
    Number(f64),
    /// An expression in quotes.
    Text(String),
}

impl From<f64> for TimeFunction {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for TimeFunction {
    fn from(text: &str) -> Self {
        Self::Text(text.to_owned())
    }
}

impl<'de> Deserialize<'de> for TimeFunction {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct TimeFunctionVisitor;
        impl Visitor<'_> for TimeFunctionVisitor {
            type Value = TimeFunction;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or an expression of t in quotes")
            }

            fn visit_f64<E: de::Error>(self, value: f64) -> Result<TimeFunction, E> {
                Ok(TimeFunction::Number(value))
            }

            fn visit_str<E: de::Error>(self, text: &str) -> Result<TimeFunction, E> {
                Ok(TimeFunction::Text(text.to_owned()))
            }
        }
        deserializer.deserialize_any(TimeFunctionVisitor)
    }
}

/// A number or text, marked as an expression of time.
#[cfg(feature = "schema")]
impl schemars::JsonSchema for TimeFunction {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        "TimeFunction".into()
    }

    fn json_schema(_generator: &mut schemars::SchemaGenerator) -> schemars::Schema {
        schemars::json_schema!({ "type": ["number", "string"], "x-expression": true })
    }
}

/// The three forms of a quantity in time, of which a scene gives one.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Given<'a> {
    /// A number or an expression.
    pub value: Option<&'a TimeFunction>,
    /// Rows of time (s) and value, linear between rows, constant beyond the ends.
    pub rows: Option<&'a [(f64, f64)]>,
    /// CSV file of two columns, time (s) and value.
    pub file: Option<&'a str>,
}

impl Given<'_> {
    /// Returns the parameters that are out of range; `unit` is that of the quantity.
    pub fn faults(&self, unit: &str) -> Vec<ParameterFault> {
        let count = [self.value.is_some(), self.rows.is_some(), self.file.is_some()];
        let count = count.into_iter().filter(|is_given| *is_given).count();
        let number = match self.value {
            Some(TimeFunction::Number(value)) => ParameterFault::unless_finite("value", *value, unit),
            _ => None,
        };
        let form = (count != 1).then(|| ParameterFault {
            field: "value",
            value: format!("given in {count} of the forms `value`, `rows` and `file`"),
            must_be: "exactly one of them".to_owned(),
            advice: "write `value: 4.0`, `value: \"2*sin(3*t)\"`, `rows: [(0.0, 0.0), (1.0, 4.0)]` or \
                     `file: \"pressure.csv\"`",
        });
        form.into_iter().chain(number).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn exactly_one_form_is_taken() {
        let (value, rows) = (TimeFunction::from(4.0), [(0.0, 1.0)]);
        let one = Given { value: Some(&value), ..Given::default() };
        assert_eq!(one.faults("Pa"), []);
        assert_eq!(Given::default().faults("Pa").len(), 1);
        assert_eq!(Given { rows: Some(&rows), ..one }.faults("Pa").len(), 1);
        let infinite = TimeFunction::from(f64::INFINITY);
        assert_eq!(Given { value: Some(&infinite), ..Given::default() }.faults("Pa").len(), 1);
    }
}
