//! A value to be read, and the faults of a wrong kind.

use super::Context;
use super::parts::{Entries, Variant};
use crate::expression::operators::{binary, unary};
use crate::faults::{Fault, advice, nearest};
use crate::notation::tree::{Node, StructField, Value};
use crate::synonyms;

/// A value to be read; `node` is None for a placeholder.
#[derive(Clone, Copy)]
pub(super) struct Typed<'a> {
    pub(super) node: Option<&'a Node>,
    pub(super) context: &'a Context<'a>,
    /// Name of the field that holds it, for messages.
    pub(super) field: &'a str,
}

impl<'a> Typed<'a> {
    pub(super) fn new(node: Option<&'a Node>, context: &'a Context<'a>, field: &'a str) -> Self {
        let node =
            node.filter(|node| node.value != Value::Broken && !context.refused.borrow().contains(&node.span));
        Self { node, context, field }
    }

    /// Reports a value of the wrong kind.
    pub(super) fn mismatch(&self, node: &Node, wanted: &str) {
        self.report_mismatch(node, wanted, None);
    }

    fn report_mismatch(&self, node: &Node, wanted: &str, help: Option<String>) {
        let title = format!("`{}` is not {wanted}", self.field);
        let label = format!("is {}, must be {wanted}", node.kind());
        let fault = Fault::new(title, node.head(), label);
        self.context.report(match help {
            Some(help) => fault.help(help),
            None => fault,
        });
        self.refuse(node);
    }

    /// Replaces the value by a placeholder in the next pass.
    pub(super) fn refuse(&self, node: &Node) {
        self.context.refused.borrow_mut().insert(node.span);
    }

    pub(super) fn number(&self) -> f64 {
        let Some(node) = self.node else { return 1.0 };
        match &node.value {
            Value::Number(value, _) => *value,
            Value::Text(text, inner) => match self.context.constants.number(text) {
                Ok(value) => value,
                Err(fault) => {
                    self.context.report(fault.into_fault(node.span, *inner));
                    self.refuse(node);
                    1.0
                }
            },
            Value::Tuple(Some(name), _) if unary(&name.text).is_some() || binary(&name.text).is_some() => {
                let help = format!("write the expression in quotes: \"{}(…)\"", name.text);
                self.report_mismatch(node, "a number or an expression in quotes", Some(help));
                1.0
            }
            _ => {
                self.mismatch(node, "a number or an expression in quotes");
                1.0
            }
        }
    }

    pub(super) fn whole_number(&self) -> u64 {
        let value = self.number();
        // Up to 2^53 every whole number is exact in f64.
        let exact = value.fract() == 0.0 && (0.0..=9.0e15).contains(&value);
        match self.node {
            Some(node) if !exact => {
                self.mismatch(node, "a whole number from 0");
                1
            }
            _ => value as u64,
        }
    }

    pub(super) fn elements(&self) -> Option<&'a [Node]> {
        match &self.node?.value {
            Value::List(items) | Value::Tuple(None, items) => Some(items),
            _ => None,
        }
    }

    /// Returns the named fields of a struct, or reports a fault and returns None.
    pub(super) fn fields(&self, name: &str) -> Option<&'a [StructField]> {
        let node = self.node?;
        match &node.value {
            Value::Struct(given, fields) => {
                if let Some(given) = given.as_ref().filter(|given| given.text != name) {
                    self.context.report(
                        Fault::new(
                            format!("`{}` has the wrong name", self.field),
                            given.span,
                            format!("is `{}`, must be `{name}` or nothing", given.text),
                        )
                        .help(format!("write `{name}(…)` or `(…)`")),
                    );
                }
                Some(fields)
            }
            Value::Tuple(_, items) if items.is_empty() => Some(&[]),
            _ => {
                self.mismatch(node, "a bracket with named fields `(name: value, …)`");
                None
            }
        }
    }

    /// Returns the known fields, with placeholders for missing ones, and reports unknown ones.
    pub(super) fn entries(&self, name: &str, known: &'static [&'static str]) -> Entries<'a> {
        let Some(fields) = self.fields(name) else {
            let all = known.iter().map(|field| (*field, None)).collect();
            return Entries::new(all, self.context);
        };
        let mut entries: Vec<(&str, Option<&Node>)> = Vec::new();
        let mut unless_given = Vec::new();
        for field in fields {
            let text = field.name.text.as_str();
            if !known.contains(&text) {
                self.context.report(
                    Fault::new(
                        format!("unknown field `{text}`"),
                        field.name.span,
                        format!("`{}` has no such field", self.field),
                    )
                    .help(field_advice(text, known)),
                );
                // A misspelt field is not reported as missing, too.
                let meant = match synonyms::field(text, known) {
                    Some((meant, _)) => Some(meant),
                    None => nearest(text, known.iter().copied()),
                };
                unless_given.extend(meant);
            } else if entries.iter().any(|(old, _)| *old == text) {
                self.context.report(Fault::new(
                    format!("field `{text}` is given twice"),
                    field.name.span,
                    "must be given once",
                ));
            } else {
                entries.push((text, Some(&field.value)));
            }
        }
        for field in unless_given {
            if !fields.iter().any(|given| given.name.text == field) {
                entries.push((field, None));
            }
        }
        if let Some(node) = self.node {
            let missing = self.context.missing.borrow();
            entries.extend(missing.get(&node.span).into_iter().flatten().map(|field| (*field, None)));
        }
        Entries::new(entries, self.context)
    }

    /// Returns the chosen variant, or a placeholder of the first one if it does not exist.
    pub(super) fn variant(&self, variants: &'static [&'static str]) -> Variant<'a> {
        let placeholder =
            Variant { name: variants.first().copied().unwrap_or(""), node: None, context: self.context };
        let Some(node) = self.node else {
            return placeholder;
        };
        let (name, span) = match &node.value {
            Value::Name(name) => (name.as_str(), node.span),
            // The quotes around a name do no harm: a scene written by a program may have them.
            Value::Text(name, _) if variants.contains(&name.as_str()) => (name.as_str(), node.span),
            Value::Tuple(Some(name), _) | Value::Struct(Some(name), _) => (name.text.as_str(), name.span),
            _ => {
                let all: Vec<String> = variants.iter().map(|name| format!("`{name}`")).collect();
                let wanted = format!("one of the choices {}", all.join(", "));
                self.report_mismatch(node, &wanted, without_name(node, variants));
                return placeholder;
            }
        };
        match variants.iter().find(|known| **known == name) {
            Some(known) => Variant { name: known, node: Some(node), context: self.context },
            None => {
                self.context.report(
                    Fault::new(
                        format!("`{name}` is not a choice for `{}`", self.field),
                        span,
                        "unknown name",
                    )
                    .help(elsewhere(self.field, name).unwrap_or_else(|| choice_advice(name, variants))),
                );
                self.refuse(node);
                placeholder
            }
        }
    }
}

