//! Function of time with its first two derivatives.

use super::derivative::{derivative, size};
use super::syntax::{Syntax, SyntaxFault};
use super::{Constants, Expression, parser};

/// Most nodes of an expression and of its first derivative. A product of n factors has n terms of n
/// factors in the first derivative and n² in the second.
const MOST_NODES: usize = 10_000;

/// An expression of t alone with its first two derivatives.
#[derive(Clone, Debug)]
pub struct TimeFunction {
    /// The value and the two derivatives.
    orders: [Expression; 3],
}

impl TimeFunction {
    /// Returns a function with one value at all times.
    pub fn constant(value: f64) -> Self {
        Self { orders: [value, 0.0, 0.0].map(Expression::Constant) }
    }

    /// Reads an expression of t and the constants.
    ///
    /// # Errors
    /// The fault with its position in the text; x, y and z are not allowed.
    pub fn read(text: &str, constants: &Constants) -> Result<Self, SyntaxFault> {
        let tree = parser::read(text, constants)?.folded();
        if let Some(name) = position_in(&tree) {
            return Err(not_of_time(text, name));
        }
        let too_long = || SyntaxFault::whole(text, "is too long for its second derivative");
        let within = |tree: &Syntax| size(tree) <= MOST_NODES;
        let first = Some(&tree).filter(|tree| within(tree)).map(derivative).ok_or_else(too_long)?;
        let second = Some(&first).filter(|tree| within(tree)).map(derivative).ok_or_else(too_long)?;
        let compiled = |tree: &Syntax, must: &str| {
            Expression::compiled(tree).ok_or_else(|| SyntaxFault::whole(text, must))
        };
        let value = compiled(&tree, "computes a number that is not finite, must not divide by zero")?;
        let rate = "has a derivative that is not finite or nested too deeply";
        Ok(Self { orders: [value, compiled(&first, rate)?, compiled(&second, rate)?] })
    }

    /// Returns the value at a time, s.
    pub fn value(&self, time: f64) -> f64 {
        self.orders[0].value(0.0, 0.0, 0.0, time)
    }

    /// Returns the first derivative at a time (s), 1/s of the unit of the value.
    pub fn rate(&self, time: f64) -> f64 {
        self.orders[1].value(0.0, 0.0, 0.0, time)
    }

    /// Returns the second derivative at a time (s), 1/s² of the unit of the value.
    pub fn acceleration(&self, time: f64) -> f64 {
        self.orders[2].value(0.0, 0.0, 0.0, time)
    }

    /// Returns the value if it is the same at all times.
    pub fn constant_value(&self) -> Option<f64> {
        self.orders[0].constant()
    }
}

/// Returns the first of x, y, z in a tree.
fn position_in(tree: &Syntax) -> Option<&'static str> {
    match tree {
        Syntax::Number(_) => None,
        Syntax::Variable(name) => (*name != "t").then_some(*name),
        Syntax::Unary(_, a) => position_in(a),
        Syntax::Binary(_, a, b) => position_in(a).or_else(|| position_in(b)),
    }
}

/// Returns the fault of an expression that has a variable besides t, at its first occurrence.
fn not_of_time(text: &str, name: &'static str) -> SyntaxFault {
    let of_name = |c: char| c.is_alphanumeric() || c == '_';
    let start = text
        .match_indices(name)
        .map(|(start, _)| start)
        .find(|start| !text[..*start].ends_with(of_name) && !text[start + name.len()..].starts_with(of_name));
    let (start, end) = start.map_or((0, text.len()), |start| (start, start + name.len()));
    SyntaxFault {
        title: format!("`{name}` cannot be in a motion"),
        label: "must depend on t alone: a wall moves as a rigid body".to_owned(),
        help: None,
        start,
        end,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<TimeFunction, SyntaxFault> {
        let mut constants = Constants::default();
        constants.define("f", 2.0);
        TimeFunction::read(text, &constants)
    }

    #[test]
    fn orders_are_the_value_and_its_derivatives() {
        let cubic = read("f*t^3 - t").expect("a function");
        assert_eq!([cubic.value(2.0), cubic.rate(2.0), cubic.acceleration(2.0)], [14.0, 23.0, 24.0]);
        assert_eq!(cubic.constant_value(), None);
        let constant = read("f + 1").expect("a function");
        assert_eq!(constant.constant_value(), Some(3.0));
        assert_eq!([constant.rate(1.0), constant.acceleration(1.0)], [0.0; 2]);
        assert_eq!(TimeFunction::constant(3.0).value(7.0), 3.0);
    }

    #[test]
    fn positions_are_refused_where_they_occur() {
        let fault = read("exp(t) + 2*x").expect_err("depends on x");
        assert_eq!((fault.start, fault.end), (11, 12));
        assert!(fault.title.contains("`x`") && fault.label.contains("t alone"), "{fault:?}");
        let fault = read("y - max(z, t)").expect_err("depends on y");
        assert_eq!((fault.start, fault.end), (0, 1));
        assert_eq!(read("2*(t").expect_err("a bracket is open").start, 2);
    }

    #[test]
    fn expressions_that_cannot_be_differentiated_are_faults() {
        let long = vec!["t"; 200].join("*");
        assert!(read(&long).expect_err("too long").label.contains("too long"));
        assert!(read("t + 1/0").is_err());
        let mut nested = "t".to_owned();
        for _ in 0..20 {
            nested = format!("sin(t*{nested})");
        }
        let nested = read(&nested).expect("a deep function");
        assert!(nested.acceleration(0.5).is_finite());
    }
}
