//! Fields of a run as pictures and movies, with title, axes, walls and colour scale.
//!
//! - `field`: fields that can be drawn; a new one is a variant of [`Field`] and its arms
//! - `vorticity`: vorticity of the particles
//! - `view`: plane of a 2D flow or slice of a 3D flow
//! - `raster`: particles to pixels
//! - `plane_grid`: fields between the particles, and their time means
//! - `arrows`, `streamlines`, `contours`: lines over the field, drawn by `overlay`
//! - `painter`: a frame, or a mean, with one colour scale for all
//! - `perspective`: particles of a 3D flow in space
//! - [`all_frames`], [`movie`]: all frames of a run; `gif_movie`, `mp4_movie`: formats of movies
//! - [`map`]: a field as a few bare pixels
//! - `plan`: a scene before it runs
//! - `sheet`: title, axes and legend around the field

pub mod all_frames;
mod arrows;
mod contours;
mod field;
mod gif_movie;
pub mod map;
pub mod movie;
#[cfg(feature = "mp4")]
mod mp4_movie;
mod overlay;
mod painter;
mod perspective;
mod plan;
mod plane_grid;
mod raster;
mod sheet;
mod streamlines;
mod view;
mod vorticity;

use std::path::Path;

pub use crate::drawing::colours::Colours;
pub use field::Field;
pub use plan::render_plan;
pub use view::Slice;

use self::painter::Painter;
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::results::Results;

/// Options of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct RenderOptions {
    /// Field to draw.
    pub field: Field,
    /// Values at the ends of the colour scale, in the field's unit; None: from the frames drawn.
    pub range: Option<(f64, f64)>,
    /// Colour map; None: the default of the field.
    pub colours: Option<Colours>,
    /// Width of the picture, pixels.
    pub width: u32,
    /// Slice of a 3D flow; None: normal to z in the middle. Must be None in 2D. In perspective the
    /// flow in front of it is left out, and None leaves out nothing.
    pub slice: Option<Slice>,
    /// Edges of the part that is drawn, left, right, below and above, m; None: all of the flow.
    pub part: Option<[f64; 4]>,
    /// Number of velocity arrows across the picture; None: no arrows.
    pub arrows: Option<u32>,
    /// Number of streamlines across the picture at their distance; None: no streamlines.
    pub streamlines: Option<u32>,
    /// Largest number of levels at which lines of equal value are drawn; None: no lines.
    pub contours: Option<u32>,
    /// Direction from the flow towards the viewer in a picture of all particles of a 3D flow; None:
    /// a plane.
    pub perspective: Option<[f64; 3]>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self {
            field: Field::Speed,
            range: None,
            colours: None,
            width: 1600,
            slice: None,
            part: None,
            arrows: None,
            streamlines: None,
            contours: None,
            perspective: None,
        }
    }
}

/// Draws the frame nearest to `time` (s; None: the last) into a file and returns its time, s.
///
/// # Errors
/// [`OutputError`] when the run has no frames, none near the time, the options do not match it, or
/// a file cannot be read or written.
pub fn render(
    results: &Results,
    time: Option<f64>,
    options: &RenderOptions,
    path: &Path,
) -> Result<f64, OutputError> {
    let index = match time {
        Some(time) => results.nearest(time)?,
        None => results.len().checked_sub(1).ok_or_else(|| results.no_frames())?,
    };
    let frame = results.frame(index)?;
    let mut painter = Painter::new(&results.header, options)?;
    painter.include(&frame);
    painter.draw(&frame).save(path)?;
    Ok(frame.time)
}

/// Draws the time mean of the frames in an interval, s, into a file and returns the part of the
/// interval that they cover.
///
/// # Errors
/// As [`render`]; also when this version cannot read the scene of the run.
pub fn render_mean(
    results: &Results,
    interval: (f64, f64),
    options: &RenderOptions,
    path: &Path,
) -> Result<(f64, f64), OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    let mut painter = Painter::new(&results.header, options)?;
    let (drawing, covered) = painter.draw_mean(results, interval)?;
    drawing.save(path)?;
    Ok(covered)
}

/// Draws a single frame into a file with a square around a slot; the picture shows the bounds of
/// the header.
///
/// # Errors
/// [`OutputError`] when the options do not match the header or the file cannot be written.
pub(super) fn render_marked(
    header: &Header,
    frame: &Frame,
    slot: usize,
    options: &RenderOptions,
    path: &Path,
) -> Result<(), OutputError> {
    let mut painter = Painter::new(header, options)?;
    painter.include(frame);
    let mut drawing = painter.draw(frame);
    painter.mark(&mut drawing, frame, slot);
    drawing.save(path)
}
