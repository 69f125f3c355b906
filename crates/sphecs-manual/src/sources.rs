//! Pages of the book and their places in the repository.
//!
//! Most pages are in `docs/book/src/`. Pages that exist for other reasons, such as those that
//! `sphecs validate` writes, become pages of the book under another path.

use std::fs;
use std::io;
use std::path::{Path, PathBuf};

use crate::ManualError;

/// Folder of the book's pages, from the repository's root.
pub const BOOK_SOURCE: &str = "docs/book/src/";

/// Folders whose pages and pictures become part of the book, and their folders in it.
const INCLUDED_FOLDERS: [(&str, &str); 2] =
    [("docs/validation/", "validation/"), ("docs/notebook/", "notebook/")];

/// Pages that become part of the book, and their paths in it.
const INCLUDED_PAGES: [(&str, &str); 2] =
    [("docs/REFERENCES.md", "reference/references.md"), ("CHANGELOG.md", "reference/changelog.md")];

/// Folder of the book for files of the repository that pages link to, such as scenes.
const FILES: &str = "files/";

/// A page of the book.
#[derive(Clone, Debug)]
pub struct Page {
    /// Path from the repository's root, with `/`.
    pub file: String,
    /// Path in the book, with `/`.
    pub path: String,
    /// Markdown text.
    pub text: String,
}

/// All pages of the book, with its table of contents.
#[derive(Debug)]
pub struct Sources {
    /// Root of the repository.
    pub root: PathBuf,
    /// Text of `SUMMARY.md`.
    pub summary: String,
    /// Pages, sorted by their paths in the book.
    pub pages: Vec<Page>,
}

impl Sources {
    /// Reads the pages of a repository.
    ///
    /// # Errors
    /// [`ManualError::Read`] for a file or folder that cannot be read.
    pub fn read(root: &Path) -> Result<Self, ManualError> {
        let mut files = Vec::new();
        for folder in [BOOK_SOURCE].into_iter().chain(INCLUDED_FOLDERS.map(|(folder, _)| folder)) {
            if root.join(folder).is_dir() {
                files_under(root, folder.trim_end_matches('/'), &mut files)?;
            }
        }
        let included = INCLUDED_PAGES.into_iter().map(|(file, _)| file.to_owned());
        files.extend(included.filter(|file| root.join(file).is_file()));

        let summary_file = format!("{BOOK_SOURCE}SUMMARY.md");
        let summary = read(root, &summary_file)?;
        let mut pages = Vec::new();
        for file in files.into_iter().filter(|file| file.ends_with(".md") && *file != summary_file) {
            let text = read(root, &file)?;
            pages.push(Page { path: book_path(&file), file, text });
        }
        pages.sort_by(|a, b| (&a.path, &a.file).cmp(&(&b.path, &b.file)));
        Ok(Self { root: root.to_owned(), summary, pages })
    }

    /// Returns the page with a path in the book.
    pub fn page(&self, path: &str) -> Option<&Page> {
        self.pages.iter().find(|page| page.path == path)
    }

    /// Returns all files of the book's source folder that are not pages, such as pictures.
    ///
    /// # Errors
    /// [`ManualError::Read`] for a folder that cannot be read.
    pub fn other_files(&self) -> Result<Vec<String>, ManualError> {
        let mut files = Vec::new();
        files_under(&self.root, BOOK_SOURCE.trim_end_matches('/'), &mut files)?;
        files.retain(|file| !file.ends_with(".md"));
        Ok(files)
    }
}

/// Returns the path in the book of a file of the repository.
pub fn book_path(file: &str) -> String {
    if let Some(path) = file.strip_prefix(BOOK_SOURCE) {
        return path.to_owned();
    }
    if let Some((_, path)) = INCLUDED_PAGES.iter().find(|(included, _)| *included == file) {
        return (*path).to_owned();
    }
    for (folder, book_folder) in INCLUDED_FOLDERS {
        if let Some(name) = file.strip_prefix(folder) {
            // The first page of a folder is its index.
            return format!("{book_folder}{}", if name == "README.md" { "index.md" } else { name });
        }
    }
    format!("{FILES}{file}")
}

/// Returns the file of the repository that is a picture or other file of an included folder at a
/// path in the book.
pub fn included_file(path: &str) -> Option<String> {
    let mut folders = INCLUDED_FOLDERS.iter();
    folders.find_map(|(folder, book)| path.strip_prefix(book).map(|name| format!("{folder}{name}")))
}

/// Collects the files under a folder, as paths from the root.
fn files_under(root: &Path, folder: &str, found: &mut Vec<String>) -> Result<(), ManualError> {
    let error = |source| ManualError::Read { path: root.join(folder), source };
    for entry in fs::read_dir(root.join(folder)).map_err(error)? {
        let entry = entry.map_err(error)?;
        let name = entry.file_name();
        let name = name.to_str().ok_or_else(|| error(io::Error::other("a file name is not UTF-8")))?;
        let path = format!("{folder}/{name}");
        if entry.file_type().map_err(error)?.is_dir() {
            files_under(root, &path, found)?;
        } else {
            found.push(path);
        }
    }
    Ok(())
}

fn read(root: &Path, file: &str) -> Result<String, ManualError> {
    let path = root.join(file);
    fs::read_to_string(&path).map_err(|source| ManualError::Read { path, source })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_file_has_a_place_in_the_book() {
        assert_eq!(book_path("docs/book/src/guides/walls.md"), "guides/walls.md");
        assert_eq!(book_path("docs/validation/README.md"), "validation/index.md");
        assert_eq!(book_path("docs/validation/pulse_pressure.svg"), "validation/pulse_pressure.svg");
        assert_eq!(book_path("CHANGELOG.md"), "reference/changelog.md");
        assert_eq!(book_path("scenes/quickstart.ron"), "files/scenes/quickstart.ron");
        let file = included_file("validation/pulse_pressure.svg");
        assert_eq!(file.as_deref(), Some("docs/validation/pulse_pressure.svg"));
    }
}
