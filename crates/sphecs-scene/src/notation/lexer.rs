//! Blanks, comments, numbers, names and strings of RON.

use super::tree::Span;
use crate::faults::Fault;

/// Position in a text that moves forwards.
#[derive(Clone, Debug)]
pub struct Cursor<'a> {
    text: &'a str,
    /// Next byte.
    pub at: usize,
}

impl<'a> Cursor<'a> {
    /// Returns a cursor at the beginning of a text.
    pub fn new(text: &'a str) -> Self {
        Self { text, at: 0 }
    }

    /// Returns the remaining text.
    pub fn rest(&self) -> &'a str {
        self.text.get(self.at..).unwrap_or("")
    }

    /// Returns the position behind the last character that is not blank.
    pub fn trimmed(&self) -> usize {
        self.text[..self.at].trim_end().len()
    }

    /// Returns a part of the text.
    pub fn between(&self, place: Span) -> &'a str {
        self.text.get(place.start..place.end).unwrap_or("")
    }

    /// Returns the next character.
    pub fn peek(&self) -> Option<char> {
        self.rest().chars().next()
    }

    /// Takes the next character.
    pub fn bump(&mut self) -> Option<char> {
        let next = self.peek()?;
        self.at += next.len_utf8();
        Some(next)
    }

    /// Takes `token` if it is the next character.
    pub fn eat(&mut self, token: char) -> bool {
        let found = self.peek() == Some(token);
        if found {
            self.at += token.len_utf8();
        }
        found
    }

    /// Returns the span of the next character, empty at the end.
    pub fn here(&self) -> Span {
        Span::new(self.at, self.at + self.peek().map_or(0, char::len_utf8))
    }

    /// Skips blanks and comments, `//` and nested `/* */`.
    ///
    /// # Errors
    /// A comment that is never closed.
    pub fn skip_blanks(&mut self) -> Result<(), Fault> {
        loop {
            let rest = self.rest();
            if rest.starts_with("//") {
                self.at += rest.find('\n').unwrap_or(rest.len());
            } else if rest.starts_with("/*") {
                self.skip_block_comment()?;
            } else if rest.chars().next().is_some_and(char::is_whitespace) {
                self.bump();
            } else {
                return Ok(());
            }
        }
    }

    fn skip_block_comment(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let mut depth = 0_usize;
        loop {
            let rest = self.rest();
            if rest.starts_with("/*") {
                depth += 1;
                self.at += 2;
            } else if rest.starts_with("*/") {
                depth -= 1;
                self.at += 2;
                if depth == 0 {
                    return Ok(());
                }
            } else if self.bump().is_none() {
                return Err(Fault::new("a comment never ends", Span::new(start, start + 2), "opened here")
                    .help("close it with `*/`"));
            }
        }
    }

    /// Takes a name: letters, digits and `_`.
    pub fn name(&mut self) -> &'a str {
        let rest = self.rest();
        let length = rest.find(|c: char| !(c.is_alphanumeric() || c == '_')).unwrap_or(rest.len());
        self.at += length;
        &rest[..length]
    }

    /// Takes a number; the second value is true if it has neither point nor exponent.
    ///
    /// # Errors
    /// Text that begins like a number but is not one.
    pub fn number(&mut self) -> Result<(f64, bool), Fault> {
        let start = self.at;
        let rest = self.rest();
        let mut previous = ' ';
        let length = rest
            .find(|c: char| {
                let sign = matches!(c, '+' | '-') && matches!(previous, 'e' | 'E' | ' ');
                let part = c.is_alphanumeric() || matches!(c, '.' | '_') || sign;
                previous = c;
                !part
            })
            .unwrap_or(rest.len());
        self.at += length;
        let token = &rest[..length];
        let plain = token.replace('_', "");
        let digits = plain.trim_start_matches(['+', '-']);
        let whole = !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit());
        let spelt =
            digits.starts_with(|c: char| c.is_ascii_digit() || c == '.') || matches!(digits, "inf" | "NaN");
        match plain.parse::<f64>() {
            Ok(value) if spelt => Ok((value, whole)),
            _ => Err(Fault::new(
                format!("`{token}` is not a number"),
                Span::new(start, self.at),
                "must be like `12`, `-0.5` or `1.0e-3`",
            )
            .help("put an expression of the constants in quotes: \"2*h0\"")),
        }
    }

    /// Takes text in quotes, with the byte at which it begins if it has no escapes.
    ///
    /// # Errors
    /// Text that is never closed, or an escape unknown to RON.
    pub fn text(&mut self) -> Result<(String, Option<usize>), Fault> {
        let start = self.at;
        self.bump();
        let inner = self.at;
        let mut text = String::new();
        let mut escaped = false;
        let mut fault = None;
        loop {
            let here = self.at;
            match self.bump() {
                Some('"') => {
                    return match fault {
                        Some(fault) => Err(fault),
                        None => Ok((text, (!escaped).then_some(inner))),
                    };
                }
                Some('\\') => {
                    escaped = true;
                    match self.escape(here) {
                        Ok(character) => text.push(character),
                        // The text is read to its end, since its closing quote would otherwise open
                        // another text.
                        Err(wrong) => fault = fault.or(Some(wrong)),
                    }
                }
                Some(other) => text.push(other),
                None => {
                    return Err(Fault::new(
                        "text never ends",
                        Span::new(start, start + 1),
                        "this quote is never closed",
                    )
                    .help("close it with `\"`"));
                }
            }
        }
    }

    /// Takes raw text `r"…"` or `r#"…"#`.
    ///
    /// # Errors
    /// Text that is never closed.
    pub fn raw_text(&mut self) -> Result<(String, Option<usize>), Fault> {
        let start = self.at;
        self.bump();
        let hashes = self.rest().len() - self.rest().trim_start_matches('#').len();
        self.at += hashes + 1;
        let end = format!("\"{}", "#".repeat(hashes));
        let inner = self.at;
        match self.rest().find(&end) {
            Some(length) => {
                let text = self.rest()[..length].to_owned();
                self.at += length + end.len();
                Ok((text, Some(inner)))
            }
            None => {
                self.at = self.text.len();
                Err(Fault::new("text never ends", Span::new(start, start + 1), "this quote is never closed")
                    .help(format!("close it with `{end}`")))
            }
        }
    }

    fn escape(&mut self, start: usize) -> Result<char, Fault> {
        let simple = match self.bump() {
            Some('n') => Some('\n'),
            Some('t') => Some('\t'),
            Some('r') => Some('\r'),
            Some('0') => Some('\0'),
            Some(same @ ('\\' | '"' | '\'')) => Some(same),
            Some('u') if self.eat('{') => {
                let rest = self.rest();
                let length = rest.find('}').unwrap_or(0).min(8);
                let digits = rest.get(..length).unwrap_or("");
                self.at += digits.len();
                let value = u32::from_str_radix(digits, 16).ok().and_then(char::from_u32);
                value.filter(|_| self.eat('}'))
            }
            _ => None,
        };
        simple.ok_or_else(|| {
            Fault::new(
                "unknown escape in text",
                Span::new(start, self.at),
                "must be one of `\\n`, `\\t`, `\\r`, `\\0`, `\\\\`, `\\\"`, `\\u{…}`",
            )
        })
    }
}
