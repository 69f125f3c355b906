//! Anchors of a page: the ids that mdBook gives its headings.

use std::collections::BTreeSet;

use pulldown_cmark::{Event, Tag, TagEnd};

use crate::markdown;

/// Returns the anchors of a page. A heading with an equation has one that nobody can link to.
pub fn anchors(text: &str) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    // Text and equations of the heading, or of the term of a definition list, that is being read.
    let mut heading: Option<(String, bool)> = None;
    for event in markdown::parser(text) {
        match event {
            Event::Start(Tag::Heading { id: Some(id), .. }) => {
                found.insert(id.to_string());
            }
            Event::Start(Tag::Heading { id: None, .. } | Tag::DefinitionListTitle) => {
                heading = Some((String::new(), false));
            }
            Event::End(TagEnd::Heading(_) | TagEnd::DefinitionListTitle) => {
                if let Some((text, false)) = heading.take() {
                    insert_unique(&mut found, &identifier(&text));
                }
            }
            Event::Text(part) | Event::Code(part) => {
                if let Some((text, _)) = &mut heading {
                    text.push_str(&part);
                }
            }
            Event::SoftBreak => {
                if let Some((text, _)) = &mut heading {
                    text.push('\n');
                }
            }
            Event::InlineMath(_) | Event::DisplayMath(_) => {
                if let Some((_, has_equation)) = &mut heading {
                    *has_equation = true;
                }
            }
            Event::Html(html) | Event::InlineHtml(html) => found.extend(written_id(&html)),
            _ => {}
        }
    }
    found
}

/// Returns the id that mdBook makes of the text of a heading.
fn identifier(text: &str) -> String {
    let kept = text.trim().to_lowercase();
    let characters = kept.chars().filter_map(|c| match c {
        _ if c.is_alphanumeric() || c == '_' || c == '-' => Some(c),
        _ if c.is_whitespace() => Some('-'),
        _ => None,
    });
    characters.collect()
}

/// Inserts an id with a number behind it where an earlier heading has the same.
fn insert_unique(found: &mut BTreeSet<String>, id: &str) {
    if !found.insert(id.to_owned()) {
        let mut number = 1;
        while !found.insert(format!("{id}-{number}")) {
            number += 1;
        }
    }
}

/// Returns the id of an HTML tag such as `<a id="table">`.
fn written_id(html: &str) -> Option<String> {
    let (_, rest) = html.split_once(" id=\"")?;
    rest.split_once('"').map(|(id, _)| id.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headings_have_the_ids_of_mdbook() {
        let text = "# Why `c0` isn't *free*\n\n## Limits\n\n## Limits\n\n## Other {#chosen}\n\n<a id=\"table\"></a>\n";
        let found: Vec<String> = anchors(text).into_iter().collect();
        assert_eq!(found, ["chosen", "limits", "limits-1", "table", "why-c0-isnt-free"]);
    }
}
