//! Syntax tree of an expression, and syntax faults.

use super::operators::{binary, unary};
use crate::faults::Fault;
use crate::notation::tree::Span;

/// Variables of a field: position (m) and time (s).
pub const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];

/// A fault of an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntaxFault {
    /// Title: the fault in one line.
    pub title: String,
    /// Label of the marked text: the value found and the value required.
    pub label: String,
    /// Advice to the user.
    pub help: Option<String>,
    /// First byte in the expression.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl SyntaxFault {
    /// Returns a fault that marks the whole expression.
    pub fn whole(text: &str, label: &str) -> Self {
        Self {
            title: format!("the expression \"{text}\" cannot be used"),
            label: label.to_owned(),
            help: None,
            start: 0,
            end: text.len(),
        }
    }

    /// Returns the fault at its position in the scene.
    ///
    /// `span` is the span of the quoted text, `inner` its first byte inside the quotes. `inner` is
    /// None if the text has escapes; then all of it is marked.
    pub fn into_fault(self, span: Span, inner: Option<usize>) -> Fault {
        let place = match inner {
            Some(inner) => Span::new(inner + self.start, inner + self.end),
            None => span,
        };
        let fault = Fault::new(self.title, place, self.label);
        match self.help {
            Some(help) => fault.help(help),
            None => fault,
        }
    }
}

/// An expression as a tree.
#[derive(Clone, Debug)]
pub enum Syntax {
    /// A number or a constant.
    Number(f64),
    /// x, y, z or t.
    Variable(&'static str),
    /// A function of one argument, or `-`.
    Unary(&'static str, Box<Syntax>),
    /// A function or operator of two values.
    Binary(&'static str, Box<Syntax>, Box<Syntax>),
}

impl Syntax {
    /// Computes all parts that depend on no variable.
    #[must_use]
    pub fn folded(self) -> Self {
        match self {
            Syntax::Unary(name, a) => match (a.folded(), unary(name)) {
                (Syntax::Number(a), Some((_, apply))) => Syntax::Number(apply(a)),
                (Syntax::Number(a), None) => Syntax::Number(-a),
                (a, _) => Syntax::Unary(name, Box::new(a)),
            },
            Syntax::Binary(name, a, b) => match (a.folded(), b.folded(), binary(name)) {
                (Syntax::Number(a), Syntax::Number(b), Some((_, apply))) => Syntax::Number(apply(a, b)),
                (a, b, _) => Syntax::Binary(name, Box::new(a), Box::new(b)),
            },
            leaf => leaf,
        }
    }
}
