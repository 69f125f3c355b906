//! Files that a page includes by `{{#include path}}`, for example scenes.
//!
//! mdBook replaces the directive. Its path is relative to the page in the repository, while mdBook
//! reads a copy of the page elsewhere: the path is made absolute here.

use crate::fault::Fault;
use crate::paths;
use crate::sources::{Page, Sources};

const DIRECTIVES: [&str; 3] = ["{{#include ", "{{#rustdoc_include ", "{{#playground "];

/// Returns a text of a page with absolute paths in its directives, and adds faults for those that
/// lead nowhere. The text may differ from that of the page by changed links.
pub fn resolve(text: &str, page: &Page, sources: &Sources, faults: &mut Vec<Fault>) -> String {
    let mut resolved = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find("{{#") {
        let (before, directive) = rest.split_at(at);
        resolved.push_str(before);
        let begin = DIRECTIVES.iter().find(|begin| directive.starts_with(**begin));
        let is_escaped = before.ends_with('\\');
        let length = begin.filter(|_| !is_escaped).map_or("{{#".len(), |begin| begin.len());
        resolved.push_str(&directive[..length]);
        rest = &directive[length..];
        if length == "{{#".len() {
            continue;
        }
        // Behind the path there may be lines or an anchor: `scenes/a.ron:3:9`.
        let end = rest.find([':', '}', ' ']).unwrap_or(rest.len());
        let (path, behind) = rest.split_at(end);
        match paths::join(paths::folder(&page.file), path) {
            Some(file) if sources.root.join(&file).is_file() => {
                resolved.push_str(&sources.root.join(&file).to_string_lossy());
            }
            _ => {
                let offset = page.text.find(&format!("{}{path}", &directive[..length])).unwrap_or(0);
                let message = format!("includes `{path}`, which does not exist: correct the path");
                faults.push(Fault::at(&page.file, &page.text, offset, message));
                resolved.push_str(path);
            }
        }
        rest = behind;
    }
    resolved.push_str(rest);
    resolved
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_become_absolute() {
        let folder = tempfile::tempdir().unwrap();
        std::fs::write(folder.path().join("a.ron"), "").unwrap();
        let text = "{{#include ../a.ron:2:3}} \\{{#include b}}\n{{#include c.ron}}\n";
        let page = Page { file: "docs/p.md".to_owned(), path: "p.md".to_owned(), text: text.to_owned() };
        let sources = Sources { root: folder.path().to_owned(), summary: String::new(), pages: Vec::new() };
        let mut faults = Vec::new();
        let resolved = resolve(text, &page, &sources, &mut faults);
        let path = folder.path().join("a.ron");
        assert!(
            resolved.starts_with(&format!("{{{{#include {}:2:3}}}} \\{{{{#include b}}}}\n", path.display()))
        );
        assert_eq!(faults.len(), 1);
        assert_eq!(
            faults[0].to_string(),
            "docs/p.md:2:1: includes `c.ron`, which does not exist: correct the path"
        );
    }
}
