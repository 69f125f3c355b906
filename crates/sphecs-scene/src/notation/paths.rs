//! Option `--set path=value`: replaces a value in the text of a scene and keeps its comments.
//!
//! A path names fields, entries of maps and, from 0, items of lists: `fluid.sound_speed`,
//! `constants.v0`, `outlets.0.condition`. If the text lacks the last name of a path, it is inserted
//! as a new field or constant, and so is a field of the scene that has it, such as `walls.slip`.
//! The typed reader then checks that the schema has it.

use super::reader;
use super::tree::{Node, Span, Value};
use crate::faults::{Fault, nearest};

/// Text of a scene with inserted values.
#[derive(Clone, Debug)]
pub struct Edited {
    /// The text as run.
    pub text: String,
    /// Spans of the inserted values, new fields with their names, and their paths.
    inserted: Vec<(Span, String)>,
}

/// Inserts values into the text of a scene, one after the other.
///
/// # Errors
/// All unknown paths and unreadable values.
pub fn apply(text: &str, sets: &[(String, String)]) -> Result<Edited, Vec<Fault>> {
    let mut edited = Edited { text: text.to_owned(), inserted: Vec::new() };
    let mut faults = Vec::new();
    for (path, value) in sets {
        let written = reader::read(value);
        if !written.faults.is_empty() {
            let name = format!("--set {path}");
            faults.extend(written.faults.into_iter().map(|f| f.in_text(&name, value)));
            continue;
        }
        let reading = reader::read(&edited.text);
        let root = reading.root;
        if !reading.faults.is_empty() {
            // The reader reports the faults of the text itself afterwards.
            return if faults.is_empty() { Ok(edited) } else { Err(faults) };
        }
        match find(&root, path) {
            Some(Target::Value(span)) => edited.replace(span, path, value),
            Some(Target::New { at, before, after }) => edited.insert(at, [&before, value, &after], path),
            None => faults.push(unknown_path(&root, path)),
        }
    }
    if faults.is_empty() { Ok(edited) } else { Err(faults) }
}

impl Edited {
    /// Returns the path of the inserted value at a span, if there is one.
    pub fn path_of(&self, place: Span) -> Option<&str> {
        let around = |span: &Span| span.start <= place.start && place.end <= span.end;
        // A later value may lie within an earlier one.
        self.inserted.iter().rev().find(|(span, _)| around(span)).map(|(_, path)| path.as_str())
    }

    fn replace(&mut self, span: Span, path: &str, value: &str) {
        self.text.replace_range(span.start..span.end, value);
        let removed = span.end - span.start;
        // Earlier values inside the replaced span no longer exist.
        self.inserted.retain(|(place, _)| place.start < span.start || place.end > span.end);
        for (place, _) in &mut self.inserted {
            if place.start >= span.end {
                place.start = place.start + value.len() - removed;
            }
            if place.end >= span.end {
                place.end = place.end + value.len() - removed;
            }
        }
        self.inserted.push((Span::new(span.start, span.start + value.len()), path.to_owned()));
    }

    fn insert(&mut self, at: usize, [before, value, after]: [&str; 3], path: &str) {
        let text = [before, value, after].concat();
        self.text.insert_str(at, &text);
        for (place, _) in &mut self.inserted {
            if place.start >= at {
                place.start += text.len();
            }
            if place.end > at {
                place.end += text.len();
            }
        }
        self.inserted.push((Span::new(at, at + before.len() + value.len()), path.to_owned()));
    }
}

enum Target {
    Value(Span),
    /// Place of a new value, and the text around it.
    New {
        at: usize,
        before: String,
        after: String,
    },
}

/// Fields of a scene that a path may add with a value inside, and the text before that value.
const ADDED: [(&str, &str); 9] = [
    ("walls", "("),
    ("initial", "("),
    ("reservoir", "("),
    ("reference", "("),
    ("output", "("),
    ("time", "("),
    ("fluid", "("),
    ("scheme", "Wcsph("),
    ("fill", "Lattice("),
];

