//! JSON Schema of the scene file, for editors that complete its JSON or YAML twin.
//!
//! A field has its unit and its default in words as `x-unit` and `x-default`.

use serde_json::{Map, Value};

use super::doc_line::DocLine;
use crate::schema::SceneFile;

/// Returns the JSON Schema of a scene file.
pub fn json_schema() -> Value {
    let mut schema = derived();
    complete(&mut schema);
    schema
}

/// Returns the schema as the types give it.
pub(super) fn derived() -> Value {
    schemars::schema_for!(SceneFile).to_value()
}

/// Adds units and defaults, and text to what a number may be.
fn complete(schema: &mut Value) {
    match schema {
        Value::Object(entries) => {
            if let Some(Value::String(text)) = entries.get("description") {
                describe(&text.clone(), entries);
            }
            if let Some(kind) = entries.get_mut("type") {
                allow_expressions(kind);
            }
            entries.values_mut().for_each(complete);
        }
        Value::Array(items) => items.iter_mut().for_each(complete),
        _ => {}
    }
}

/// Writes the parts of a doc line into the schema that it belongs to.
fn describe(text: &str, entries: &mut Map<String, Value>) {
    let line = DocLine::read(text);
    let unwrapped = text.split_whitespace().collect::<Vec<_>>().join(" ");
    entries.insert("description".to_owned(), unwrapped.into());
    for (key, part) in [("x-unit", line.unit), ("x-default", line.default)] {
        if let Some(part) = part {
            entries.insert(key.to_owned(), part.into());
        }
    }
}

/// Lets a number be an expression in quotes as well.
fn allow_expressions(kind: &mut Value) {
    let is_number = |kind: &Value| kind == "number" || kind == "integer";
    let text = Value::from("string");
    if is_number(kind) {
        *kind = Value::Array(vec![kind.take(), text]);
    } else if let Value::Array(kinds) = kind
        && kinds.iter().any(is_number)
        && !kinds.contains(&text)
    {
        kinds.insert(1, text);
    }
}
