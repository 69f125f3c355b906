//! Field of a frame as a PNG picture with title, axes, walls and colour scale.
//!
//! - `field`: fields that can be drawn; a new one is a variant of [`Field`] and its arms
//! - `vorticity`: vorticity of the particles
//! - `view`: plane of a 2D flow or slice of a 3D flow
//! - `raster`: particles to pixels
//! - `scale`: ticks and colour maps
//! - `plan`: a scene before it runs
//! - `sheet`: title, axes and legend around the field
//! - `canvas`: pixels and text

mod canvas;
mod field;
mod plan;
mod raster;
mod scale;
mod sheet;
mod view;
mod vorticity;

use std::path::{Path, PathBuf};

pub use field::Field;
pub use plan::render_plan;
pub use scale::Colours;
pub use view::Slice;

use self::canvas::Canvas;
use self::sheet::{ColourKey, Sheet};
use self::view::View;
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::results::Results;
use sphecs_core::particles::zone::Zone;

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
    /// Slice of a 3D flow; None: normal to z in the middle. Must be None in 2D.
    pub slice: Option<Slice>,
}

impl Default for RenderOptions {
    fn default() -> Self {
        Self { field: Field::Speed, range: None, colours: None, width: 1600, slice: None }
    }
}

/// Draws the frame nearest to `time` (s; None: the last) into a PNG file and returns its time, s.
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
    painter.paint(&frame, path)?;
    Ok(frame.time)
}

/// Draws all frames into PNG files `name-0000.png`, … beside `path`, with one colour scale.
///
/// Calls `done` with the number of finished pictures and the number of all.
///
/// # Errors
/// As [`render`]; [`OutputError::Request`] when pictures of a longer series are beside `path`,
/// which would be taken for the end of this one.
pub fn render_all(
    results: &Results,
    options: &RenderOptions,
    path: &Path,
    mut done: impl FnMut(usize, usize),
) -> Result<Vec<PathBuf>, OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    let mut painter = Painter::new(&results.header, options)?;
    let next = numbered(path, results.len());
    if next.exists() {
        return Err(OutputError::Request(format!(
            "`{}`: is a picture of a longer series, this run has {} frames: remove that series, or give another name by \
             `-o`",
            next.display(),
            results.len()
        )));
    }
    if options.range.is_none() && options.field != Field::Zone {
        for index in 0..results.len() {
            painter.include(&results.frame(index)?);
        }
    }
    let mut paths = Vec::with_capacity(results.len());
    for index in 0..results.len() {
        let path = numbered(path, index);
        painter.paint(&results.frame(index)?, &path)?;
        paths.push(path);
        done(paths.len(), results.len());
    }
    Ok(paths)
}

/// Draws a single frame into a PNG file with a square around a slot; the picture shows the bounds
/// of the header.
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
    let mut canvas = painter.draw(frame);
    painter.mark(&mut canvas, frame, slot);
    canvas.save(path)
}

/// Returns the path with the index added, as `flow-0007.png` for `flow.png`.
fn numbered(path: &Path, index: usize) -> PathBuf {
    let stem = path.file_stem().unwrap_or_default().to_string_lossy();
    let ending = path.extension().unwrap_or("png".as_ref()).to_string_lossy();
    path.with_file_name(format!("{stem}-{index:04}.{ending}"))
}

/// Painter of the frames of one run with one colour scale.
struct Painter<'a> {
    options: &'a RenderOptions,
    title: &'a str,
    view: View,
    sheet: Sheet,
    found: Option<(f64, f64)>,
}

