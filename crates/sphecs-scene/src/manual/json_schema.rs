//! JSON Schema of the scene file, for editors that complete its JSON or YAML twin.
//!
//! A field has its unit, its default in words and its first version as `x-unit`, `x-default` and
//! `x-since`, a choice its first version.

use serde_json::{Map, Value};

use super::doc_line::DocLine;
use super::entries::Manual;
use super::since::since;
use crate::schema::SceneFile;

/// Returns the JSON Schema of a scene file.
pub fn json_schema() -> Value {
    let mut schema = derived();
    complete(&mut schema);
    date_page("Scene", &mut schema);
    if let Some(pages) = schema["$defs"].as_object_mut() {
        // A definition that is no page holds the parameters of a choice, which is dated itself.
        let manual = Manual::read();
        let is_page = |name: &str| manual.page(name).is_some();
        pages.iter_mut().filter(|(name, _)| is_page(name)).for_each(|(name, page)| date_page(name, page));
    }
    schema
}

/// Returns the schema as the types give it.
pub(super) fn derived() -> Value {
    schemars::schema_for!(SceneFile).to_value()
}

/// Adds the first versions of the fields or choices of a page.
fn date_page(page: &str, schema: &mut Value) {
    date_fields(page, schema);
    for choice in schema.get_mut("oneOf").and_then(Value::as_array_mut).into_iter().flatten() {
        if let Some(name) = choice["const"].as_str() {
            choice["x-since"] = since(&format!("{page}.{name}")).into();
        }
        date_fields(page, choice);
        for (name, value) in choice.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten()
        {
            date_fields(&format!("{page}.{name}"), value);
        }
    }
}

/// Adds the first versions of the properties of a schema.
fn date_fields(owner: &str, schema: &mut Value) {
    for (name, field) in schema.get_mut("properties").and_then(Value::as_object_mut).into_iter().flatten() {
        if field.is_object() {
            field["x-since"] = since(&format!("{owner}.{name}")).into();
        }
    }
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
