//! The repository's files as text and as Rust tokens, for tests of its structure and language.

use std::fs;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use proc_macro2::{TokenStream, TokenTree};

/// Folders with Rust sources that the engine and its programs are built from.
pub(crate) const SOURCES: [&str; 2] = ["crates", "src"];

/// A token with the number of its line, from 1. Delimiters are tokens of their own.
#[derive(Clone, Debug)]
pub(crate) struct Token {
    /// Text of an identifier, a literal or a single punctuation character.
    pub text: String,
    /// Line, from 1.
    pub line: usize,
    /// Whether the token is an identifier or a keyword.
    pub is_word: bool,
}

/// A Rust file of the repository.
pub(crate) struct SourceFile {
    /// Path from the repository's root, with `/`.
    pub path: String,
    /// Text of the file.
    pub text: String,
    /// Tokens without comments.
    pub tokens: Vec<Token>,
}

impl SourceFile {
    /// Reads the tokens of a text.
    ///
    /// # Panics
    /// If the text is not Rust.
    pub(crate) fn new(path: &str, text: &str) -> Self {
        let stream = TokenStream::from_str(text).unwrap_or_else(|error| panic!("{path}: {error}"));
        let mut tokens = Vec::new();
        flatten(stream, &mut tokens);
        Self { path: path.to_owned(), text: text.to_owned(), tokens }
    }

    /// Returns the tokens before the first `#[cfg(test)]`: unit tests stand at the end of a file.
    pub(crate) fn tokens_without_tests(&self) -> &[Token] {
        let end = find(&self.tokens, &["#", "[", "cfg", "(", "test", ")", "]"]).next();
        &self.tokens[..end.unwrap_or(self.tokens.len())]
    }

    /// Returns the lines on which a sequence of tokens begins.
    pub(crate) fn lines_with<'a>(&'a self, pattern: &'a [&'a str]) -> impl Iterator<Item = usize> + 'a {
        find(&self.tokens, pattern).map(|at| self.tokens[at].line)
    }
}

/// Returns the indices at which a sequence of tokens begins.
pub(crate) fn find<'a>(tokens: &'a [Token], pattern: &'a [&'a str]) -> impl Iterator<Item = usize> + 'a {
    let fits = move |window: &[Token]| window.iter().zip(pattern).all(|(token, text)| token.text == *text);
    tokens.windows(pattern.len()).enumerate().filter(move |(_, window)| fits(window)).map(|(at, _)| at)
}

fn flatten(stream: TokenStream, tokens: &mut Vec<Token>) {
    for tree in stream {
        let line = tree.span().start().line;
        let mut push = |text: String, line, is_word| tokens.push(Token { text, line, is_word });
        match tree {
            TokenTree::Group(group) => {
                let (open, close) = match group.delimiter() {
                    proc_macro2::Delimiter::Parenthesis => ("(", ")"),
                    proc_macro2::Delimiter::Brace => ("{", "}"),
                    proc_macro2::Delimiter::Bracket => ("[", "]"),
                    proc_macro2::Delimiter::None => ("", ""),
                };
                push(open.to_owned(), line, false);
                flatten(group.stream(), tokens);
                let line = group.span_close().start().line;
                tokens.push(Token { text: close.to_owned(), line, is_word: false });
            }
            TokenTree::Ident(word) => push(word.to_string(), line, true),
            TokenTree::Punct(mark) => push(mark.as_char().to_string(), line, false),
            TokenTree::Literal(literal) => push(literal.to_string(), line, false),
        }
    }
}

/// Returns the root of the repository.
pub(crate) fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Returns a path from the root, with `/`.
pub(crate) fn relative(path: &Path) -> String {
    let path = path.strip_prefix(root()).unwrap_or(path);
    path.iter().map(|part| part.to_string_lossy()).collect::<Vec<_>>().join("/")
}

/// Reads a text file of the repository.
///
/// # Panics
/// If it cannot be read.
pub(crate) fn read(path: impl AsRef<Path>) -> String {
    let path = root().join(path);
    fs::read_to_string(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// Reads all Rust files under folders of the repository, sorted by path.
pub(crate) fn sources(folders: &[&str]) -> Vec<SourceFile> {
    let mut paths = Vec::new();
    for folder in folders {
        files_under(&root().join(folder), &["rs"], &mut paths);
    }
    paths.sort();
    paths.iter().map(|path| SourceFile::new(&relative(path), &read(path))).collect()
}

/// Collects the files with one of the extensions under a folder; none where the folder is missing.
pub(crate) fn files_under(folder: &Path, extensions: &[&str], found: &mut Vec<PathBuf>) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let path = entry.path();
        if path.is_dir() {
            files_under(&path, extensions, found);
        } else if path.extension().is_some_and(|found| extensions.iter().any(|extension| found == *extension))
        {
            found.push(path);
        }
    }
}

/// Fails with all faults at once.
///
/// # Panics
/// If there is a fault.
pub(crate) fn expect_none(faults: &[String]) {
    assert!(faults.is_empty(), "\n{}\n", faults.join("\n"));
}
