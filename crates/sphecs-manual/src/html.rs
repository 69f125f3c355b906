//! HTML in pages, and requests of built pages to the network.

use std::fs;
use std::path::Path;

use pulldown_cmark::Event;

use crate::ManualError;
use crate::fault::Fault;
use crate::markdown;
use crate::sources::Page;

/// Elements that a page may contain. A picture is written in Markdown, where its link is checked.
const ALLOWED: [&str; 8] = ["a", "br", "details", "div", "kbd", "sub", "summary", "sup"];

/// Adds a fault for every HTML element that a page may not contain.
pub fn check(page: &Page, faults: &mut Vec<Fault>) {
    for (event, range) in markdown::parser(&page.text).into_offset_iter() {
        let (Event::Html(html) | Event::InlineHtml(html)) = event else { continue };
        for name in elements(&html).filter(|name| !ALLOWED.contains(&name.as_str())) {
            let message = format!("`<{name}>` is an HTML element: quote it by backticks, or use Markdown");
            faults.push(Fault::at(&page.file, &page.text, range.start, message));
        }
    }
}

/// Returns the names of the elements that a piece of HTML opens.
fn elements(html: &str) -> impl Iterator<Item = String> {
    let tags = html.split('<').skip(1).filter(|tag| tag.starts_with(|c: char| c.is_ascii_alphabetic()));
    tags.map(|tag| {
        tag.split(|c: char| !c.is_ascii_alphanumeric() && c != '-').next().unwrap_or_default().to_lowercase()
    })
}

/// Adds a fault for every resource that a built page would load from the network.
///
/// # Errors
/// [`ManualError::Read`] for a file that cannot be read.
pub fn check_offline(built: &Path, faults: &mut Vec<Fault>) -> Result<(), ManualError> {
    let error = |source| ManualError::Read { path: built.to_owned(), source };
    for entry in fs::read_dir(built).map_err(error)? {
        let path = entry.map_err(error)?.path();
        if path.is_dir() {
            check_offline(&path, faults)?;
        } else if path.extension().is_some_and(|extension| extension == "html" || extension == "css") {
            let text = fs::read_to_string(&path)
                .map_err(|source| ManualError::Read { path: path.clone(), source })?;
            for offset in network_resources(&text) {
                let message = "loads a resource from the network: bundle it";
                faults.push(Fault::at(&path.display().to_string(), &text, offset, message));
            }
        }
    }
    Ok(())
}

/// Returns the places of `src`, `url` and of links of style sheets that name the network.
fn network_resources(text: &str) -> Vec<usize> {
    let mut found = Vec::new();
    for mark in ["src=\"http", "src=\"//", "url(http", "url('http", "url(\"http"] {
        // The first word of the style sheet for MathML is the name of a namespace, not a resource.
        let is_namespace = |at: usize| text[..at].trim_end().ends_with("@namespace m");
        found.extend(text.match_indices(mark).map(|(at, _)| at).filter(|&at| !is_namespace(at)));
    }
    for (at, _) in text.match_indices("<link ") {
        let tag = text[at..].split('>').next().unwrap_or_default();
        if tag.contains("href=\"http") || tag.contains("href=\"//") {
            found.push(at);
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn foreign_elements_are_faults() {
        let text = "Give <NAME> and H<sub>2</sub>O.\n\n<script src=\"a.js\"></script>\n\n`<img>`\n";
        let page = Page { file: "a.md".to_owned(), path: "a.md".to_owned(), text: text.to_owned() };
        let mut faults = Vec::new();
        check(&page, &mut faults);
        let places: Vec<_> = faults.iter().map(|fault| (fault.line, fault.column)).collect();
        assert_eq!(places, [(1, 6), (3, 1)]);
    }

    #[test]
    fn resources_of_the_network_are_found() {
        let text = "<a href=\"https://a.org\">a</a>\n<link rel=\"icon\" href=\"https://a.org/i.png\">\n\
                    <script src=\"https://a.org/a.js\"></script>\n";
        assert_eq!(network_resources(text), [text.find("src=").unwrap(), text.find("<link").unwrap()]);
    }
}
