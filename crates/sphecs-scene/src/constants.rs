//! The `constants` of a scene, read before everything else.

use super::expression::Constants;
use super::faults::Fault;
use super::notation::tree::{Node, Value};

/// Reads the map of constants; each may use those before it.
pub fn read(root: &Node, faults: &mut Vec<Fault>) -> Constants {
    let mut constants = Constants::default();
    let Some(node) = root.field("constants") else {
        return constants;
    };
    let entries = match &node.value {
        Value::Map(entries) => entries,
        Value::Broken => return constants,
        _ => {
            faults.push(
                Fault::new(
                    "`constants` is not a map",
                    node.head(),
                    format!("is {}, must be a map", node.kind()),
                )
                .help("write `constants: {\"v0\": 0.05, \"D\": \"2*R\"}`"),
            );
            return constants;
        }
    };
    for (key, value) in entries {
        let Value::Text(name, _) = &key.value else {
            let label = format!("is {}, must be text in quotes", key.kind());
            faults.push(Fault::new("the name of a constant is not text", key.head(), label));
            continue;
        };
        if let Some(reason) = Constants::refuses(name) {
            faults.push(Fault::new(format!("`{name}` cannot be the name of a constant"), key.span, reason));
            continue;
        }
        if constants.get(name).is_some() {
            let label = "must be given once";
            faults.push(Fault::new(format!("constant `{name}` is given twice"), key.span, label));
        }
        let number = match &value.value {
            Value::Number(number, _) if number.is_finite() => *number,
            Value::Text(text, inner) => match constants.number(text) {
                Ok(number) => number,
                Err(fault) => {
                    faults.push(fault.into_fault(value.span, *inner));
                    1.0
                }
            },
            Value::Broken => 1.0,
            _ => {
                let label =
                    format!("is {}, must be a finite number or an expression in quotes", value.kind());
                faults.push(Fault::new(format!("constant `{name}` is not a number"), value.head(), label));
                1.0
            }
        };
        constants.define(name, number);
    }
    constants
}
