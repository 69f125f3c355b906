//! Page of the manual that lists every field of the scene file.

use std::fmt::Write;

use super::entries::{Argument, Choice, Content, Field, Manual, Page, ValueKind};
use super::examples::example;

const HEAD: &str = "\
# The scene file

<!-- Generated from the doc lines of the types of the scene file: change those, then run
     `UPDATE_REFERENCE=1 cargo test -p sphecs-scene --features schema`. -->

A scene is a file in [RON](https://github.com/ron-rs/ron). `sphecs explain PATH` prints a part of
this page, such as `sphecs explain outlets.condition`. `sphecs schema` prints the JSON Schema.

| type | notation |
|---|---|
| number | `1.0e-3`, or an [expression](expressions.md) of constants in quotes: `\"2*R\"` |
| whole number | `2`, or an expression of constants with a whole value |
| expression | a number, or an [expression](expressions.md) of constants, position and time in quotes |
| vector | as many numbers as the scene has dimensions: `(0.0, \"D/2\")` |
| vector of expressions | as many expressions as the scene has dimensions |
| text | in quotes: `\"gap\"` |
| list | in square brackets: `[…]` |
| struct, such as `Fluid` | fields in brackets: `(density: 1000.0, …)` |
| choice, such as `Shifting` | a name, with brackets if it has fields: `Off`, `Fickian()` |

All values are in SI units; `dimensionless` numbers have none. A default in words is computed. A
field of a choice with fields in brackets may be left out if it has a default: `WaveEquation()`.
`since` is the first version of sphecs that has a field or choice under its present name.
";

impl Manual {
    /// Returns the page of the scene file, in Markdown.
    pub fn scene_page(&self) -> String {
        let mut text = HEAD.to_owned();
        for page in &self.pages {
            section(&mut text, page);
        }
        text
    }
}

fn section(text: &mut String, page: &Page) {
    let _infallible = write!(text, "\n## {}\n\n{}\n\n", page.name, page.meaning);
    match &page.content {
        Content::Fields(fields) => field_table(text, fields),
        Content::Choices(choices) => choice_table(text, choices),
    }
    passage(text, example(&page.name));
    let Content::Choices(choices) = &page.content else { return };
    for choice in choices.iter().filter(|choice| !choice.fields().is_empty()) {
        let _infallible = write!(text, "\n### {}.{}\n\n", page.name, choice.name);
        field_table(text, choice.fields());
        passage(text, example(&format!("{}.{}", page.name, choice.name)));
    }
}

fn passage(text: &mut String, example: Option<&str>) {
    if let Some(example) = example {
        let _infallible = write!(text, "\n```ron\n{example}\n```\n");
    }
}

fn field_table(text: &mut String, fields: &[Field]) {
    text.push_str("| field | type | unit | default | since | meaning |\n|---|---|---|---|---|---|\n");
    for field in fields {
        let _infallible = writeln!(
            text,
            "| `{}` | {} | {} | {} | {} | {} |",
            field.name,
            link(&field.value),
            unit(field.unit.as_deref()),
            field.default.as_deref().map_or("**required**".to_owned(), cell),
            field.since,
            cell(&field.meaning),
        );
    }
}

fn choice_table(text: &mut String, choices: &[Choice]) {
    text.push_str("| choice | in brackets | unit | since | meaning |\n|---|---|---|---|---|\n");
    for choice in choices {
        let argument = match &choice.argument {
            Argument::None => "no brackets".to_owned(),
            Argument::Value(value) => link(value),
            Argument::Fields(_) => "fields, below".to_owned(),
        };
        let (name, since, meaning) = (&choice.name, choice.since, cell(&choice.meaning));
        let unit = unit(choice.unit.as_deref());
        let _infallible = writeln!(text, "| `{name}` | {argument} | {unit} | {since} | {meaning} |");
    }
}

fn unit(unit: Option<&str>) -> &str {
    unit.unwrap_or("none")
}

/// A vertical line would end the cell of a table, and `<` could begin a tag.
fn cell(text: &str) -> String {
    text.replace('|', "\\|").replace('<', "&lt;")
}

/// Returns the kind of a value with a link to its section.
fn link(value: &ValueKind) -> String {
    match &value.page {
        None => value.text.clone(),
        Some(page) => {
            value.text.replace(&format!("`{page}`"), &format!("[`{page}`](#{})", page.to_lowercase()))
        }
    }
}
