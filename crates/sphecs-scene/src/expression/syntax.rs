//! An expression as a tree, and what is wrong with one that is none.

use std::fmt::Write;

use super::operators::{binary, unary};
use crate::faults::Fault;
use crate::notation::tree::Span;

/// What a field may depend on.
pub const VARIABLES: [&str; 4] = ["x", "y", "z", "t"];

/// A fault of an expression.
#[derive(Clone, Debug, PartialEq)]
pub struct SyntaxFault {
    /// What is wrong.
    pub title: String,
    /// What stands there and what may stand there.
    pub label: String,
    /// What to do.
    pub help: Option<String>,
    /// First byte in the expression.
    pub start: usize,
    /// One past the last byte.
    pub end: usize,
}

impl SyntaxFault {
    /// A fault of the expression as a whole.
    pub fn whole(text: &str, label: &str) -> Self {
        Self {
            title: format!("the expression \"{text}\" cannot be used"),
            label: label.to_owned(),
            help: None,
            start: 0,
            end: text.len(),
        }
    }

    /// The fault in the scene: `span` is the place of the quoted text, `inner` where the text in it
    /// begins (None if it has escapes: then the whole is marked).
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
    /// The same with everything computed that depends on nothing.
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

    /// The same as text for exmex, everything in brackets.
    pub fn to_exmex(&self) -> String {
        let mut text = String::new();
        self.write(&mut text);
        text
    }

    fn write(&self, out: &mut String) {
        match self {
            // exmex reads no exponents; `{}` writes none. Writing to a String cannot fail.
            Syntax::Number(value) if *value < 0.0 => {
                let _ = write!(out, "(-{})", -value);
            }
            Syntax::Number(value) => {
                let _ = write!(out, "{value}");
            }
            Syntax::Variable(name) => out.push_str(name),
            Syntax::Unary(name, a) => {
                let _ = write!(out, "({name}(");
                a.write(out);
                out.push_str("))");
            }
            Syntax::Binary(name, a, b) => {
                out.push_str("((");
                a.write(out);
                let _ = write!(out, ") {name} (");
                b.write(out);
                out.push_str("))");
            }
        }
    }
}
