//! Parser of RON text into a tree, with all syntax faults.
//!
//! After a fault the reader continues behind the next comma of the same bracket, so that one run
//! names every fault. It stops where brackets do not match, because everything after that would be
//! a guess.

use super::lexer::Cursor;
use super::tree::{Name, Node, Span, StructField, Value};
use crate::faults::Fault;
use crate::units;

/// Largest nesting, more than any scene needs; it bounds the recursion.
const MAX_DEPTH: usize = 48;

/// Result of reading a text.
#[derive(Clone, Debug)]
pub struct Parsed {
    /// The values, [`Value::Broken`] where nothing could be read.
    pub root: Node,
    /// Syntax faults.
    pub faults: Vec<Fault>,
    /// True if brackets do not match; then the tree has no meaning.
    pub unbalanced: bool,
}

/// Reads a RON text.
pub fn read(text: &str) -> Parsed {
    let mut reader = Reader { cursor: Cursor::new(text), faults: Vec::new(), unbalanced: false, depth: 0 };
    reader.blanks();
    reader.skip_attributes();
    let root = reader.value();
    reader.blanks();
    if reader.cursor.peek().is_some() {
        let here = reader.cursor.here();
        let label = "the value ended before this";
        reader.fault(Fault::new("text after the end", here, label));
    }
    Parsed { root, faults: reader.faults, unbalanced: reader.unbalanced }
}

struct Reader<'a> {
    cursor: Cursor<'a>,
    faults: Vec<Fault>,
    /// Brackets do not match: nothing more is reported.
    unbalanced: bool,
    depth: usize,
}

