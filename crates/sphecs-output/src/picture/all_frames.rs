//! All frames of a run as numbered pictures with one colour scale.

use std::path::{Path, PathBuf};

use super::RenderOptions;
use super::painter::Painter;
use crate::error::OutputError;
use crate::results::Results;

/// Draws all frames into files `name-0000.png`, … beside `path`, with one colour scale.
///
/// Calls `done` with the number of finished pictures and the number of all.
///
/// # Errors
/// As [`render`](super::render); [`OutputError::Request`] when pictures of a longer series are
/// beside `path`, which would be taken for the end of this one.
pub fn render_all(
    results: &Results,
    options: &RenderOptions,
    path: &Path,
    mut done: impl FnMut(usize, usize),
) -> Result<Vec<PathBuf>, OutputError> {
    let mut painter = painter_of_all(results, options, || {
        let next = numbered(path, results.len());
        match next.exists() {
            false => Ok(()),
            true => Err(OutputError::Request(format!(
                "`{}`: is a picture of a longer series, this run has {} frames: remove that series, or give another \
                 name by `-o`",
                next.display(),
                results.len()
            ))),
        }
    })?;
    let mut paths = Vec::with_capacity(results.len());
    for index in 0..results.len() {
        let path = numbered(path, index);
        painter.draw(&results.frame(index)?).save(&path)?;
        paths.push(path);
        done(paths.len(), results.len());
    }
    Ok(paths)
}

/// Returns a painter with the scale of all frames, after a check that is made before they are read.
///
/// # Errors
/// As [`render_all`].
pub(super) fn painter_of_all<'a>(
    results: &'a Results,
    options: &'a RenderOptions,
    check: impl FnOnce() -> Result<(), OutputError>,
) -> Result<Painter<'a>, OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    let mut painter = Painter::new(&results.header, options)?;
    check()?;
    if painter.needs_all_frames() {
        for index in 0..results.len() {
            painter.include(&results.frame(index)?);
        }
    }
    Ok(painter)
}

/// Returns the path with the index added, as `flow-0007.png` for `flow.png`.
fn numbered(path: &Path, index: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or("png".as_ref()).to_string_lossy();
    path.with_file_name(format!("{stem}-{index:04}.{ending}"))
}
