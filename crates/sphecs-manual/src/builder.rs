//! Build of the book: a copy of its sources as mdBook wants them, and a run of mdBook.

use std::collections::BTreeSet;
use std::fs;
use std::path::Path;

use mdbook_driver::MDBook;
use mdbook_driver::config::Config;
use mdbook_preprocessor::book::Book;
use mdbook_preprocessor::errors::Error;
use mdbook_preprocessor::{Preprocessor, PreprocessorContext};

use crate::fault::Fault;
use crate::sources::{Sources, book_path};
use crate::{ManualError, equations, html, includes, links, readability, summary};

/// Folder of the book, from the repository's root.
const BOOK: &str = "docs/book";

/// Replaces equations by MathML.
struct Equations;

impl Preprocessor for Equations {
    fn name(&self) -> &str {
        "equations"
    }

    fn run(&self, _: &PreprocessorContext, mut book: Book) -> Result<Book, Error> {
        book.for_each_chapter_mut(|chapter| chapter.content = equations::render(&chapter.content));
        Ok(book)
    }
}

/// Builds the book of a repository into a folder and returns all faults of its pages, sorted.
///
/// The book is built with faults, too: missing pages have no link, broken equations stay LaTeX.
///
/// # Errors
/// [`ManualError`] if a file cannot be read or written, or if mdBook fails.
pub fn build(root: &Path, built: &Path) -> Result<Vec<Fault>, ManualError> {
    let sources = Sources::read(root)?;
    let mut faults = Vec::new();
    summary::check(&sources, &mut faults);

    let copy = tempfile::tempdir()
        .map_err(|source| ManualError::Write { path: "a temporary folder".into(), source })?;
    let anchors = links::all_anchors(&sources);
    let mut files: BTreeSet<String> = sources.other_files()?.into_iter().collect();
    write(&copy.path().join("src/SUMMARY.md"), &summary::without_missing(&sources))?;
    for page in &sources.pages {
        equations::check(page, &mut faults);
        html::check(page, &mut faults);
        readability::check(page, &mut faults);
        let linked = links::resolve(page, &sources, &anchors, &mut faults);
        files.extend(linked.files);
        let text = includes::resolve(&linked.text, page, &sources, &mut faults);
        write(&copy.path().join("src").join(&page.path), &text)?;
    }
    for file in files {
        copy_file(&root.join(&file), &copy.path().join("src").join(book_path(&file)))?;
    }
    copy_theme(root, copy.path())?;
    run_mdbook(&root.join(BOOK).join("book.toml"), copy.path(), built)?;
    html::check_offline(built, &mut faults)?;
    faults.sort();
    faults.dedup();
    Ok(faults)
}

/// Runs mdBook on a copy of the book's sources.
fn run_mdbook(config: &Path, copy: &Path, built: &Path) -> Result<(), ManualError> {
    let error = |error: Error| ManualError::Mdbook(format!("{error:#}"));
    let mut config = Config::from_disk(config).map_err(error)?;
    config.build.build_dir = built.to_owned();
    let mut book = MDBook::load_with_config(copy, config).map_err(error)?;
    book.with_preprocessor(Equations);
    book.build().map_err(error)
}

/// Copies the style sheets that `book.toml` names.
fn copy_theme(root: &Path, copy: &Path) -> Result<(), ManualError> {
    let theme = root.join(BOOK).join("theme");
    if !theme.is_dir() {
        return Ok(());
    }
    let error = |source| ManualError::Read { path: theme.clone(), source };
    for entry in fs::read_dir(&theme).map_err(error)? {
        let entry = entry.map_err(error)?;
        copy_file(&entry.path(), &copy.join("theme").join(entry.file_name()))?;
    }
    Ok(())
}

fn write(path: &Path, text: &str) -> Result<(), ManualError> {
    make_folder_of(path)?;
    fs::write(path, text).map_err(|source| ManualError::Write { path: path.to_owned(), source })
}

fn copy_file(from: &Path, to: &Path) -> Result<(), ManualError> {
    make_folder_of(to)?;
    let copied = fs::copy(from, to).map_err(|source| ManualError::Read { path: from.to_owned(), source })?;
    let _bytes: u64 = copied;
    Ok(())
}

fn make_folder_of(path: &Path) -> Result<(), ManualError> {
    let Some(folder) = path.parent() else { return Ok(()) };
    fs::create_dir_all(folder).map_err(|source| ManualError::Write { path: folder.to_owned(), source })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A repository with a book of two pages, one of them generated elsewhere.
    fn repository(index: &str) -> tempfile::TempDir {
        let folder = tempfile::tempdir().unwrap();
        let summary = "[Start](index.md)\n\n- [Pulse](validation/pulse.md)\n- [Later](later.md)\n";
        for (path, text) in [
            ("docs/book/book.toml", "[book]\ntitle = \"Test\"\n"),
            ("docs/book/src/SUMMARY.md", summary),
            ("docs/book/src/index.md", index),
            ("docs/validation/pulse.md", "# Pulse: *R*\n\n![plot](plot.svg)\n"),
            ("docs/validation/plot.svg", "<svg/>"),
            ("scenes/a.ron", "Scene(spacing: 0.1)\n"),
        ] {
            write(&folder.path().join(path), text).unwrap();
        }
        folder
    }

    #[test]
    fn book_has_equations_pictures_search_and_copies_of_linked_files() {
        let index = "# Start\n\nDensity $\\rho$, [pulse](validation/pulse.md#pulse-r).\n\n\
                     ```ron\n{{#include ../../../scenes/a.ron}}\n```\n\n[scene](../../../scenes/a.ron)\n";
        let folder = repository(index);
        let built = folder.path().join("target/book");
        let faults = build(folder.path(), &built).unwrap();
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert!(faults[0].message.contains("`later.md` does not exist"), "{faults:?}");

        let start = fs::read_to_string(built.join("index.html")).unwrap();
        assert!(start.contains("<math display=\"inline\"><mi>ρ</mi></math>"), "{start}");
        assert!(start.contains("href=\"validation/pulse.html#pulse-r\""), "{start}");
        assert!(start.contains("href=\"files/scenes/a.ron\""), "{start}");
        assert!(start.contains("Scene(spacing: 0.1)"), "{start}");
        let pulse = fs::read_to_string(built.join("validation/pulse.html")).unwrap();
        assert!(pulse.contains("id=\"pulse-r\""), "{pulse}");
        assert!(built.join("validation/plot.svg").is_file());
        assert!(built.join("files/scenes/a.ron").is_file());
        let has_index = |name: &str| name.starts_with("searchindex");
        assert!(
            fs::read_dir(&built).unwrap().any(|file| has_index(file.unwrap().file_name().to_str().unwrap()))
        );
    }

    #[test]
    fn all_faults_are_found_in_one_run() {
        let folder = repository(
            "# Start\n\n$\\right)$ and $\\nonsense$\n\n[a](none.md) <b>\n\n{{#include none.ron}}\n",
        );
        let faults = build(folder.path(), &folder.path().join("target/book")).unwrap();
        let places: Vec<_> =
            faults.iter().map(|fault| (fault.file.as_str(), fault.line, fault.column)).collect();
        let index = "docs/book/src/index.md";
        assert_eq!(
            places,
            [
                ("docs/book/src/SUMMARY.md", 4, 3),
                (index, 3, 1),
                (index, 3, 15),
                (index, 5, 1),
                (index, 5, 14),
                (index, 7, 1)
            ]
        );
    }
}
