//! Citations in the source and docs/REFERENCES.md agree, both ways.

use std::collections::{BTreeMap, BTreeSet};

use crate::source_tree::{SOURCES, SourceFile, expect_none, read, root, sources};

const DOCUMENT: &str = "docs/REFERENCES.md";

/// Environment variable that lets the test update the lists of files.
const UPDATE: &str = "UPDATE_REFERENCES";

/// A cited work: the first author's name and the year.
type Key = (String, u16);

/// Comments of a file joined to running text, since a citation may be broken over two lines; with
/// the line of each word.
fn comment_words(source: &SourceFile) -> Vec<(usize, String)> {
    let mut words = Vec::new();
    for (number, line) in source.text.lines().enumerate() {
        let line = line.trim_start();
        if let Some(comment) = line.strip_prefix("//") {
            let comment = comment.trim_start_matches(['/', '!']);
            words.extend(comment.split_whitespace().map(|word| (number + 1, word.to_owned())));
        } else {
            // An end of comment is an end of sentence.
            words.push((number + 1, String::new()));
        }
    }
    words
}

/// `Author (year)`, `Author & Author (year)` and `Author et al. (year)` in comments, with their
/// lines.
fn citations(source: &SourceFile) -> Vec<(usize, Key)> {
    let words = comment_words(source);
    let mut found = Vec::new();
    for (at, (line, word)) in words.iter().enumerate() {
        let Some(year) = year_in_brackets(word) else { continue };
        if let Some(author) = first_author(&words[..at]) {
            found.push((*line, (author, year)));
        }
    }
    found
}

/// 2017 of `(2017)`, `(2017),` and `(2017,`.
fn year_in_brackets(word: &str) -> Option<u16> {
    let digits = word.trim_start_matches('*').strip_prefix('(')?.get(..4)?;
    let year = digits.parse().ok()?;
    (1700..2100).contains(&year).then_some(year)
}

/// The first author of the names that end a text: walks back over `et al.`, `&` and capitalised
/// names.
fn first_author(words: &[(usize, String)]) -> Option<String> {
    let is_name = |word: &str| {
        word.chars().next().is_some_and(char::is_uppercase) && !word.ends_with(['.', ')', ':', ';'])
    };
    let mut rest = words.iter().rev().map(|(_, word)| word.as_str()).peekable();
    if rest.next_if_eq(&"al.").is_some() {
        rest.next_if_eq(&"et")?;
        let name = rest.next().filter(|word| is_name(word))?;
        return Some(plain(name));
    }
    let mut author = rest.next().filter(|word| is_name(word))?;
    while rest.next_if(|word| *word == "&" || *word == "and").is_some() {
        author = rest.next().filter(|word| is_name(word))?;
        while let Some(earlier) =
            rest.next_if(|word| word.ends_with(',') && is_name(word.trim_end_matches(',')))
        {
            author = earlier;
        }
    }
    Some(plain(author))
}

fn plain(name: &str) -> String {
    name.trim_matches(|c: char| !c.is_alphanumeric()).trim_end_matches("’s").trim_end_matches("'s").to_owned()
}

/// An entry of the document.
struct Entry {
    line: usize,
    files: BTreeSet<String>,
    has_doi: bool,
}

/// Entries by key. An entry is a heading `## Author (year)`, the reference with its DOI, and
/// `Used in:` with files in backticks.
fn entries() -> BTreeMap<Key, Entry> {
    let mut entries = BTreeMap::new();
    let mut open: Option<Key> = None;
    let text = read(DOCUMENT);
    for (number, line) in text.lines().enumerate() {
        if let Some(heading) = line.strip_prefix("## ") {
            let words: Vec<(usize, String)> =
                heading.split_whitespace().map(|word| (0, word.to_owned())).collect();
            let key = words
                .split_last()
                .and_then(|((_, year), names)| Some((first_author(names)?, year_in_brackets(year)?)))
                .unwrap_or_else(|| {
                    panic!("{DOCUMENT}:{}: heading must be `## Author (year)`, is `{heading}`", number + 1)
                });
            let entry = Entry { line: number + 1, files: BTreeSet::new(), has_doi: false };
            assert!(
                entries.insert(key.clone(), entry).is_none(),
                "{DOCUMENT}:{}: `{heading}` stands twice",
                number + 1
            );
            open = Some(key);
        }
        let Some(entry) = open.as_ref().and_then(|key| entries.get_mut(key)) else { continue };
        entry.has_doi |= line.contains("https://doi.org/10.");
        if let Some(files) = line.strip_prefix("Used in: ") {
            entry.files.extend(files.split('`').skip(1).step_by(2).map(str::to_owned));
        }
    }
    entries
}

