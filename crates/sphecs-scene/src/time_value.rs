//! A quantity given in time: an expression of t, or a table.

use super::expression::Expression;

/// A quantity that an opening is given in time.
#[derive(Clone, Debug)]
pub enum TimeValue {
    /// Expression of t (s).
    Expression(Expression),
    /// Rows of time (s) and value, linear between rows, constant beyond the ends.
    Table(Vec<(f64, f64)>),
}

impl TimeValue {
    /// Returns the value at a time, s.
    pub fn at(&self, time: f64) -> f64 {
        match self {
            Self::Expression(expression) => expression.value(0.0, 0.0, 0.0, time),
            Self::Table(rows) => interpolated(rows.len(), |row| rows[row].0, time, |row| rows[row].1),
        }
    }
}

/// Returns the linear interpolation between rising abscissae, constant beyond the ends.
pub(crate) fn interpolated(
    count: usize,
    abscissa: impl Fn(usize) -> f64,
    at: f64,
    value: impl Fn(usize) -> f64,
) -> f64 {
    let (mut next, mut end) = (0, count);
    while next < end {
        let middle = usize::midpoint(next, end);
        if abscissa(middle) <= at { next = middle + 1 } else { end = middle }
    }
    if next == 0 {
        return value(0);
    }
    if next == count {
        return value(count - 1);
    }
    let (a, b) = (abscissa(next - 1), abscissa(next));
    let weight = (at - a) / (b - a);
    value(next - 1) * (1.0 - weight) + value(next) * weight
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::expression::Constants;

    #[test]
    fn tables_are_linear_and_expressions_of_the_time() {
        let table = TimeValue::Table(vec![(1.0, 2.0), (3.0, 6.0)]);
        for (time, value) in [(0.0, 2.0), (2.0, 4.0), (9.0, 6.0)] {
            assert_eq!(table.at(time), value, "t = {time}");
        }
        let expression = Expression::read("3*t + x", &Constants::default()).expect("an expression");
        assert_eq!(TimeValue::Expression(expression).at(2.0), 6.0);
    }
}
