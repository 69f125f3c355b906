//! Front page and pages of the validation cases: the verdict first, then a plot and a short table.

use std::path::Path;

use crate::source_tree::{expect_none, files_under, read, relative, root};

const PAGES: &str = "docs/validation/";

/// Most figures in the summary of a page.
const SUMMARY: usize = 10;

/// Returns the name of a file without its folder and extension.
fn stem(path: &Path) -> String {
    path.file_stem().map_or(String::new(), |stem| stem.to_string_lossy().into_owned())
}

/// Returns the verdict at the end of the first sentence of a page, as in `**met** (…)`.
fn verdict(page: &str) -> Option<&str> {
    let sentence = page.lines().nth(2)?;
    sentence.find(": **").and_then(|at| sentence[at + 2..].strip_suffix('.'))
}

/// Returns the fault of a page that does not have the order of those that are generated.
fn fault_of_order(page: &str) -> Option<String> {
    let (begin, rest) = page.split_once("\n## Summary\n")?;
    let plot = begin.lines().nth(4).unwrap_or_default();
    let rows = rest.split("\n## ").next()?.lines().filter(|line| line.starts_with("| ")).skip(1).count();
    if !plot.starts_with("![") {
        Some("has no plot below its first sentence".to_owned())
    } else if rows > SUMMARY {
        Some(format!("has {rows} figures in its summary, must have at most {SUMMARY}"))
    } else {
        None
    }
}

#[test]
fn front_page_has_the_verdict_of_every_case() {
    let front = read(format!("{PAGES}README.md"));
    let mut faults = Vec::new();
    let mut cases = Vec::new();
    files_under(&root().join("assets/validation"), &["ron"], &mut cases);
    cases.sort();
    for case in cases {
        let name = stem(&case);
        let page = root().join(format!("{PAGES}{name}.md"));
        let has_page = page.is_file();
        let begin = if has_page { format!("| [`{name}`]({name}.md) |") } else { format!("| `{name}` |") };
        let Some(row) = front.lines().find(|line| line.starts_with(&begin)) else {
            faults.push(format!("{PAGES}README.md:1: has no row `{begin}`: add it"));
            continue;
        };
        if !has_page {
            continue;
        }
        let text = read(relative(&page));
        match verdict(&text) {
            Some(verdict) if row.contains(&format!("| {verdict} |")) => {}
            Some(verdict) => faults
                .push(format!("{PAGES}README.md:1: `{name}` has another verdict than its page, {verdict}")),
            None => faults.push(format!("{PAGES}{name}.md:3: has no verdict: generate the page")),
        }
        if !text.contains("\n## Summary\n") {
            faults.push(format!("{PAGES}{name}.md:1: has no summary: generate the page"));
        }
        faults.extend(fault_of_order(&text).map(|fault| format!("{PAGES}{name}.md:1: {fault}")));
    }
    expect_none(&faults);
}

#[test]
fn order_and_verdict_of_a_page_are_found() {
    let row = "| a | 1 |  |  |  | met |\n";
    let page = |plot: &str, rows: usize| {
        format!(
            "# A\n\nA: **met** (1 of 1).\n\n{plot}\n\n## Summary\n| f |\n|---|\n{}\n## Runs\n",
            row.repeat(rows)
        )
    };
    assert_eq!(verdict(&page("![p](p.svg)", 1)), Some("**met** (1 of 1)"));
    assert_eq!(fault_of_order(&page("![p](p.svg)", 10)), None);
    assert!(fault_of_order(&page("![p](p.svg)", 11)).is_some_and(|fault| fault.contains("11 figures")));
    assert!(fault_of_order(&page("Text.", 1)).is_some_and(|fault| fault.contains("no plot")));
}