/// The line that an entry has for the files that cite it.
fn used_in<'a>(files: impl IntoIterator<Item = &'a String>) -> String {
    let list: Vec<String> = files.into_iter().map(|file| format!("`{file}`")).collect();
    format!("Used in: {}", list.join(", "))
}

/// Puts the files that cite each entry into the document.
fn update(cited: &BTreeMap<Key, BTreeMap<String, usize>>, entries: &BTreeMap<Key, Entry>) {
    let mut lines: Vec<String> = read(DOCUMENT).lines().map(str::to_owned).collect();
    for (key, entry) in entries {
        let used = lines.iter_mut().skip(entry.line).find(|line| line.starts_with("Used in:"));
        if let (Some(files), Some(used)) = (cited.get(key), used) {
            *used = used_in(files.keys());
        }
    }
    let text = lines.join("\n") + "\n";
    std::fs::write(root().join(DOCUMENT), text).expect("the document can be written");
}

#[test]
fn citations_and_references_agree_both_ways() {
    let mut cited: BTreeMap<Key, BTreeMap<String, usize>> = BTreeMap::new();
    for source in sources(&SOURCES) {
        for (line, key) in citations(&source) {
            cited.entry(key).or_default().entry(source.path.clone()).or_insert(line);
        }
    }
    let mut entries = self::entries();
    if std::env::var_os(UPDATE).is_some() {
        update(&cited, &entries);
        entries = self::entries();
    }
    let mut faults = Vec::new();
    for ((author, year), files) in &cited {
        let Some(entry) = entries.get(&(author.clone(), *year)) else {
            for (file, line) in files {
                faults.push(format!("{file}:{line}: cites {author} ({year}), which {DOCUMENT} does not have: add `## {author} … ({year})` with its DOI"));
            }
            continue;
        };
        let present: BTreeSet<String> = files.keys().cloned().collect();
        if present != entry.files {
            faults.push(format!(
                "{DOCUMENT}:{}: the files that cite {author} ({year}) have changed: write `{}`, or let `{UPDATE}=1 cargo test --test architecture` do it",
                entry.line,
                used_in(&present),
            ));
        }
    }
    for ((author, year), entry) in &entries {
        if !cited.contains_key(&(author.clone(), *year)) {
            faults.push(format!(
                "{DOCUMENT}:{}: nothing cites {author} ({year}): cite it where it is used, or delete it",
                entry.line
            ));
        }
        if !entry.has_doi {
            faults.push(format!(
                "{DOCUMENT}:{}: {author} ({year}) has no DOI: add `https://doi.org/…`",
                entry.line
            ));
        }
    }
    expect_none(&faults);
}

#[test]
fn citations_can_be_looked_up() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        let words = comment_words(&source);
        for (at, (line, word)) in words.iter().enumerate() {
            let next = words.get(at + 1).map_or("", |(_, word)| word.as_str());
            // A source's shorthand, as [A 29], is known to its author alone.
            let shorthand =
                matches!(word.as_str(), "[A" | "[N" | "[S") && next.starts_with(|c: char| c.is_ascii_digit());
            let bare = word == "al." && next.starts_with(|c: char| c.is_ascii_digit());
            if shorthand || bare {
                faults.push(format!(
                    "{}:{line}: `{word} {next}` cannot be looked up: write `Author (year), Eq. n`",
                    source.path
                ));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn scheme_reads_the_forms_in_use() {
    let source = |text: &str| SourceFile::new("", text);
    let cases = [
        (
            "//! Lo & Shao (2002), as in Alvarado-Rodríguez et al.\n//! (2017), Eq. 10.",
            vec![("Lo", 2002), ("Alvarado-Rodríguez", 2017)],
        ),
        ("/// Monaghan (1994): `p0`.", vec![("Monaghan", 1994)]),
        ("/// Negi, Ramachandran & Haftu (2020).", vec![("Negi", 2020)]),
        ("/// since the year (2020) and a list (2017 of them)", vec![]),
        ("let a = 1;\n/// (2017) alone", vec![]),
    ];
    for (text, expected) in cases {
        let found: Vec<(String, u16)> = citations(&source(text)).into_iter().map(|(_, key)| key).collect();
        let expected: Vec<(String, u16)> =
            expected.into_iter().map(|(name, year)| (name.to_owned(), year)).collect();
        assert_eq!(found, expected, "in {text:?}");
    }
}
