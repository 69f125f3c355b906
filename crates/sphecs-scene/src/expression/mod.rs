//! Expressions of scene files: numbers that may depend on named constants, and fields of x, y, z,
//! t.
//!
//! Text → [`parser`] → [`syntax`] (a tree, every fault with its column) → parts without variables
//! computed → [`program`] (the tree in postfix order). The functions and operators are in
//! [`operators`], named numbers in [`constants`]. A [`time_function`] is an expression of t alone
//! with its [`derivative`]s.

pub mod constants;
pub mod derivative;
pub mod operators;
pub mod parser;
pub mod program;
pub mod syntax;
pub mod time_function;

pub use constants::Constants;
use program::Program;
use syntax::{Syntax, SyntaxFault};
pub use time_function::TimeFunction;

/// A number that may depend on position (m) and time (s).
#[derive(Clone, Debug)]
pub enum Expression {
    /// One value everywhere and at all times.
    Constant(f64),
    /// A formula of x, y, z, t.
    Formula(Program),
}

impl Expression {
    /// Reads an expression of x, y, z, t and the constants.
    ///
    /// # Errors
    /// The fault with its position in the text.
    pub fn read(text: &str, constants: &Constants) -> Result<Self, SyntaxFault> {
        let tree = parser::read(text, constants)?.folded();
        Self::compiled(&tree).ok_or_else(|| {
            SyntaxFault::whole(text, "computes a number that is not finite, must not divide by zero")
        })
    }

    /// Compiles a folded tree; None as for [`Program::new`].
    fn compiled(tree: &Syntax) -> Option<Self> {
        match tree {
            Syntax::Number(value) => Some(Expression::Constant(*value)),
            tree => Program::new(tree).map(Expression::Formula),
        }
    }

    /// Returns the value at a position (m) and time (s).
    pub fn value(&self, x: f64, y: f64, z: f64, t: f64) -> f64 {
        match self {
            Expression::Constant(value) => *value,
            Expression::Formula(formula) => formula.value([x, y, z, t]),
        }
    }

    /// Returns true if it depends on any of these variables, given by their indices in x, y, z, t.
    pub fn depends_on(&self, places: &[usize]) -> bool {
        match self {
            Expression::Constant(_) => false,
            Expression::Formula(formula) => formula.depends_on(places),
        }
    }

    /// Returns the value if it depends on no variable.
    pub fn constant(&self) -> Option<f64> {
        match self {
            Expression::Constant(value) => Some(*value),
            Expression::Formula(_) => None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(text: &str, x: f64, y: f64, t: f64) -> f64 {
        let mut constants = Constants::default();
        constants.define("v0", 4.45e-2);
        constants.define("D1", 0.0889);
        constants.define("exponent", 3.0);
        match Expression::read(text, &constants) {
            Ok(expression) => expression.value(x, y, 0.0, t),
            Err(fault) => panic!("{text}: {fault:?}"),
        }
    }

    fn check(text: &str, expected: f64) {
        let found = value(text, 2.0, -3.0, 0.5);
        assert!(
            (found - expected).abs() <= 1e-14 * expected.abs().max(1.0),
            "{text} gave {found}, not {expected}"
        );
    }

    #[test]
    fn precedence_follows_mathematics() {
        check("-y^2", -9.0);
        check("2^-1", 0.5);
        check("2^3^2", 512.0);
        check("8/4/2", 1.0);
        check("8/4*2", 4.0);
        check("10-4-3", 3.0);
        check("10-4+3", 9.0);
        check("x/-y^2", -2.0 / 9.0);
        check("1 - 4*y^2/6", -5.0);
        check("-x-y", 1.0);
        check("2*-x", -4.0);
    }

    #[test]
    fn calls_nest() {
        check("max(min(x, y), min(t, max(y, 1e-1)))", 0.1);
        check("atan2(y, x) - atan2(-3, 2)", 0.0);
        check("sqrt(abs(y)+1)*exp(0)", 2.0);
        check("sin(pi/2) + cos(0)^2", 2.0);
        check("exponent*x", 6.0);
    }

    #[test]
    fn comparisons_give_one_or_zero() {
        check("y > 0", 0.0);
        check("y < 0 && x >= 2", 1.0);
        check("(y > 0)*5 + (y <= 0)*7", 7.0);
        check("x == 2 || y == 2", 1.0);
        check("x != 2", 0.0);
        check("1 + 1 > 1", 1.0);
    }

    #[test]
    fn the_inlet_of_the_constricted_channel_is_a_ramped_parabola() {
        let text = "v0 * min(t/0.2, 1) * (1 - 4*y^2/D1^2)";
        assert!((value(text, 0.0, 0.0, 0.1) - 2.225e-2).abs() < 1e-16);
        assert!(value(text, 0.0, 0.04445, 1.0).abs() < 1e-16);
    }

    #[test]
    fn expressions_without_variables_are_folded() {
        let expression = Expression::read("2*(3 + sin(0))", &Constants::default()).map(|e| e.constant());
        assert_eq!(expression.ok().flatten(), Some(6.0));
    }

    #[test]
    fn dependence_on_variables_is_found() {
        let depends = |text: &str, places: &[usize]| {
            Expression::read(text, &Constants::default()).expect("an expression").depends_on(places)
        };
        assert!(depends("y + t", &[0, 1]) && depends("y + t", &[3]) && !depends("y + t", &[0, 2]));
        assert!(!depends("2 + 3", &[0, 1, 2, 3]));
    }

    #[test]
    fn faults_mark_their_token() {
        let place = |text: &str| match Expression::read(text, &Constants::default()) {
            Ok(_) => panic!("{text} was read"),
            Err(fault) => (fault.start, fault.end),
        };
        assert_eq!(place("1 + velocity"), (4, 12));
        assert_eq!(place("1 + * 2"), (4, 5));
        assert_eq!(place("(1 + 2"), (0, 1));
        assert_eq!(place("1 + 2)"), (5, 6));
        assert_eq!(place("min(1)"), (0, 3));
        assert_eq!(place("y $ 2"), (2, 3));
        assert_eq!(place("2 y"), (2, 3));
        assert_eq!(place(""), (0, 0));
    }
}
