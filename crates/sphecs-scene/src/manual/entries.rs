//! Structs, fields and choices of the scene file, read from its JSON Schema.

use serde_json::Value;

use super::doc_line::DocLine;
use super::json_schema::derived;
use super::since::since;

/// Reference of the scene file.
#[derive(Clone, Debug)]
pub struct Manual {
    /// Structs and lists of choices, in the order in which the file mentions them; `Scene` first.
    pub pages: Vec<Page>,
}

/// A struct or a list of choices.
#[derive(Clone, Debug)]
pub struct Page {
    /// Name, such as `Outlet`.
    pub name: String,
    /// Meaning in a sentence.
    pub meaning: String,
    /// Fields or choices.
    pub content: Content,
}

/// Content of a page.
#[derive(Clone, Debug)]
pub enum Content {
    /// Fields of a struct.
    Fields(Vec<Field>),
    /// Choices, of which a scene takes one.
    Choices(Vec<Choice>),
}

/// A field of a struct or of a choice.
#[derive(Clone, Debug)]
pub struct Field {
    /// Name, such as `depth`.
    pub name: String,
    /// Meaning, in sentences.
    pub meaning: String,
    /// Unit; None for what has none.
    pub unit: Option<String>,
    /// Default; None if the field is required.
    pub default: Option<String>,
    /// Kind of the value.
    pub value: ValueKind,
    /// First version that has it.
    pub since: &'static str,
}

/// A choice.
#[derive(Clone, Debug)]
pub struct Choice {
    /// Name, such as `WaveEquation`.
    pub name: String,
    /// Meaning, in sentences.
    pub meaning: String,
    /// Unit of its value; None for what has none.
    pub unit: Option<String>,
    /// Content of its brackets.
    pub argument: Argument,
    /// First version that has it.
    pub since: &'static str,
}

/// Content of the brackets of a choice.
#[derive(Clone, Debug)]
pub enum Argument {
    /// No brackets.
    None,
    /// A value without a name.
    Value(ValueKind),
    /// Fields.
    Fields(Vec<Field>),
}

/// Kind of a value.
#[derive(Clone, Debug)]
pub struct ValueKind {
    /// The kind in words, such as "vector"; of a page its name in backticks.
    pub text: String,
    /// Page that describes the value.
    pub page: Option<String>,
    /// True if the value has numbers that are not whole, which have a unit.
    pub has_unit: bool,
}

impl Manual {
    /// Reads the reference from the types of the scene file.
    pub fn read() -> Self {
        let schema = derived();
        let mut pages = vec![page("Scene", &schema, &schema)];
        let mut at = 0;
        while at < pages.len() {
            // Depth first: what a field mentions is described behind its struct.
            let new: Vec<String> = pages[at].mentions();
            let mut place = at + 1;
            for name in new {
                if pages.iter().all(|page| page.name != name) {
                    pages.insert(place, page(&name, &schema["$defs"][name.as_str()], &schema));
                    place += 1;
                }
            }
            at += 1;
        }
        Self { pages }
    }

    /// Returns the page of a name.
    pub fn page(&self, name: &str) -> Option<&Page> {
        self.pages.iter().find(|page| page.name == name)
    }
}

impl Page {
    /// Returns the pages that the values of this one need.
    fn mentions(&self) -> Vec<String> {
        let of_fields =
            |fields: &[Field]| fields.iter().filter_map(|field| field.value.page.clone()).collect();
        match &self.content {
            Content::Fields(fields) => of_fields(fields),
            Content::Choices(choices) => choices
                .iter()
                .flat_map(|choice| match &choice.argument {
                    Argument::None => Vec::new(),
                    Argument::Value(value) => value.page.iter().cloned().collect(),
                    Argument::Fields(fields) => of_fields(fields),
                })
                .collect(),
        }
    }

    /// Returns true if it lists choices.
    pub fn has_choices(&self) -> bool {
        matches!(self.content, Content::Choices(_))
    }
}

impl Choice {
    /// Fields of the choice.
    pub fn fields(&self) -> &[Field] {
        match &self.argument {
            Argument::Fields(fields) => fields,
            Argument::None | Argument::Value(_) => &[],
        }
    }

    /// Returns the choice as a scene has it, such as `Frozen`, `Hybrid(…)` or `Reference(number)`.
    pub fn notation(&self) -> String {
        match &self.argument {
            Argument::None => self.name.clone(),
            Argument::Value(value) => format!("{}({})", self.name, value.text.replace('`', "")),
            Argument::Fields(_) => format!("{}(…)", self.name),
        }
    }
}

