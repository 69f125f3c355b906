//! Paths and links that texts of the repository name lead somewhere.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use crate::language::texts;
use crate::source_tree::{expect_none, files_under, read, relative, root};

#[test]
fn map_is_short_and_names_paths_that_exist() {
    let lines = read("ARCHITECTURE.md").lines().count();
    let mut faults = Vec::new();
    if lines > 150 {
        faults.push(format!("ARCHITECTURE.md:150: has {lines} lines, must have at most 150"));
    }
    for document in ["ARCHITECTURE.md", "README.md", "CONTRIBUTING.md", "docs/REFERENCES.md"] {
        for (number, line) in read(document).lines().enumerate() {
            for name in line.split('`').skip(1).step_by(2).filter(|name| is_path(name)) {
                let name = name.trim_start_matches("./").trim_end_matches('/');
                if !root().join(name).exists() {
                    faults.push(format!(
                        "{document}:{}: names `{name}`, which does not exist: correct the path or add the file",
                        number + 1
                    ));
                }
            }
        }
    }
    expect_none(&faults);
}

/// Folders of the repository: a quoted word of a document that begins with one is meant as a path.
const FOLDERS: [&str; 11] = [
    "crates/",
    "src/",
    "tests/",
    "scenes/",
    "docs/",
    "assets/",
    "benches/",
    "scripts/",
    "examples/",
    "python/",
    ".ci/",
];

fn is_path(name: &str) -> bool {
    let is_plain = name.chars().all(|c| c.is_alphanumeric() || "/._-".contains(c));
    is_plain && FOLDERS.iter().any(|folder| name.trim_start_matches("./").starts_with(folder))
}

/// Characters of a path in a text.
fn is_path_character(c: char) -> bool {
    c.is_ascii_alphanumeric() || "/._-".contains(c)
}

#[test]
fn pages_named_in_any_text_exist() {
    let mut faults = Vec::new();
    // The builder of the manual is tested with pages of its own.
    for path in texts().into_iter().filter(|path| !path.starts_with("crates/sphecs-manual/")) {
        for (number, line) in read(&path).lines().enumerate() {
            for (at, _) in line.match_indices("docs/") {
                let is_inside_a_path = line[..at].ends_with(is_path_character);
                let length = line[at..].find(|c| !is_path_character(c)).unwrap_or(line.len() - at);
                let name = line[at..at + length].trim_end_matches('.');
                if !is_inside_a_path && !root().join(name).exists() {
                    faults.push(format!("{path}:{}: names `{name}`, which does not exist", number + 1));
                }
            }
        }
    }
    expect_none(&faults);
}

/// Returns the anchors of the headings of a Markdown page, as GitHub makes them.
fn anchors(text: &str) -> BTreeSet<String> {
    let headings = text.lines().filter(|line| line.starts_with('#')).map(|line| line.trim_start_matches('#'));
    let anchor = |heading: &str| {
        let kept = heading.trim().chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.flat_map(char::to_lowercase).map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(anchor).collect()
}

/// Returns the targets of the links of a Markdown page within the repository, with their lines.
fn links(text: &str) -> Vec<(usize, &str)> {
    let mut found = Vec::new();
    for (number, line) in text.lines().enumerate() {
        for part in line.split("](").skip(1) {
            let target = part.split(')').next().unwrap_or("");
            if !target.is_empty() && !target.contains(':') && !target.contains(' ') {
                found.push((number + 1, target));
            }
        }
    }
    found
}

#[test]
fn links_between_pages_lead_to_files_and_headings() {
    let mut pages: Vec<PathBuf> = Vec::new();
    for folder in ["docs", "assets", "scenes", "scripts", "python", "examples", "crates"] {
        files_under(&root().join(folder), &["md"], &mut pages);
    }
    let names = ["README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"];
    pages.extend(names.map(|name| root().join(name)).into_iter().filter(|page| page.exists()));
    let mut faults = Vec::new();
    // The build of the manual generates some of its pages and checks its links.
    for page in pages.iter().filter(|page| !relative(page).starts_with("docs/book/")) {
        let text = read(page);
        let folder = page.parent().unwrap_or(Path::new(""));
        for (line, target) in links(&text) {
            let (name, anchor) = target.split_once('#').unwrap_or((target, ""));
            let file = if name.is_empty() { page.clone() } else { folder.join(name) };
            let has_anchor = || anchors(&read(&file)).contains(anchor);
            if !file.exists() {
                faults.push(format!("{}:{line}: links to `{name}`, which does not exist", relative(page)));
            } else if !anchor.is_empty() && !has_anchor() {
                faults.push(format!(
                    "{}:{line}: links to `{target}`, which has no such heading",
                    relative(page)
                ));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn headings_and_links_are_read_as_github_does() {
    let text = "## The conditions of Negi et al.\nsee [a](b.md#c), [d](https://e.f) and [g](#h)";
    assert_eq!(anchors(text).into_iter().collect::<Vec<_>>(), ["the-conditions-of-negi-et-al"]);
    assert_eq!(links(text), [(2, "b.md#c"), (2, "#h")]);
}
