//! Named constants of a scene.

use super::syntax::{self, Syntax, SyntaxFault};
use super::{Expression, operators, parser};

/// Named constants, in the order of the scene.
#[derive(Clone, Debug, Default)]
pub struct Constants {
    named: Vec<(String, f64)>,
}

impl Constants {
    /// Adds a constant or replaces its value.
    pub fn define(&mut self, name: &str, value: f64) {
        match self.named.iter_mut().find(|(known, _)| known == name) {
            Some((_, old)) => *old = value,
            None => self.named.push((name.to_owned(), value)),
        }
    }

    /// Returns the value of a constant.
    pub fn get(&self, name: &str) -> Option<f64> {
        self.named.iter().find(|(known, _)| known == name).map(|(_, value)| *value)
    }

    /// Returns the names.
    pub fn names(&self) -> impl Iterator<Item = &str> + Clone {
        self.named.iter().map(|(name, _)| name.as_str())
    }

    /// Returns the value of an expression of constants alone.
    ///
    /// # Errors
    /// The fault with its position in the text; x, y, z and t are not allowed.
    pub fn number(&self, text: &str) -> Result<f64, SyntaxFault> {
        match parser::read_with(text, self, &[])?.folded() {
            Syntax::Number(value) if value.is_finite() => Ok(value),
            Syntax::Number(value) => {
                Err(SyntaxFault::whole(text, &format!("gives `{value}`, must be finite")))
            }
            _ => Err(SyntaxFault::whole(text, "must be a number or an expression of the constants")),
        }
    }

    /// Returns an expression of x, y, z, t and the constants.
    ///
    /// # Errors
    /// The fault with its position in the text.
    pub fn field(&self, text: &str) -> Result<Expression, SyntaxFault> {
        Expression::read(text, self)
    }

    /// Returns the reason why a constant cannot have this name, if there is one.
    pub fn refuses(name: &str) -> Option<&'static str> {
        let mut characters = name.chars();
        let begins_well = characters.next().is_some_and(|c| c.is_ascii_alphabetic() || c == '_');
        if !begins_well || !characters.all(|c| c.is_ascii_alphanumeric() || c == '_') {
            Some("must be a letter followed by letters, digits and `_`")
        } else if syntax::VARIABLES.contains(&name) || name == "pi" {
            Some("x, y, z, t and pi have their own meaning")
        } else if operators::unary(name).is_some() || operators::binary(name).is_some() {
            Some("is the name of a function")
        } else {
            None
        }
    }
}
