//! Links and pictures: whether they lead anywhere, and their form inside the book.
//!
//! A relative link is written as it works in the repository. One that leads out of the book's
//! folder, for example to a scene or a picture of the repository, is changed to the place to which
//! the builder copies the file. Links may also use the paths of the built book, for example
//! `../validation/pulse.md`.

use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::ops::Range;

use pulldown_cmark::{BrokenLink, Event, LinkType, Tag};

use crate::anchors::anchors;
use crate::fault::Fault;
use crate::markdown;
use crate::paths;
use crate::sources::{Page, Sources, book_path, included_file};

/// A link or picture of a page.
struct Link {
    /// Bytes of the whole link, or of the definition that it refers to.
    range: Range<usize>,
    destination: String,
    is_picture: bool,
}

/// A page whose links hold inside the book.
#[derive(Debug)]
pub struct LinkedPage {
    /// Text with changed links.
    pub text: String,
    /// Files that the page links to, as paths from the repository's root.
    pub files: BTreeSet<String>,
}

/// The anchors of all pages, by their paths in the book.
pub type Anchors = BTreeMap<String, BTreeSet<String>>;

/// Returns the anchors of all pages.
pub fn all_anchors(sources: &Sources) -> Anchors {
    sources.pages.iter().map(|page| (page.path.clone(), anchors(&page.text))).collect()
}

/// Checks the links of a page and changes those that are different in the book.
pub fn resolve(page: &Page, sources: &Sources, anchors: &Anchors, faults: &mut Vec<Fault>) -> LinkedPage {
    let mut resolved = LinkedPage { text: page.text.clone(), files: BTreeSet::new() };
    let mut changes = BTreeMap::new();
    for link in links(page, faults) {
        match target(page, &link, sources, anchors) {
            Ok(None) => {}
            Ok(Some((target, fragment))) => {
                if target.is_file {
                    resolved.files.insert(target.file);
                }
                let new = paths::relative(paths::folder(&page.path), &target.path) + fragment;
                if new != link.destination {
                    changes.insert(link.range.start, (link, new));
                }
            }
            Err(problem) => faults.push(Fault::at(&page.file, &page.text, link.range.start, problem)),
        }
    }
    // From the end of the page, so that the places before stay where they are.
    for (_, (link, new)) in changes.into_iter().rev() {
        let Some(at) = page.text[link.range.clone()].rfind(&link.destination) else {
            let problem =
                format!("the link `{}` has escaped characters: write them plainly", link.destination);
            faults.push(Fault::at(&page.file, &page.text, link.range.start, problem));
            continue;
        };
        let start = link.range.start + at;
        resolved.text.replace_range(start..start + link.destination.len(), &new);
    }
    resolved
}

/// Returns the links of a page, and adds faults for references without a definition.
fn links(page: &Page, faults: &mut Vec<Fault>) -> Vec<Link> {
    let broken = RefCell::new(Vec::new());
    let parser = markdown::parser_with_broken_links(&page.text, |link: BrokenLink| {
        // `[0, 1]` alone is an interval, not a link.
        if link.link_type == LinkType::Reference {
            broken.borrow_mut().push((link.span.start, link.reference.to_string()));
        }
        None
    });
    let definitions: BTreeMap<String, Range<usize>> = parser
        .reference_definitions()
        .iter()
        .map(|(label, definition)| (label.to_lowercase(), definition.span.clone()))
        .collect();
    let mut found = Vec::new();
    for (event, range) in parser.into_offset_iter() {
        let (link_type, destination, id, is_picture) = match event {
            Event::Start(Tag::Link { link_type, dest_url, id, .. }) => (link_type, dest_url, id, false),
            Event::Start(Tag::Image { link_type, dest_url, id, .. }) => (link_type, dest_url, id, true),
            _ => continue,
        };
        let range = match link_type {
            LinkType::Email => continue,
            LinkType::Reference | LinkType::Collapsed | LinkType::Shortcut => {
                definitions.get(&id.to_lowercase()).cloned().unwrap_or(range)
            }
            _ => range,
        };
        found.push(Link { range, destination: destination.to_string(), is_picture });
    }
    for (offset, label) in broken.into_inner() {
        let problem =
            format!("`[{label}]` is defined nowhere on the page: define it, or mark code by backticks");
        faults.push(Fault::at(&page.file, &page.text, offset, problem));
    }
    found
}

/// End of a link.
struct Target {
    /// Path in the book.
    path: String,
    /// Path from the repository's root.
    file: String,
    /// True for a file to be copied, false for a page.
    is_file: bool,
}

/// Returns the end of a link and its `#anchor`; None for a link to the network.
///
/// # Errors
/// The fault and its cure.
fn target<'a>(
    page: &Page,
    link: &'a Link,
    sources: &Sources,
    anchors: &Anchors,
) -> Result<Option<(Target, &'a str)>, String> {
    let destination = link.destination.as_str();
    if destination.contains("://") || destination.starts_with("mailto:") {
        let problem = format!("the picture `{destination}` is in the network: copy it into the repository");
        return if link.is_picture { Err(problem) } else { Ok(None) };
    }
    let (path, fragment) = destination.split_at(destination.find('#').unwrap_or(destination.len()));
    let found = if path.is_empty() { linked_page(&page.path, sources) } else { find(page, path, sources) };
    let Some(found) = found else {
        return Err(format!("`{path}` does not exist: correct the link"));
    };
    if found.is_file && !sources.root.join(&found.file).is_file() {
        return Err(format!("`{path}` is a folder: link to a file"));
    }
    if found.is_file && found.file.ends_with(".md") {
        return Err(format!("`{path}` is a page outside the book: link to a page of the book"));
    }
    let is_anchor = |id: &str| anchors.get(&found.path).is_some_and(|ids| ids.contains(id));
    match fragment.strip_prefix('#') {
        Some(id) if !found.is_file && !is_anchor(id) => {
            Err(format!("`{}` has no heading `#{id}`: correct the link", found.file))
        }
        _ => Ok(Some((found, fragment))),
    }
}

