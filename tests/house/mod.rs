//! The source tree as text: what the invariants are checked on.

mod references;

use std::fs;
use std::path::{Path, PathBuf};

/// A Rust file of the repository.
pub struct Source {
    /// Path from the repository's root, with `/`.
    pub path: String,
    /// The text as it stands.
    pub text: String,
    /// The text with comments and the insides of strings blanked, line for line.
    pub code: String,
}

/// Root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Path from the root, with `/`.
pub fn relative(path: &Path) -> String {
    let path = path.strip_prefix(root()).unwrap_or(path);
    path.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// A text file of the repository.
pub fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// All Rust files under folders of the repository, sorted by path.
pub fn sources(folders: &[&str]) -> Vec<Source> {
    let mut paths = Vec::new();
    for folder in folders {
        files_under(&root().join(folder), "rs", &mut paths);
    }
    paths.sort();
    paths.iter().map(|path| Source::new(&relative(path), &read(path))).collect()
}

/// Files with an extension under a folder; none where the folder is missing.
pub fn files_under(folder: &Path, extension: &str, found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_under(&path, extension, found);
        } else if path.extension().is_some_and(|found| found == extension) {
            found.push(path);
        }
    }
}

/// Number of the line, from 1, in which a byte stands.
pub fn line_of(text: &str, byte: usize) -> usize {
    text[..byte].matches('\n').count() + 1
}

impl Source {
    /// A file of this path and text.
    pub fn new(path: &str, text: &str) -> Self {
        Self { path: path.to_owned(), text: text.to_owned(), code: without_comments(text) }
    }

    /// The code before the unit tests, which stand at the end of a file.
    pub fn code_without_tests(&self) -> &str {
        let end = self.code.find("#[cfg(test)]").unwrap_or(self.code.len());
        &self.code[..end]
    }

    /// Every place of the code where a word stands that is not part of a longer one.
    pub fn words<'a>(&'a self, word: &'a str) -> impl Iterator<Item = usize> + 'a {
        let joined = |c: char| c.is_alphanumeric() || c == '_';
        self.code.match_indices(word).map(|(at, _)| at).filter(move |&at| {
            !self.code[..at].ends_with(joined) && !self.code[at + word.len()..].starts_with(joined)
        })
    }
}

/// Blanks comments and the insides of string and character literals; the lines stay.
pub fn without_comments(text: &str) -> String {
    let characters: Vec<char> = text.chars().collect();
    let mut code = String::with_capacity(text.len());
    let mut at = 0;
    let blank = |code: &mut String, c: char| code.push(if c == '\n' { '\n' } else { ' ' });
    while let Some(&c) = characters.get(at) {
        let next = characters.get(at + 1).copied();
        let end = match (c, next) {
            ('/', Some('/')) => end_of_line(&characters, at),
            ('/', Some('*')) => end_of_block(&characters, at),
            ('"', _) => end_of_string(&characters, at),
            ('r', Some('"' | '#')) if !code.ends_with(|c: char| c.is_alphanumeric() || c == '_') => {
                end_of_raw_string(&characters, at)
            }
            ('\'', _) => end_of_character(&characters, at),
            _ => at,
        };
        if end == at {
            code.push(c);
            at += 1;
        } else {
            for &c in &characters[at..end] {
                blank(&mut code, c);
            }
            at = end;
        }
    }
    code
}

fn end_of_line(characters: &[char], at: usize) -> usize {
    (at..characters.len()).find(|&k| characters[k] == '\n').unwrap_or(characters.len())
}

fn end_of_block(characters: &[char], start: usize) -> usize {
    let mut depth = 0;
    let mut at = start;
    while at + 1 < characters.len() {
        match (characters[at], characters[at + 1]) {
            ('/', '*') => {
                depth += 1;
                at += 2;
            }
            ('*', '/') => {
                depth -= 1;
                at += 2;
                if depth == 0 {
                    return at;
                }
            }
            _ => at += 1,
        }
    }
    characters.len()
}

fn end_of_string(characters: &[char], start: usize) -> usize {
    let mut at = start + 1;
    while at < characters.len() {
        match characters[at] {
            '\\' => at += 2,
            '"' => return at + 1,
            _ => at += 1,
        }
    }
    characters.len()
}

fn end_of_raw_string(characters: &[char], start: usize) -> usize {
    let hashes = characters[start + 1..].iter().take_while(|&&c| c == '#').count();
    if characters.get(start + 1 + hashes) != Some(&'"') {
        return start;
    }
    let closes = |at: usize| {
        characters[at] == '"'
            && characters[at + 1..].iter().take(hashes).filter(|&&c| c == '#').count() == hashes
    };
    (start + hashes + 2..characters.len())
        .find(|&at| closes(at))
        .map_or(characters.len(), |at| at + 1 + hashes)
}

/// The end of a character literal; `start` itself for a lifetime.
fn end_of_character(characters: &[char], start: usize) -> usize {
    match (characters.get(start + 1), characters.get(start + 2)) {
        (Some('\\'), _) => (start + 3..characters.len())
            .find(|&at| characters[at] == '\'')
            .map_or(characters.len(), |at| at + 1),
        (Some(_), Some('\'')) => start + 3,
        _ => start,
    }
}
