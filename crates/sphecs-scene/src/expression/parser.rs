//! Expression text → tree, every fault with its column.
//!
//! Precedence, loosest first: `||`, `&&`, comparisons, `+ -`, `* /`, unary `-`, `^` (from the
//! right).

use super::constants::Constants;
use super::operators::{FUNCTIONS, OPERATORS, PAIR_FUNCTIONS, binary, unary};
use super::syntax::{Syntax, SyntaxFault, VARIABLES};
use crate::faults::advice;
use crate::units;

/// Largest nesting, more than any formula needs; it bounds the recursion.
const MAX_DEPTH: usize = 48;

/// Reads an expression.
///
/// # Errors
/// The first fault, with its position.
pub fn read(text: &str, constants: &Constants) -> Result<Syntax, SyntaxFault> {
    read_with(text, constants, &VARIABLES)
}

/// Reads an expression that has these variables only.
///
/// # Errors
/// The first fault, with its position.
pub fn read_with(
    text: &str,
    constants: &Constants,
    variables: &'static [&'static str],
) -> Result<Syntax, SyntaxFault> {
    let mut reader = Reader { text, at: 0, depth: 0, constants, variables };
    let tree = reader.binary(0)?;
    reader.blanks();
    if reader.at < text.len() {
        if let Some(fault) = reader.unit() {
            return Err(fault);
        }
        let next = reader.next_token();
        let label = match next.0 {
            ")" => "there is no bracket to close",
            _ => "must be an operator such as `*`",
        };
        return Err(reader.fault(format!("`{}` cannot stand here", next.0), label, next.1, next.2));
    }
    Ok(tree)
}

struct Reader<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    constants: &'a Constants,
    /// Variables that the expression may have.
    variables: &'static [&'static str],
}

/// Returns the precedence of an operator; its right side is parsed one level higher, except for
/// `^`.
fn precedence(operator: &str) -> usize {
    match operator {
        "||" => 1,
        "&&" => 2,
        "+" | "-" => 4,
        "*" | "/" => 5,
        "^" => 7,
        _ => 3,
    }
}
const NEGATION: usize = 6;

impl<'a> Reader<'a> {
    fn fault(&self, title: impl Into<String>, label: &str, start: usize, end: usize) -> SyntaxFault {
        SyntaxFault { title: title.into(), label: label.to_owned(), help: None, start, end }
    }

    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn blanks(&mut self) {
        self.at = self.text.len() - self.rest().trim_start().len();
    }

    /// Returns the next token for a message: text, start, end.
    fn next_token(&self) -> (&'a str, usize, usize) {
        let rest = self.rest();
        let word = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        let length = if word > 0 { word } else { rest.chars().next().map_or(0, char::len_utf8) };
        (&rest[..length], self.at, self.at + length)
    }

    /// Returns a fault if the rest of the text is a unit.
    fn unit(&self) -> Option<SyntaxFault> {
        let (name, start, _) = self.next_token();
        let value = units::value(self.rest())?;
        if self.constants.get(name).is_some() {
            return None;
        }
        let label = "must be left out";
        let fault =
            self.fault(format!("a number has a unit, `{}`", self.rest()), label, start, self.text.len());
        let help = match self.text[..start].trim().parse() {
            Ok(number) => units::advice(number, value),
            Err(_) => format!("all numbers are in SI units without a name: multiply by `{value:e}`"),
        };
        Some(SyntaxFault { help: Some(help), ..fault })
    }