/// Finds a path relative to a page: in the repository, then in the book.
fn find(page: &Page, path: &str, sources: &Sources) -> Option<Target> {
    if let Some(file) = paths::join(paths::folder(&page.file), path)
        && sources.root.join(&file).exists()
    {
        let path = book_path(&file);
        return linked_page(&path, sources).or(Some(Target { path, file, is_file: true }));
    }
    let path = paths::join(paths::folder(&page.path), path)?;
    let copied = |file: String| Target { path: path.clone(), file, is_file: true };
    linked_page(&path, sources)
        .or_else(|| included_file(&path).filter(|file| sources.root.join(file).exists()).map(copied))
}

fn linked_page(path: &str, sources: &Sources) -> Option<Target> {
    let page = sources.page(path)?;
    Some(Target { path: path.to_owned(), file: page.file.clone(), is_file: false })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Writes files into a folder and resolves the links of one of them.
    fn resolve_in(files: &[(&str, &str)], file: &str) -> (LinkedPage, Vec<String>) {
        let folder = tempfile::tempdir().unwrap();
        for (path, text) in files {
            let path = folder.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let sources = Sources::read(folder.path()).unwrap();
        let mut faults = Vec::new();
        let page = sources.pages.iter().find(|page| page.file == file).unwrap();
        let page = resolve(page, &sources, &all_anchors(&sources), &mut faults);
        faults.sort();
        (page, faults.iter().map(Fault::to_string).collect())
    }

    const SUMMARY: (&str, &str) = ("docs/book/src/SUMMARY.md", "");
    const WALLS: (&str, &str) = ("docs/book/src/guides/walls.md", "# Walls\n\n## Free slip\n");

    #[test]
    fn links_to_pages_anchors_and_pictures_hold() {
        let text = "[a](guides/walls.md#free-slip) [b](#start)\n\n# Start\n\n![c](c.png) [d][d] https://a.org\n\n\
                    [d]: guides/walls.md\n";
        let files = [SUMMARY, WALLS, ("docs/book/src/index.md", text), ("docs/book/src/c.png", "")];
        let (page, faults) = resolve_in(&files, "docs/book/src/index.md");
        assert_eq!(faults, [""; 0]);
        assert_eq!(page.files, BTreeSet::from(["docs/book/src/c.png".to_owned()]));
    }

    #[test]
    fn broken_links_and_anchors_are_faults_with_their_places() {
        let text = "[a](guides/wall.md)\n[b](guides/walls.md#corner) and [c](#none)\n![d](d.png) [e][e]\n\
                    ![f](https://a.org/f.png) [g](guides)\n";
        let (_, faults) =
            resolve_in(&[SUMMARY, WALLS, ("docs/book/src/index.md", text)], "docs/book/src/index.md");
        assert_eq!(
            faults,
            [
                "docs/book/src/index.md:1:1: `guides/wall.md` does not exist: correct the link",
                "docs/book/src/index.md:2:1: `docs/book/src/guides/walls.md` has no heading `#corner`: correct the link",
                "docs/book/src/index.md:2:33: `docs/book/src/index.md` has no heading `#none`: correct the link",
                "docs/book/src/index.md:3:1: `d.png` does not exist: correct the link",
                "docs/book/src/index.md:3:13: `[e]` is defined nowhere on the page: define it, or mark code by \
                 backticks",
                "docs/book/src/index.md:4:1: the picture `https://a.org/f.png` is in the network: copy it into the \
                 repository",
                "docs/book/src/index.md:4:27: `guides` is a folder: link to a file",
            ]
        );
    }

    #[test]
    fn links_out_of_the_book_lead_to_copies() {
        let text = "[scene](../../../../scenes/a.ron) ![plot](../../../validation/p.svg) \
                    [case](../validation/p.md) [notes](../validation/index.md) ![plot](../validation/p.svg) \
                    [map](../../../../MAP.md)\n";
        let files = [
            SUMMARY,
            ("docs/book/src/guides/g.md", text),
            ("scenes/a.ron", ""),
            ("docs/validation/p.svg", ""),
            ("docs/validation/p.md", ""),
            ("docs/validation/README.md", ""),
            ("MAP.md", ""),
        ];
        let (page, faults) = resolve_in(&files, "docs/book/src/guides/g.md");
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(faults[0].contains("`../../../../MAP.md` is a page outside the book"), "{faults:?}");
        assert_eq!(
            page.text,
            "[scene](../files/scenes/a.ron) ![plot](../validation/p.svg) [case](../validation/p.md) \
             [notes](../validation/index.md) ![plot](../validation/p.svg) [map](../../../../MAP.md)\n"
        );
        assert_eq!(page.files.len(), 2);
    }

    #[test]
    fn included_pages_keep_links_of_the_repository() {
        let text = "[a](README.md) [b](../book/src/guides/walls.md#free-slip)\n\n[![p](p.svg)](p.svg)\n";
        let files = [
            SUMMARY,
            WALLS,
            ("docs/validation/p.md", text),
            ("docs/validation/README.md", ""),
            ("docs/validation/p.svg", ""),
        ];
        let (page, faults) = resolve_in(&files, "docs/validation/p.md");
        assert_eq!(faults, [""; 0]);
        assert_eq!(page.text, "[a](index.md) [b](../guides/walls.md#free-slip)\n\n[![p](p.svg)](p.svg)\n");
    }
}
