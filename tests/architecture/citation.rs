//! Version of the citation file.

use crate::source_tree::read;

/// Returns the text behind the first line beginning with `key`, without quotes.
fn value_of(text: &str, key: &str) -> String {
    let line = text.lines().find_map(|line| line.strip_prefix(key));
    line.unwrap_or_default().trim().trim_matches('"').to_owned()
}

#[test]
fn citation_names_the_version_of_the_package() {
    let package = value_of(&read("Cargo.toml"), "version =");
    let citation = value_of(&read("CITATION.cff"), "version:");
    assert!(!package.is_empty());
    assert_eq!(citation, package, "CITATION.cff and Cargo.toml: make `version` the same in both");
    let credits = read("docs/book/src/credits.md");
    assert!(
        credits.contains(&format!("sphecs, version {package}:"))
            && credits.contains(&format!("{{{package}}}")),
        "docs/book/src/credits.md: cites another version than {package}: change both places"
    );
}