/// Returns advice on a name that belongs elsewhere in a scene or was renamed.
fn elsewhere(field: &str, name: &str) -> Option<String> {
    let advice = match (field, name) {
        ("condition", "Periodic") => {
            "a periodic flow has neither inlet nor outlet: leave them out and write `periodic: [\"x\"]` in the scene"
        }
        (
            "pressure" | "velocity",
            "Pressure" | "TotalPressure" | "Windkessel" | "Resistance" | "FlowShare",
        ) => {
            "an opening of given pressure is an outlet whichever way it flows: write it under `outlets`, \
             with `towards` out of the domain and this as `condition`"
        }
        ("pressure", "Absorbing") => "it is now called `NonReflecting`, with the same fields",
        _ => return None,
    };
    Some(advice.to_owned())
}

/// Returns advice on an unknown field.
fn field_advice(name: &str, known: &'static [&'static str]) -> String {
    let all = || advice(name, known.iter().copied());
    let synonym = || synonyms::field(name, known).map(|(_, advice)| format!("{advice}; {}", all()));
    former_field(name, known).or_else(synonym).unwrap_or_else(all)
}

/// Returns advice on an unknown choice.
fn choice_advice(name: &str, known: &'static [&'static str]) -> String {
    let all = advice(name, known.iter().copied());
    match synonyms::choice(name, known) {
        Some(meant) => format!("it is called `{meant}` here; {all}"),
        None => all,
    }
}

/// Returns advice on a value where a choice with its name is wanted.
fn without_name(node: &Node, variants: &[&str]) -> Option<String> {
    let has = |name: &str| variants.contains(&name);
    match &node.value {
        Value::Text(text, _) if !has("Normal") => {
            let near = nearest(text, variants.iter().copied()).map(|near| format!("did you mean `{near}`?"));
            near.or_else(|| has("Extrapolated").then(|| given_pressure(&format!("\"{text}\""))))
        }
        Value::Number(number, _) if has("Normal") => {
            Some(format!("a speed along `towards` is written `Normal({number})`"))
        }
        Value::Text(text, _) if has("Normal") => {
            Some(format!("a speed along `towards` is written `Normal(\"{text}\")`"))
        }
        Value::Number(pressure, _) if has("Extrapolated") => Some(given_pressure(&pressure.to_string())),
        Value::Tuple(None, _) | Value::List(_) if has("Normal") => Some(
            "a speed along `towards` is written `Normal(0.1)`, a vector `Components((0.1, 0.0))`".to_owned(),
        ),
        _ => None,
    }
}

/// Returns advice on an inlet with a pressure instead of a velocity.
fn given_pressure(value: &str) -> String {
    format!(
        "an opening of given pressure is an outlet whichever way it flows: write it under `outlets`, with \
         `towards` out of the domain and `condition: Pressure(value: {value})`"
    )
}

/// Returns advice on a renamed field, if the struct has the new name.
fn former_field(name: &str, known: &[&str]) -> Option<String> {
    let (new, advice) = match name {
        "drift" => (
            "drift_correction",
            "write `drift_correction: On` for `drift: Removed`, `drift_correction: Off` for `drift: Kept`",
        ),
        "printed" => ("as_published", "it is now called `as_published`, with the same values"),
        "condition" => (
            "feed",
            "an opening of given pressure is an outlet whichever way it flows: write it under `outlets`, with \
             `towards` out of the domain",
        ),
        _ => return None,
    };
    known.contains(&new).then(|| advice.to_owned())
}