fn find(root: &Node, path: &str) -> Option<Target> {
    let segments: Vec<&str> = path.split('.').collect();
    let mut node = root;
    for (index, segment) in segments.iter().enumerate() {
        match child(node, segment) {
            Some(next) => node = next,
            None => return new_value(node, index == 0, &segments[index..]),
        }
    }
    Some(Target::Value(node.span))
}

/// Returns the place of a value that a node does not have yet.
fn new_value(node: &Node, is_root: bool, missing: &[&str]) -> Option<Target> {
    let is_name = |name: &str| {
        name.starts_with(|c: char| c.is_alphabetic() || c == '_')
            && name.chars().all(|c| c.is_alphanumeric() || c == '_')
    };
    if !missing.iter().all(|name| is_name(name)) {
        return None;
    }
    let field = |before: String, after: &str| {
        let at = new_field_position(node)?;
        Some(Target::New { at, before, after: after.to_owned() })
    };
    match (missing, &node.value) {
        ([name], Value::Map(entries)) => {
            let at = entries.first().map_or(node.span.end - 1, |(key, _)| key.span.start);
            Some(Target::New { at, before: format!("\"{name}\": "), after: ", ".to_owned() })
        }
        // `WaveEquation` becomes `WaveEquation(target: …)`.
        ([name], Value::Name(_)) => {
            Some(Target::New { at: node.span.end, before: format!("({name}: "), after: ")".to_owned() })
        }
        ([name], _) => field(format!("{name}: "), ", "),
        (["constants", name], _) if is_root => field(format!("constants: {{\"{name}\": "), "}, "),
        ([name, inner], _) if is_root => {
            let (_, open) = ADDED.iter().find(|(known, _)| known == name)?;
            field(format!("{name}: {open}{inner}: "), "), ")
        }
        _ => None,
    }
}

fn child<'a>(node: &'a Node, segment: &str) -> Option<&'a Node> {
    let index = || segment.parse::<usize>().ok();
    match &node.value {
        Value::Struct(..) => node.field(segment),
        Value::Map(entries) => entries
            .iter()
            .find(
                |(key, _)| matches!(&key.value, Value::Text(text, _) | Value::Name(text) if text == segment),
            )
            .map(|(_, value)| value),
        Value::List(items) => items.get(index()?),
        // In `Circular((radius: …))` a path skips the inner bracket.
        Value::Tuple(Some(_), items) if items.len() == 1 => {
            child(&items[0], segment).or_else(|| items.get(index()?))
        }
        Value::Tuple(_, items) => items.get(index()?),
        _ => None,
    }
}

/// Returns the position of a new field: behind the opening bracket of a struct.
fn new_field_position(node: &Node) -> Option<usize> {
    match &node.value {
        Value::Struct(_, fields) => fields.first().map(|field| field.name.span.start),
        Value::Tuple(_, items) if items.is_empty() => Some(node.span.end - 1),
        _ => None,
    }
}

fn unknown_path(root: &Node, path: &str) -> Fault {
    let mut paths = Vec::new();
    collect(root, "", &mut paths);
    let fault = Fault::placeless(format!("--set {path}: the scene has no such path"));
    match nearest(path, paths.iter().map(String::as_str)) {
        Some(near) => fault.help(format!("did you mean `{near}`?")),
        None => fault.help("name fields and, from 0, items of lists: `fluid.sound_speed`, `outlets.0.depth`"),
    }
}

fn collect(node: &Node, path: &str, paths: &mut Vec<String>) {
    let join = |name: &str| match path {
        "" => name.to_owned(),
        _ => format!("{path}.{name}"),
    };
    if !path.is_empty() {
        paths.push(path.to_owned());
    }
    match &node.value {
        Value::Struct(_, fields) => {
            for field in fields {
                collect(&field.value, &join(&field.name.text), paths);
            }
        }
        Value::Map(entries) => {
            for (key, value) in entries {
                if let Value::Text(text, _) | Value::Name(text) = &key.value {
                    collect(value, &join(text), paths);
                }
            }
        }
        Value::List(items) | Value::Tuple(_, items) => {
            for (index, item) in items.iter().enumerate() {
                collect(item, &join(&index.to_string()), paths);
            }
        }
        _ => {}
    }
}
