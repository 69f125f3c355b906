//! Pictures of the runs of a case: frames of the particles as `sphecs render` draws them.

use std::path::Path;

use super::schema::{AxisFile, PictureFile};
use sphecs_core::format::significant;
use sphecs_output::error::OutputError;
use sphecs_output::picture::{RenderOptions, Slice, render};
use sphecs_output::results::Results;
use sphecs_scene::schema::Number;

/// Default width of a picture, pixels: half a page at some tens of kilobytes.
const WIDTH: u32 = 900;

/// Draws the pictures of a run folder into `target`, one for each time.
///
/// Returns the name of each file, and its title with the time of the frame or the error.
pub(crate) fn draw(
    file: &PictureFile,
    run: &Path,
    target: &Path,
    stem: &str,
) -> Vec<(String, Result<String, OutputError>)> {
    let results = Results::open(run);
    let picture = |(index, time): (usize, f64)| {
        let name = format!("{stem}_{}.png", index + 1);
        let drawn = match (&results, options(file)) {
            (Ok(results), Ok(options)) => render(results, Some(time), &options, &target.join(&name))
                .map(|time| format!("{}, t = {} s", file.title, significant(time))),
            (Err(error), _) => Err(OutputError::Request(error.to_string())),
            (_, Err(reason)) => Err(OutputError::Request(reason)),
        };
        (name, drawn)
    };
    file.times.iter().map(|time| time.value).enumerate().map(picture).collect()
}

/// Returns the options of the pictures.
///
/// # Errors
/// The field is unknown.
pub(crate) fn options(file: &PictureFile) -> Result<RenderOptions, String> {
    let slice = |(axis, at): &(AxisFile, Number)| Slice { axis: *axis as usize, at: Some(at.value) };
    Ok(RenderOptions {
        field: file.field.value.parse()?,
        range: file.range.map(|(low, high)| (low.value, high.value)),
        width: file.width.map_or(WIDTH, |width| width.value),
        slice: file.slice.as_ref().map(slice),
        ..RenderOptions::default()
    })
}