    fn operator(&self) -> Option<&'static str> {
        OPERATORS.iter().map(|(name, _)| *name).find(|name| self.rest().starts_with(name))
    }

    fn binary(&mut self, weakest: usize) -> Result<Syntax, SyntaxFault> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(SyntaxFault::whole(self.text, "is nested too deeply"));
        }
        let mut left = self.operand()?;
        loop {
            self.blanks();
            let Some(operator) = self.operator() else {
                break;
            };
            let binds = precedence(operator);
            if binds < weakest {
                break;
            }
            self.at += operator.len();
            let right = self.binary(if operator == "^" { NEGATION } else { binds + 1 })?;
            left = Syntax::Binary(operator, Box::new(left), Box::new(right));
        }
        self.depth -= 1;
        Ok(left)
    }

    fn operand(&mut self) -> Result<Syntax, SyntaxFault> {
        self.blanks();
        let (token, start, end) = self.next_token();
        match token.chars().next() {
            Some('-') => {
                self.at = end;
                let operand = self.binary(NEGATION)?;
                Ok(Syntax::Unary("-", Box::new(operand)))
            }
            Some('+') => {
                self.at = end;
                self.binary(NEGATION)
            }
            Some('(') => {
                self.at = end;
                let inner = self.binary(0)?;
                self.close(start)?;
                Ok(inner)
            }
            Some(c) if c.is_ascii_digit() || c == '.' => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => {
                self.at = end;
                self.named(token, start, end)
            }
            Some(_) => {
                let label = "must be a number, a name or a bracket";
                let fault = self.fault("a value is missing in the expression", label, start, end);
                let doubled = self.text[..start].ends_with('*') && token == "*";
                let help = doubled.then(|| "a power is written with `^`: `y^2`".to_owned());
                Err(SyntaxFault { help, ..fault })
            }
            None => {
                let at = self.text.len();
                Err(self.fault(
                    "the expression ends too early",
                    "a number, a name or a bracket must follow",
                    at,
                    at,
                ))
            }
        }
    }

    fn close(&mut self, opened: usize) -> Result<(), SyntaxFault> {
        self.blanks();
        if self.rest().starts_with(')') {
            self.at += 1;
            return Ok(());
        }
        if self.rest().is_empty() {
            let title = "a bracket of the expression is never closed";
            let fault = self.fault(title, "opened here", opened, opened + 1);
            return Err(SyntaxFault { help: Some("close it with `)`".to_owned()), ..fault });
        }
        let (token, start, end) = self.next_token();
        let title = format!("`{token}` cannot stand here");
        Err(self.fault(title, "must be an operator or `)`", start, end))
    }

    fn number(&mut self) -> Result<Syntax, SyntaxFault> {
        let rest = self.rest();
        let mut previous = ' ';
        let length = rest
            .find(|c: char| {
                let sign = matches!(c, '+' | '-') && matches!(previous, 'e' | 'E');
                let part = c.is_ascii_digit() || matches!(c, '.' | 'e' | 'E') || sign;
                previous = c;
                !part
            })
            .unwrap_or(rest.len());
        let (start, end) = (self.at, self.at + length);
        self.at = end;
        match rest[..length].parse::<f64>() {
            Ok(value) if value.is_finite() => Ok(Syntax::Number(value)),
            _ => Err(self.fault(
                format!("`{}` is not a number", &rest[..length]),
                "must be like `12`, `0.5` or `1.0e-3`",
                start,
                end,
            )),
        }
    }

    fn named(&mut self, name: &str, start: usize, end: usize) -> Result<Syntax, SyntaxFault> {
        if let Some(value) = self.constants.get(name) {
            return Ok(Syntax::Number(value));
        }
        if let Some(variable) = self.variables.iter().find(|known| **known == name) {
            return Ok(Syntax::Variable(variable));
        }
        if name == "pi" {
            return Ok(Syntax::Number(std::f64::consts::PI));
        }
        let wanted = match (unary(name), binary(name)) {
            (Some((known, _)), _) => (*known, 1),
            (_, Some((known, _))) => (*known, 2),
            _ => {
                let known: Vec<&str> = self
                    .constants
                    .names()
                    .chain(self.variables.iter().copied())
                    .chain(["pi"])
                    .chain(FUNCTIONS.iter().map(|(name, _)| *name))
                    .chain(PAIR_FUNCTIONS.iter().map(|(name, _)| *name))
                    .collect();
                let label = match self.variables {
                    [] if VARIABLES.contains(&name) => "must not be here: the number is the same everywhere",
                    [] => "neither a constant nor a function",
                    _ => "neither a constant nor a variable nor a function",
                };
                let mut fault =
                    self.fault(format!("unknown name `{name}` in the expression"), label, start, end);
                fault.help = Some(advice(name, known.iter().copied()));
                return Err(fault);
            }
        };
        let mut arguments = self.arguments(name, start, end)?;
        match (arguments.len(), arguments.pop(), arguments.pop()) {
            (1, Some(a), None) if wanted.1 == 1 => Ok(Syntax::Unary(wanted.0, Box::new(a))),
            (2, Some(b), Some(a)) if wanted.1 == 2 => Ok(Syntax::Binary(wanted.0, Box::new(a), Box::new(b))),
            (count, ..) => Err(self.fault(
                format!("`{name}` has the wrong number of arguments"),
                &format!("has {count}, must have {}", wanted.1),
                start,
                end,
            )),
        }
    }

    fn arguments(&mut self, name: &str, start: usize, end: usize) -> Result<Vec<Syntax>, SyntaxFault> {
        self.blanks();
        if !self.rest().starts_with('(') {
            let label = format!("must be followed by its arguments: `{name}(…)`");
            return Err(self.fault(format!("`{name}` is a function"), &label, start, end));
        }
        let opened = self.at;
        self.at += 1;
        let mut arguments = vec![self.binary(0)?];
        loop {
            self.blanks();
            if !self.rest().starts_with(',') {
                break;
            }
            self.at += 1;
            arguments.push(self.binary(0)?);
        }
        self.close(opened)?;
        Ok(arguments)
    }
}