impl Reader<'_> {
    fn fault(&mut self, fault: Fault) {
        if !self.unbalanced {
            self.faults.push(fault);
        }
    }

    fn give_up(&mut self, fault: Fault) {
        self.fault(fault);
        self.unbalanced = true;
    }

    fn blanks(&mut self) {
        if let Err(fault) = self.cursor.skip_blanks() {
            self.give_up(fault);
        }
    }

    /// Skips attributes such as `#![enable(implicit_some)]`: all extensions are always enabled.
    fn skip_attributes(&mut self) {
        while self.cursor.rest().starts_with("#!") {
            let end = self.cursor.rest().find(']').map_or(2, |i| i + 1);
            self.cursor.at += end;
            self.blanks();
        }
    }

    fn value(&mut self) -> Node {
        let start = self.cursor.at;
        let value = match self.cursor.peek() {
            _ if self.depth >= MAX_DEPTH => {
                let here = self.cursor.here();
                self.give_up(Fault::new(
                    "brackets are nested too deeply",
                    here,
                    format!("must be at most {MAX_DEPTH} deep"),
                ));
                self.cursor.at += self.cursor.rest().len();
                Value::Broken
            }
            Some('(') => {
                let value = self.brackets(None);
                self.unless_expression(start, value)
            }
            Some('[') => {
                let open = self.cursor.here();
                let mut items = Vec::new();
                self.items(open, ']', |reader| {
                    let item = reader.value();
                    items.push(item);
                });
                Value::List(items)
            }
            Some('{') => self.map(),
            Some('"') => match self.cursor.text() {
                Ok((text, inner)) => Value::Text(text, inner),
                Err(fault) => self.broken(fault),
            },
            Some('r') if self.raw_text_next() => match self.cursor.raw_text() {
                Ok((text, inner)) => Value::Text(text, inner),
                Err(fault) => self.broken(fault),
            },
            Some(c) if c.is_ascii_digit() || matches!(c, '+' | '-' | '.') => self.number(),
            Some(c) if c.is_alphabetic() || c == '_' => {
                let value = self.named();
                self.unless_expression(start, value)
            }
            other => {
                let here = self.cursor.here();
                if let Some(fault) = other.and_then(|c| typographic(c, here)) {
                    return Node { value: self.broken(fault), span: Span::new(start, self.cursor.at) };
                }
                let what = other.map_or("the text ends".to_owned(), |c| format!("found `{c}`"));
                self.broken(Fault::new(
                    "a value is missing",
                    here,
                    format!("{what}, must be a number, text in quotes, a name or a bracket"),
                ))
            }
        };
        Node { value, span: Span::new(start, self.cursor.at) }
    }

    fn number(&mut self) -> Value {
        let start = self.cursor.at;
        let rest = self.cursor.rest();
        let written = &rest[..rest.find([',', ')', ']', '}', '\n']).unwrap_or(rest.len())];
        if let Some((number, unit, at)) = units::quantity(written.trim_end()) {
            let place = Span::new(start + at, start + written.trim_end().len());
            let fault = Fault::new("a number has a unit", place, "must be left out");
            return self.broken(fault.help(units::advice(number, unit)));
        }
        match self.cursor.number() {
            Ok((value, whole)) => self.unless_expression(start, Value::Number(value, whole)),
            Err(fault) => self.broken(fault),
        }
    }

    /// Returns the value, or reports an expression without quotes if an operator follows.
    fn unless_expression(&mut self, start: usize, value: Value) -> Value {
        let after = self.cursor.at;
        self.blanks();
        if self.cursor.peek().is_none_or(|next| !"*/+-^".contains(next)) {
            self.cursor.at = after;
            return value;
        }
        self.synchronise();
        let place = Span::new(start, self.cursor.trimmed());
        let written = self.cursor.between(place);
        let help = format!(
            "write it in quotes: \"{written}\"; for `--set` in single quotes, too: --set '…=\"{written}\"'"
        );
        self.fault(Fault::new("an expression has no quotes", place, "must be text in quotes").help(help));
        Value::Broken
    }

    fn raw_text_next(&self) -> bool {
        let rest = self.cursor.rest();
        let after = rest[1..].trim_start_matches('#');
        after.starts_with('"')
    }

    fn broken(&mut self, fault: Fault) -> Value {
        self.fault(fault);
        self.synchronise();
        Value::Broken
    }

    /// Skips to the next comma or closing bracket of the current bracket.
    fn synchronise(&mut self) {
        let mut depth = 0_usize;
        loop {
            self.blanks();
            match self.cursor.peek() {
                None => return,
                Some(',') if depth == 0 => return,
                Some(')' | ']' | '}') if depth == 0 => return,
                Some('"') => {
                    if let Err(fault) = self.cursor.text() {
                        self.give_up(fault);
                    }
                    continue;
                }
                Some('(' | '[' | '{') => depth += 1,
                Some(')' | ']' | '}') => depth -= 1,
                Some(_) => {}
            }
            self.cursor.bump();
        }
    }

    fn named(&mut self) -> Value {
        let start = self.cursor.at;
        let text = self.cursor.name();
        let name = Name { text: text.to_owned(), span: Span::new(start, self.cursor.at) };
        match text {
            "true" => return Value::Bool(true),
            "false" => return Value::Bool(false),
            "inf" => return Value::Number(f64::INFINITY, false),
            "NaN" => return Value::Number(f64::NAN, false),
            _ => {}
        }
        let after_name = self.cursor.at;
        self.blanks();
        if self.cursor.peek() == Some('(') {
            self.brackets(Some(name))
        } else {
            self.cursor.at = after_name;
            Value::Name(name.text)
        }
    }

    /// Parses `(…)`: named fields or a tuple, distinguished by `name:` at the first item.
    fn brackets(&mut self, name: Option<Name>) -> Value {
        let open = self.cursor.here();
        let mut inside = self.cursor.clone();
        inside.bump();
        if self.field_next(inside) {
            let mut fields = Vec::new();
            self.items(open, ')', |reader| {
                if let Some(field) = reader.field() {
                    fields.push(field);
                }
            });
            Value::Struct(name, fields)
        } else {
            let mut items = Vec::new();
            self.items(open, ')', |reader| {
                let item = reader.value();
                items.push(item);
            });
            Value::Tuple(name, items)
        }
    }

    /// Returns true if `name:` comes next.
    fn field_next(&self, mut ahead: Cursor<'_>) -> bool {
        if ahead.skip_blanks().is_err() || ahead.name().is_empty() {
            return false;
        }
        ahead.skip_blanks().is_ok() && ahead.peek() == Some(':')
    }

    fn field(&mut self) -> Option<StructField> {
        let start = self.cursor.at;
        let text = self.cursor.name().to_owned();
        let name = Name { span: Span::new(start, self.cursor.at), text };
        if name.text.is_empty() {
            let here = self.cursor.here();
            self.broken(Fault::new("a field has no name", here, "must be `name: value`"));
            return None;
        }
        self.blanks();
        if !self.cursor.eat(':') {
            let help = match name.text.starts_with(|c: char| c.is_ascii_digit()) {
                true => "a number has a point, not a comma: `1.5`".to_owned(),
                false => format!("write `{}: …`", name.text),
            };
            let title = format!("field `{}` has no value", name.text);
            let fault = Fault::new(title, name.span, "must be followed by `:` and a value");
            self.broken(fault.help(help));
            return None;
        }
        self.blanks();
        let value = self.value();
        Some(StructField { name, value })
    }

    fn map(&mut self) -> Value {
        let open = self.cursor.here();
        let mut entries = Vec::new();
        self.items(open, '}', |reader| {
            let key = reader.value();
            reader.blanks();
            if key.value == Value::Broken {
                return;
            }
            if !reader.cursor.eat(':') {
                reader.broken(Fault::new(
                    "an entry of a map has no value",
                    key.head(),
                    "must be followed by `:` and a value, as in `\"v0\": 0.1`",
                ));
                return;
            }
            reader.blanks();
            let value = reader.value();
            entries.push((key, value));
        });
        Value::Map(entries)
    }

    /// Parses items separated by commas, beginning at the opening bracket.
    fn items(&mut self, open: Span, close: char, mut item: impl FnMut(&mut Self)) {
        self.depth += 1;
        self.cursor.bump();
        loop {
            self.blanks();
            match self.cursor.peek() {
                Some(c) if c == close => {
                    self.cursor.bump();
                    break;
                }
                Some(c @ (')' | ']' | '}')) => {
                    let here = self.cursor.here();
                    self.give_up(Fault::new(
                        "brackets do not match",
                        here,
                        format!("is `{c}`, must be `{close}`"),
                    ));
                    self.cursor.bump();
                    break;
                }
                None => {
                    self.give_up(
                        Fault::new("a bracket is never closed", open, "opened here")
                            .help(format!("close it with `{close}`")),
                    );
                    break;
                }
                Some(_) => item(self),
            }
            self.blanks();
            match self.cursor.peek() {
                Some(',') => {
                    self.cursor.bump();
                }
                Some(')' | ']' | '}') | None => {}
                Some(_) => {
                    let here = self.cursor.here();
                    let label = format!("must be `,` or `{close}`");
                    let fault = Fault::new("a comma is missing", here, label);
                    // In `a: 1 b: 2` the next field is readable.
                    if self.field_next(self.cursor.clone()) {
                        self.fault(fault);
                    } else {
                        self.broken(fault);
                        self.cursor.eat(',');
                    }
                }
            }
        }
        self.depth -= 1;
    }
}

/// Returns a fault for a character that a word processor writes in place of one of RON.
fn typographic(character: char, here: Span) -> Option<Fault> {
    let (name, plain) = match character {
        '“' | '”' | '„' | '‟' | '«' | '»' | '‘' | '’' | '‚' => ("quote", '"'),
        '−' | '–' | '—' | '‐' | '‑' => ("minus sign", '-'),
        _ => return None,
    };
    let code = u32::from(character);
    let label = format!("is `{character}` (U+{code:04X}), must be `{plain}`");
    let help =
        format!("replace it in the whole file: an editor or web page has written it in place of `{plain}`");
    Some(Fault::new(format!("a {name} is not plain"), here, label).help(help))
}