impl<'a> Painter<'a> {
    fn new(header: &'a Header, options: &'a RenderOptions) -> Result<Self, OutputError> {
        let view = View::new(header, options.slice)?;
        if options.field == Field::W && view.dimensions == 2 {
            return Err(OutputError::Request(
                "field `w`: the run is in 2D and has no velocity along z, draw `u` or `v`".to_owned(),
            ));
        }
        if let Some((low, high)) = options.range
            && !(low < high && low.is_finite() && high.is_finite())
        {
            return Err(OutputError::Request(format!(
                "range {low} to {high}: must be two finite numbers, the smaller first"
            )));
        }
        let sheet = Sheet::new(&view, options.width);
        Ok(Self { options, title: &header.title, view, sheet, found: None })
    }

    /// Extends the scale to the values of a frame.
    fn include(&mut self, frame: &Frame) {
        if self.options.range.is_some() {
            return;
        }
        let field = self.options.field;
        let drawn = |slot: &usize| {
            frame.zone[*slot] <= Zone::Outflow as u8
                && frame.zone[*slot] != Zone::Wall as u8
                && self.view.place(frame, *slot)[2].abs() < 1.75 * self.view.spacing
        };
        let values = field.values(frame, &self.view);
        let mut values: Vec<f32> = (0..frame.len())
            .filter(drawn)
            .map(|slot| values[slot])
            .filter(|value| value.is_finite())
            .collect();
        if values.is_empty() {
            return;
        }
        values.sort_by(f32::total_cmp);
        let cut = (field.cut() * values.len() as f64) as usize;
        let (low, high) = (f64::from(values[cut]), f64::from(values[values.len() - 1 - cut]));
        let (low_before, high_before) = self.found.unwrap_or((low, high));
        self.found = Some((low_before.min(low), high_before.max(high)));
    }

    fn key(&self) -> ColourKey {
        let field = self.options.field;
        if field == Field::Zone {
            return ColourKey::Zones;
        }
        let own = field.colours(self.view.dimensions);
        let (mut low, mut high) = self.found.unwrap_or((0.0, 1.0));
        if field == Field::Speed {
            low = 0.0;
        }
        if own == Colours::Diverging {
            high = high.abs().max(low.abs());
            low = -high;
        }
        // A uniform field has an empty range.
        if high - low <= 1e-6 * high.abs().max(low.abs()) {
            let margin = if high == 0.0 { 1.0 } else { 1e-3 * high.abs() };
            (low, high) = (low - margin, high + margin);
        }
        ColourKey::Scale {
            colours: self.options.colours.unwrap_or(own),
            range: self.options.range.unwrap_or((low, high)),
        }
    }

    fn paint(&self, frame: &Frame, path: &Path) -> Result<(), OutputError> {
        self.draw(frame).save(path)
    }

    /// Draws a square around a slot that has a position.
    fn mark(&self, canvas: &mut Canvas, frame: &Frame, slot: usize) {
        let [right, up, _] = self.view.place(frame, slot);
        if !(right.is_finite() && up.is_finite()) {
            return;
        }
        let pixels_per_metre = self.sheet.size[0] as f64 / self.view.extent()[0];
        let pixel = |metres: f64| (metres * pixels_per_metre).round() as i64;
        let half = pixel(0.9 * self.view.spacing).max(4);
        let [x, y] = self.sheet.corner;
        let corner = [x + pixel(right - self.view.low[0]) - half, y + pixel(self.view.high[1] - up) - half];
        canvas.outline(corner, [2 * half, 2 * half], (half / 6).max(2));
    }

    fn draw(&self, frame: &Frame) -> Canvas {
        let field = self.options.field;
        let key = self.key();
        let mut canvas = self.sheet.draw(&self.view, field, &key, self.title, frame.time);
        let values = field.values(frame, &self.view);
        let size = self.sheet.size.map(|length| length as usize);
        let pixels =
            raster::paint(frame, &self.view, &values, field.is_label(), size, |value| key.colour(value));
        for (index, colour) in pixels.into_iter().enumerate() {
            let [x, y] = self.sheet.corner;
            canvas.set(x + (index % size[0]) as i64, y + (index / size[0]) as i64, colour);
        }
        canvas
    }
}
