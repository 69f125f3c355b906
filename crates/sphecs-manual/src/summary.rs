//! Table of contents: agreement of `SUMMARY.md` with the pages that exist.

use std::collections::BTreeSet;
use std::ops::Range;

use pulldown_cmark::{Event, Tag};

use crate::fault::Fault;
use crate::markdown;
use crate::sources::{BOOK_SOURCE, Sources};

/// A chapter in the table of contents.
struct Entry {
    /// Path of the page in the book.
    path: String,
    /// Bytes of the link.
    range: Range<usize>,
}

fn entries(summary: &str) -> Vec<Entry> {
    let found = markdown::parser(summary).into_offset_iter().filter_map(|(event, range)| match event {
        Event::Start(Tag::Link { dest_url, .. }) => Some(Entry { path: dest_url.to_string(), range }),
        _ => None,
    });
    found.collect()
}

/// Adds faults for missing and repeated chapters, and for pages without one or with one path.
pub fn check(sources: &Sources, faults: &mut Vec<Fault>) {
    let file = format!("{BOOK_SOURCE}SUMMARY.md");
    let mut listed = BTreeSet::new();
    for entry in entries(&sources.summary) {
        let mut fault = |message| faults.push(Fault::at(&file, &sources.summary, entry.range.start, message));
        if sources.page(&entry.path).is_none() {
            fault(format!("the page `{}` does not exist: write it, or remove the line", entry.path));
        }
        if !listed.insert(entry.path.clone()) {
            fault(format!("the page `{}` is listed twice: remove a line", entry.path));
        }
    }
    for page in &sources.pages {
        if !listed.contains(&page.path) {
            let message = format!("is not in the table of contents: add `{}` to {file}", page.path);
            faults.push(Fault::at(&page.file, &page.text, 0, message));
        }
    }
    for pair in sources.pages.windows(2) {
        if pair[0].path == pair[1].path {
            let message =
                format!("has the path `{}` in the book, as {}: remove one", pair[1].path, pair[0].file);
            faults.push(Fault::at(&pair[1].file, &pair[1].text, 0, message));
        }
    }
}

/// Returns the table of contents with drafts, which have no link, in place of missing pages.
pub fn without_missing(sources: &Sources) -> String {
    let mut summary = sources.summary.clone();
    for entry in entries(&sources.summary).into_iter().rev() {
        if sources.page(&entry.path).is_none() {
            let link = summary[entry.range.clone()].replace(&format!("]({})", entry.path), "]()");
            summary.replace_range(entry.range, &link);
        }
    }
    summary
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sources::Page;

    fn sources(summary: &str, files: &[&str]) -> Sources {
        let page = |file: &&str| Page {
            file: format!("{BOOK_SOURCE}{file}"),
            path: (*file).to_owned(),
            text: "# Title\n".to_owned(),
        };
        Sources { root: "/".into(), summary: summary.to_owned(), pages: files.iter().map(page).collect() }
    }

    #[test]
    fn missing_repeated_and_orphan_pages_are_faults() {
        let summary = "# Summary\n\n- [A](a.md)\n- [B](b.md)\n- [A](a.md)\n";
        let mut faults = Vec::new();
        check(&sources(summary, &["a.md", "c.md"]), &mut faults);
        let places: Vec<String> = faults.iter().map(Fault::to_string).collect();
        assert_eq!(
            places,
            [
                "docs/book/src/SUMMARY.md:4:3: the page `b.md` does not exist: write it, or remove the line",
                "docs/book/src/SUMMARY.md:5:3: the page `a.md` is listed twice: remove a line",
                "docs/book/src/c.md:1:1: is not in the table of contents: add `c.md` to docs/book/src/SUMMARY.md",
            ]
        );
    }

    #[test]
    fn missing_pages_become_drafts() {
        let sources = sources("- [A](a.md)\n- [B](b.md)\n", &["a.md"]);
        assert_eq!(without_missing(&sources), "- [A](a.md)\n- [B]()\n");
    }
}
