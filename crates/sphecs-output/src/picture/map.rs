//! A field of the last frame as a few bare pixels, for a terminal.

use super::painter::Painter;
use super::sheet::ColourKey;
use super::{Field, RenderOptions};
use crate::drawing::Colour;
use crate::error::OutputError;
use crate::results::Results;

/// Field of a frame without axes and text.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldMap {
    /// The field.
    pub field: Field,
    /// Number of frames that the run had.
    pub frames: usize,
    /// Time of the frame, s.
    pub time: f64,
    /// Width and height, pixels.
    pub size: [usize; 2],
    /// Colours, row by row from the top.
    pub pixels: Vec<Colour>,
    /// Values at the ends of the colour scale, in the unit of the field; None for the zones.
    pub range: Option<(f64, f64)>,
}

/// Draws the last frame of a run, as large as fits into `most` pixels.
///
/// # Errors
/// [`OutputError`] when the run has no frames or a file cannot be read.
pub fn last_map(results: &Results, field: Field, most: [usize; 2]) -> Result<FieldMap, OutputError> {
    let frames = results.len();
    let last = frames.checked_sub(1).ok_or_else(|| results.no_frames())?;
    let frame = results.frame(last)?;
    let options = RenderOptions { field, ..RenderOptions::default() };
    let mut painter = Painter::new(&results.header, &options)?;
    painter.include(&frame);
    let size = fitted(painter.view.extent(), most);
    let (pixels, key) = painter.pixels(&frame, size);
    let range = match key {
        ColourKey::Scale { range, .. } => Some(range),
        ColourKey::Zones => None,
    };
    Ok(FieldMap { field, frames, time: frame.time, size, pixels, range })
}

/// Returns the largest size of the shape of an extent that fits into `most`.
fn fitted(extent: [f64; 2], most: [usize; 2]) -> [usize; 2] {
    let scale = f64::min(most[0] as f64 / extent[0], most[1] as f64 / extent[1]);
    extent.map(|length| ((length * scale).round() as usize).max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn map_keeps_its_shape_and_fits() {
        assert_eq!(fitted([4.0, 1.0], [80, 60]), [80, 20]);
        assert_eq!(fitted([1.0, 2.0], [80, 60]), [30, 60]);
        assert_eq!(fitted([1000.0, 1.0], [80, 60]), [80, 1]);
    }
}
