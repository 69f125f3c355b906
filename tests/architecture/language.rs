//! Language of the repository: words that must not occur, heads of modules and doc lines, width of
//! lines.
//!
//! `words.txt` has a phrase a line and what to write instead. `docs/notebook/`, a laboratory diary,
//! is left as it was written.

use std::path::PathBuf;

use crate::source_tree::{SOURCES, expect_none, files_under, read, relative, root, sources};

/// Folders and files whose words are checked.
const TEXTS: [&str; 14] = [
    "crates",
    "src",
    "tests",
    "benches",
    "examples",
    "scenes",
    "assets/templates",
    "assets/validation",
    "scripts",
    "python",
    "docs",
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
];

const EXTENSIONS: [&str; 8] = ["rs", "md", "ron", "py", "sh", "toml", "snap", "txt"];

/// The list of phrases with this test, and the diary.
const EXEMPT: [&str; 2] = ["tests/architecture/", "docs/notebook/"];

/// Parts of lines that name a listed word for good reason: the message for a renamed option, the
/// environment variable, the function of expressions, the status in summaries of earlier versions.
const EXEMPT_LINES: [&str; 6] =
    ["Absorbing boundary conditions", "NonReflecting", "HOME", "ceil", "f64::floor", "\"blown up\""];

/// Characters of a line of comment.
const COMMENT_WIDTH: usize = 100;

/// First words of a head or doc line that name nothing.
const EMPTY_BEGINNINGS: [&str; 10] =
    ["What", "Which", "Whether", "Those", "How", "Where", "When", "Why", "The same", "That"];

/// A phrase that must not occur, with what to write instead.
struct Phrase {
    words: Vec<String>,
    instead: String,
}

/// Reads `words.txt`: `phrase | what to write instead`, comments behind `#`.
fn phrases() -> Vec<Phrase> {
    let text = read("tests/architecture/words.txt");
    let lines = text.lines().filter(|line| !line.trim().is_empty() && !line.starts_with('#'));
    lines
        .map(|line| {
            let (phrase, instead) = line.split_once('|').unwrap_or_else(|| panic!("no `|` in `{line}`"));
            Phrase { words: words(phrase), instead: instead.trim().to_owned() }
        })
        .collect()
}

/// Splits a line into lower-case words: `thrown_back`, `ThrownBack` and `thrown back` are the same
/// two.
fn words(line: &str) -> Vec<String> {
    let mut found: Vec<String> = Vec::new();
    let mut current = String::new();
    let mut previous = ' ';
    for c in line.chars() {
        if previous.is_lowercase() && c.is_uppercase() {
            found.push(std::mem::take(&mut current));
        }
        if c.is_alphabetic() {
            current.extend(c.to_lowercase());
        } else if !current.is_empty() {
            found.push(std::mem::take(&mut current));
        }
        // A call of a method of the standard library is not prose: `x.floor()`.
        if c == '(' && matches!(found.last().map(String::as_str), Some("floor")) {
            found.pop();
        }
        previous = c;
    }
    found.push(current);
    found.retain(|word| !word.is_empty());
    found
}

/// Returns the paths of all checked texts.
pub(crate) fn texts() -> Vec<String> {
    let mut paths: Vec<PathBuf> = Vec::new();
    for place in TEXTS {
        let path = root().join(place);
        if path.is_file() {
            paths.push(path);
        } else {
            files_under(&path, &EXTENSIONS, &mut paths);
        }
    }
    paths.sort();
    let all = paths.iter().map(|path| relative(path));
    all.filter(|path| !EXEMPT.iter().any(|exempt| path.starts_with(exempt))).collect()
}

#[test]
fn words_of_the_list_do_not_occur() {
    let phrases = phrases();
    let mut faults = Vec::new();
    for path in texts() {
        for (number, line) in read(&path).lines().enumerate() {
            if EXEMPT_LINES.iter().any(|part| line.contains(part)) {
                continue;
            }
            let found = words(line);
            for phrase in &phrases {
                if found.windows(phrase.words.len()).any(|window| window == phrase.words) {
                    faults.push(format!(
                        "{path}:{}: says `{}`: write {}",
                        number + 1,
                        phrase.words.join(" "),
                        phrase.instead
                    ));
                }
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn words_are_found_in_names_and_in_prose() {
    assert_eq!(
        words("let thrown_back = ThrownBack::new(\"thrown back\");").join(" "),
        "let thrown back thrown back new thrown back"
    );
    assert_eq!(words("x.floor() of 2D"), ["x", "of", "d"]);
}

/// The text of a comment line, without its marks.
fn comment(line: &str) -> Option<&str> {
    let text = line.trim_start().strip_prefix("//")?;
    Some(text.trim_start_matches(['/', '!']).trim())
}

#[test]
fn comments_are_at_most_100_columns_wide() {
    let mut faults = Vec::new();
    for source in sources(&["crates", "src", "tests", "benches", "examples"]) {
        for (number, line) in source.text.lines().enumerate() {
            // A table, a link or a formula cannot be broken.
            let breaks = |text: &str| !text.starts_with('|') && !text.contains("http") && text.contains(' ');
            if line.chars().count() > COMMENT_WIDTH && comment(line).is_some_and(breaks) {
                let width = line.chars().count();
                faults.push(format!("{}:{}: is a comment {width} columns wide", source.path, number + 1));
            }
        }
    }
    expect_none(&faults);
}

#[test]
fn heads_and_doc_lines_begin_with_a_noun_or_a_verb() {
    let mut faults = Vec::new();
    for source in sources(&SOURCES) {
        let mut was_doc = false;
        for (number, line) in source.text.lines().enumerate() {
            let line = line.trim_start();
            let doc = line.strip_prefix("///").or_else(|| line.strip_prefix("//!"));
            if let Some(text) = doc.filter(|_| !was_doc) {
                let text = text.trim_start();
                let begins = |word: &&&str| {
                    text.strip_prefix(**word).is_some_and(|rest| !rest.starts_with(char::is_alphanumeric))
                };
                if let Some(word) = EMPTY_BEGINNINGS.iter().find(begins) {
                    faults.push(format!(
                        "{}:{}: begins with `{word}`: begin with a noun or a verb",
                        source.path,
                        number + 1
                    ));
                }
            }
            was_doc = doc.is_some();
        }
    }
    expect_none(&faults);
}
