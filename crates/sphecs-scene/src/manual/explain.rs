//! Text of an entry for a terminal.

use std::fmt::Write;

use super::entries::{Argument, Choice, Content, Field, Manual, Page, ValueKind};
use super::examples::example;
use super::lookup::{Entry, Item, UnknownPath};

/// Characters of a line.
const WIDTH: usize = 100;

/// Most entries of a path that are explained in full; more are listed.
const MOST_IN_FULL: usize = 3;

impl Manual {
    /// Returns the text of a path: meaning, type, unit, default, allowed values and an example.
    ///
    /// # Errors
    /// [`UnknownPath`], with the nearest name.
    pub fn explain(&self, path: &str) -> Result<String, UnknownPath> {
        let entries = self.find(path)?;
        if entries.len() > MOST_IN_FULL {
            let mut text = format!("{path}: occurs {} times\n\n", entries.len());
            for entry in &entries {
                item(&mut text, &entry.path, "", meaning(entry));
            }
            return Ok(text);
        }
        let texts: Vec<String> = entries.iter().map(|entry| self.explain_entry(entry)).collect();
        Ok(texts.join("\n"))
    }

    /// Returns the text of an entry.
    pub fn explain_entry(&self, entry: &Entry<'_>) -> String {
        let mut text = String::new();
        let heading = if entry.path.is_empty() { entry.item.name() } else { &entry.path };
        push_wrapped(&mut text, &format!("{heading}: {}", meaning(entry)), 0);
        match entry.item {
            Item::Page(_) => {}
            Item::Field(field) => {
                push_facts(&mut text, &field.value, field.unit.as_deref());
                let default = field.default.as_deref().unwrap_or("none, the field is required");
                push_fact(&mut text, "default", default);
                push_fact(&mut text, "since", field.since);
            }
            Item::Choice(choice) => {
                push_fact(&mut text, "choice of", &entry.owner.name);
                push_fact(&mut text, "since", choice.since);
                if let Argument::Value(value) = &choice.argument {
                    push_facts(&mut text, value, choice.unit.as_deref());
                }
                push_fields(&mut text, choice.fields());
            }
        }
        if let Some(page) = self.target(entry) {
            push_content(&mut text, page);
        }
        if let Some(passage) = self.example_of(entry) {
            text.push_str("\nexample\n");
            passage.lines().for_each(|line| {
                let _infallible = writeln!(text, "  {line}");
            });
        }
        text
    }

    /// Returns a passage of a scene with the entry, or with what contains it.
    fn example_of(&self, entry: &Entry<'_>) -> Option<&'static str> {
        let of_choice = || example(&format!("{}.{}", entry.owner.name, entry.item.name()));
        let of_value = || self.target(entry).and_then(|page| example(&page.name));
        let of_parent = || {
            let (parent, _) = entry.path.rsplit_once('.')?;
            let choice = parent.rsplit('.').next()?;
            example(&format!("{}.{choice}", entry.owner.name))
        };
        of_choice().or_else(of_value).or_else(of_parent).or_else(|| example(&entry.owner.name))
    }
}

fn meaning<'a>(entry: &Entry<'a>) -> &'a str {
    match entry.item {
        Item::Page(page) => &page.meaning,
        Item::Field(field) => &field.meaning,
        Item::Choice(choice) => &choice.meaning,
    }
}

fn push_content(text: &mut String, page: &Page) {
    match &page.content {
        Content::Fields(fields) => push_fields(text, fields),
        Content::Choices(choices) => push_choices(text, choices),
    }
}

fn push_facts(text: &mut String, value: &ValueKind, unit: Option<&str>) {
    push_fact(text, "type", &value.text);
    push_fact(text, "unit", unit.unwrap_or("none"));
}

fn push_fact(text: &mut String, name: &str, fact: &str) {
    push_wrapped(text, &format!("  {name:<10}{}", fact.replace('`', "")), 12);
}

fn push_fields(text: &mut String, fields: &[Field]) {
    if fields.is_empty() {
        return;
    }
    text.push_str("\nfields\n");
    for field in fields {
        let facts = [
            Some(field.value.text.replace('`', "")),
            field.unit.clone(),
            Some(match &field.default {
                Some(default) => format!("default {default}"),
                None => "required".to_owned(),
            }),
        ];
        let facts = facts.into_iter().flatten().collect::<Vec<_>>().join(", ");
        item(text, &field.name, &facts, &field.meaning);
    }
}

fn push_choices(text: &mut String, choices: &[Choice]) {
    text.push_str("\nchoices\n");
    for choice in choices {
        item(text, &choice.notation(), choice.unit.as_deref().unwrap_or_default(), &choice.meaning);
    }
}

/// Adds a name with its facts, and its meaning below.
fn item(text: &mut String, name: &str, facts: &str, meaning: &str) {
    let gap = if facts.is_empty() { "" } else { "  " };
    push_wrapped(text, &format!("  {name}{gap}{facts}"), 6);
    push_wrapped(text, &format!("      {meaning}"), 6);
}

/// Adds a paragraph in lines of at most [`WIDTH`] characters, of which all but the first are
/// indented.
fn push_wrapped(text: &mut String, paragraph: &str, indent: usize) {
    let own = paragraph.len() - paragraph.trim_start().len();
    let mut line = " ".repeat(own);
    let mut is_first_word = true;
    for word in paragraph[own..].split(' ') {
        if !is_first_word && line.chars().count() + 1 + word.chars().count() > WIDTH {
            let _infallible = writeln!(text, "{}", line.trim_end());
            line = " ".repeat(indent);
            is_first_word = true;
        }
        if !is_first_word {
            line.push(' ');
        }
        line.push_str(word);
        is_first_word = false;
    }
    let _infallible = writeln!(text, "{}", line.trim_end());
}