fn page(name: &str, schema: &Value, root: &Value) -> Page {
    let content = match schema["oneOf"].as_array() {
        Some(choices) => Content::Choices(choices.iter().map(|one| choice(name, one, root)).collect()),
        None => Content::Fields(fields(name, schema)),
    };
    Page { name: name.to_owned(), meaning: doc_line(schema).meaning, content }
}

fn doc_line(schema: &Value) -> DocLine {
    DocLine::read(schema["description"].as_str().unwrap_or_default())
}

/// Returns the fields of `owner`, a page or a choice such as `Shifting.Local`.
fn fields(owner: &str, schema: &Value) -> Vec<Field> {
    let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
    let is_required = |name: &str| {
        schema["required"].as_array().is_some_and(|names| names.iter().any(|required| required == name))
    };
    properties
        .iter()
        .map(|(name, schema)| {
            let line = doc_line(schema);
            let default = line.default.or_else(|| notation_of(&schema["default"]));
            Field {
                name: name.clone(),
                meaning: line.meaning,
                unit: line.unit,
                // A field without a default in words and data would be a gap that a test finds.
                default: if is_required(name) { None } else { Some(default.unwrap_or_default()) },
                value: value_kind(schema),
                since: since(&format!("{owner}.{name}")),
            }
        })
        .collect()
}

fn choice(page: &str, schema: &Value, root: &Value) -> Choice {
    let line = doc_line(schema);
    let (name, argument) = match schema["properties"].as_object().and_then(|one| one.iter().next()) {
        None => (schema["const"].as_str().unwrap_or_default(), Argument::None),
        Some((name, value)) => {
            let target = value["$ref"].as_str().and_then(definition).map(|name| &root["$defs"][name]);
            let inner = target.unwrap_or(value);
            let argument = if inner["properties"].is_object() {
                Argument::Fields(fields(&format!("{page}.{name}"), inner))
            } else {
                Argument::Value(value_kind(value))
            };
            (name.as_str(), argument)
        }
    };
    let since = since(&format!("{page}.{name}"));
    Choice { name: name.to_owned(), meaning: line.meaning, unit: line.unit, argument, since }
}

/// Name behind a reference such as `#/$defs/Outlet`.
fn definition(reference: &str) -> Option<&str> {
    reference.rsplit('/').next()
}

fn value_kind(schema: &Value) -> ValueKind {
    let plain = |text: &str| ValueKind { text: text.to_owned(), page: None, has_unit: false };
    let with_unit = |text: &str| ValueKind { has_unit: true, ..plain(text) };
    if let Some(name) = schema["$ref"].as_str().and_then(definition) {
        return ValueKind { page: Some(name.to_owned()), ..plain(&format!("`{name}`")) };
    }
    if let Some(first) = schema["anyOf"].as_array().and_then(|kinds| kinds.first()) {
        return value_kind(first);
    }
    if schema["x-expression"] == true {
        return with_unit("expression");
    }
    let kind = schema["type"].as_array().and_then(|kinds| kinds.first()).unwrap_or(&schema["type"]);
    match kind.as_str().unwrap_or_default() {
        "number" => with_unit("number"),
        "integer" => plain("whole number"),
        "boolean" => plain("`true` or `false`"),
        "string" => plain("text"),
        "array" if schema["prefixItems"].is_array() => with_unit("two numbers"),
        "array" => list_kind(&value_kind(&schema["items"])),
        _ => with_unit("map of names to numbers"),
    }
}

/// Returns the kind of a list: of numbers a vector.
fn list_kind(item: &ValueKind) -> ValueKind {
    let text = match item.text.as_str() {
        "number" => "vector".to_owned(),
        "expression" => "vector of expressions".to_owned(),
        "vector" => "list of vectors".to_owned(),
        "two numbers" => "list of pairs of numbers".to_owned(),
        other => format!("list of {other}"),
    };
    ValueKind { text, ..item.clone() }
}

/// Returns a default of the JSON Schema in the notation of scenes.
fn notation_of(value: &Value) -> Option<String> {
    match value {
        Value::Null => None,
        Value::String(name) => Some(format!("`{name}`")),
        Value::Object(choice) => choice.keys().next().map(|name| format!("`{name}()`")),
        other => Some(other.to_string()),
    }
}
