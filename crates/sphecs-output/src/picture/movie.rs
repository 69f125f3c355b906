//! All frames of a run as a movie with one colour scale.
//!
//! The ending of the file chooses the format: GIF, which every program shows, or MP4 with AV1,
//! which has all colours and is smaller. MP4 is the feature `mp4`, since its encoder takes a minute
//! of processor time to compile.

use std::path::Path;

use image::RgbImage;

use super::RenderOptions;
use super::all_frames::painter_of_all;
use super::gif_movie::GifMovie;
use super::sheet::ColourKey;
use crate::error::OutputError;
use crate::results::Results;

/// Encoder of pictures of one size.
pub(super) trait Movie {
    /// Adds a picture.
    fn add(&mut self, picture: &RgbImage) -> Result<(), String>;

    /// Returns the file.
    fn finish(self: Box<Self>) -> Result<Vec<u8>, String>;
}

/// Draws all frames into a file with `fps` frames per second, and returns the number of frames.
///
/// Calls `done` with the number of finished frames and the number of all.
///
/// # Errors
/// As [`render`](super::render).
pub fn render_movie(
    results: &Results,
    options: &RenderOptions,
    path: &Path,
    fps: f64,
    mut done: impl FnMut(usize, usize),
) -> Result<usize, OutputError> {
    let failed = |cause: String| OutputError::io(path, "write")(std::io::Error::other(cause));
    let mut painter = painter_of_all(results, options, || Ok(()))?;
    let size = [painter.sheet.width, painter.sheet.height];
    let mut movie = new_movie(path, size, &painter.key(), fps).map_err(failed)?;
    for index in 0..results.len() {
        movie.add(&painter.draw(&results.frame(index)?).pixels()).map_err(failed)?;
        done(index + 1, results.len());
    }
    crate::disk::write_whole(path, &movie.finish().map_err(failed)?)?;
    Ok(results.len())
}

#[cfg_attr(
    not(feature = "mp4"),
    expect(unused_variables, reason = "the path chooses among formats with `mp4` only")
)]
fn new_movie(path: &Path, size: [u32; 2], key: &ColourKey, fps: f64) -> Result<Box<dyn Movie>, String> {
    #[cfg(feature = "mp4")]
    if path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("mp4")) {
        return Ok(Box::new(super::mp4_movie::Mp4Movie::new(size, fps)?));
    }
    Ok(Box::new(GifMovie::new(size, key, fps)?))
}
