//! Conversion of the tree to serde types, with all faults of kind and name in one run.
//!
//! A value of the wrong kind is reported and replaced by a placeholder of the right one; so is a
//! variant that does not exist. An unknown field is reported and skipped. A fault that only the
//! visitor notices (a missing field, a wrong length) ends the pass. It is reported and remembered,
//! and the next pass finds a placeholder there.

use std::cell::RefCell;
use std::collections::{HashMap, HashSet};

use serde::de::{self, DeserializeOwned, DeserializeSeed};

use super::tree::{Node, Span};
use crate::expression::Constants;
use crate::faults::Fault;

mod deserializer;
mod parts;
mod spanned;
mod value;

pub use spanned::Spanned;

use value::Typed;

/// Context of the faults, shared by all parts of a tree.
struct Context<'a> {
    constants: &'a Constants,
    faults: RefCell<Vec<Fault>>,
    /// Spans of values that a visitor refused.
    refused: RefCell<HashSet<Span>>,
    /// Fields that a visitor missed, by struct.
    missing: RefCell<HashMap<Span, Vec<&'static str>>>,
}

impl Context<'_> {
    fn report(&self, fault: Fault) {
        let mut faults = self.faults.borrow_mut();
        let known = faults.iter().any(|old| old.span == fault.span && old.title == fault.title);
        if !known {
            faults.push(fault);
        }
    }
}

/// Signal that reading ended early.
#[derive(Debug)]
pub struct Abort {
    message: String,
    missing: Option<&'static str>,
    place: Option<(Span, Span)>,
}

impl Abort {
    /// Adds the position, unless an inner value has already done so.
    fn at(mut self, node: Option<&Node>) -> Self {
        if self.place.is_none() {
            self.place = node.map(|node| (node.span, node.head()));
        }
        self
    }
}

impl std::fmt::Display for Abort {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Abort {}

impl de::Error for Abort {
    fn custom<T: std::fmt::Display>(message: T) -> Self {
        Self { message: message.to_string(), missing: None, place: None }
    }

    fn invalid_type(_: de::Unexpected<'_>, expected: &dyn de::Expected) -> Self {
        Self::custom(format!("must be {expected}"))
    }

    fn missing_field(field: &'static str) -> Self {
        Self { message: format!("field `{field}` is missing"), missing: Some(field), place: None }
    }
}

/// Reads a type from a tree, with placeholders for faulty values. Numbers may be expressions of the
/// constants. Returns None, with a fault, only if no placeholder could be found.
pub fn read<T: DeserializeOwned>(root: &Node, constants: &Constants) -> (Option<T>, Vec<Fault>) {
    let context = Context {
        constants,
        faults: RefCell::new(Vec::new()),
        refused: RefCell::new(HashSet::new()),
        missing: RefCell::new(HashMap::new()),
    };
    // Each failed pass adds a position. The bound guards against a visitor that refuses
    // placeholders.
    for _ in 0..1000 {
        let abort = match T::deserialize(Typed::new(Some(root), &context, "the scene")) {
            Ok(value) => return (Some(value), context.faults.into_inner()),
            Err(abort) => abort,
        };
        let Some((span, head)) = abort.place else {
            context.report(Fault::new(abort.message, root.head(), "here"));
            break;
        };
        match abort.missing {
            Some(field) => {
                let label = format!("has no `{field}`");
                context.report(
                    Fault::new(abort.message, head, label)
                        .help(format!("write `{field}: …` between these brackets")),
                );
                let mut missing = context.missing.borrow_mut();
                missing.entry(span).or_default().push(field);
            }
            None => {
                context.report(Fault::new(abort.message, head, "here"));
                if !context.refused.borrow_mut().insert(span) {
                    break;
                }
            }
        }
    }
    (None, context.faults.into_inner())
}

/// Reads one seed from a value.
fn seed<'de, S: DeserializeSeed<'de>>(
    seed: S,
    node: Option<&'de Node>,
    context: &'de Context<'de>,
    field: &'de str,
) -> Result<S::Value, Abort> {
    seed.deserialize(Typed::new(node, context, field))
}
