//! Picture in memory with lines and text.

use std::path::Path;
use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};
use image::{ImageFormat, Rgb, RgbImage};

use crate::error::OutputError;

/// Colour of axes and text, softer than black on white.
pub(super) const INK: [u8; 3] = [0x22, 0x26, 0x2b];
/// Background.
pub(super) const PAPER: [u8; 3] = [0xff; 3];

/// Edge of a text at its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Anchor {
    /// Left edge.
    Left,
    /// Middle.
    Middle,
    /// Right edge.
    Right,
}

/// Weight of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Weight {
    /// Regular.
    Regular,
    /// Bold.
    Bold,
}

/// Returns a font that is part of the program, so that pictures are equal on all machines.
fn font(weight: Weight) -> Option<&'static FontRef<'static>> {
    static REGULAR: OnceLock<Option<FontRef>> = OnceLock::new();
    static BOLD: OnceLock<Option<FontRef>> = OnceLock::new();
    match weight {
        Weight::Regular => REGULAR.get_or_init(|| FontRef::try_from_slice(dejavu::sans::regular()).ok()),
        Weight::Bold => BOLD.get_or_init(|| FontRef::try_from_slice(dejavu::sans::bold()).ok()),
    }
    .as_ref()
}

/// A picture in memory.
pub(super) struct Canvas {
    image: RgbImage,
}

impl Canvas {
    /// Returns an empty picture of a size in pixels.
    pub(super) fn new(width: u32, height: u32) -> Self {
        Self { image: RgbImage::from_pixel(width, height, Rgb(PAPER)) }
    }

    /// Returns the colour of a pixel.
    #[cfg(test)]
    pub(super) fn pixel(&self, x: u32, y: u32) -> [u8; 3] {
        self.image.get_pixel(x, y).0
    }

    /// Sets a pixel; positions outside the picture are ignored.
    pub(super) fn set(&mut self, x: i64, y: i64, colour: [u8; 3]) {
        if let Some(pixel) = self.pixel_mut(x, y) {
            *pixel = Rgb(colour);
        }
    }

    fn pixel_mut(&mut self, x: i64, y: i64) -> Option<&mut Rgb<u8>> {
        let (x, y) = (u32::try_from(x).ok()?, u32::try_from(y).ok()?);
        self.image.get_pixel_mut_checked(x, y)
    }

    /// Fills a rectangle from its upper left corner.
    pub(super) fn fill(&mut self, [x, y]: [i64; 2], [width, height]: [i64; 2], colour: [u8; 3]) {
        for row in y..y + height {
            for column in x..x + width {
                self.set(column, row, colour);
            }
        }
    }

    /// Draws the outline of a rectangle, `thick` pixels outside it.
    pub(super) fn outline(&mut self, [x, y]: [i64; 2], [width, height]: [i64; 2], thick: i64) {
        let (outer, high) = (width + 2 * thick, height + 2 * thick);
        self.fill([x - thick, y - thick], [outer, thick], INK);
        self.fill([x - thick, y + height], [outer, thick], INK);
        self.fill([x - thick, y - thick], [thick, high], INK);
        self.fill([x + width, y - thick], [thick, high], INK);
    }

    /// Draws a straight line, `thick` pixels wide.
    pub(super) fn line(&mut self, from: [f64; 2], to: [f64; 2], thick: f64, colour: [u8; 3]) {
        let length = (to[0] - from[0]).hypot(to[1] - from[1]);
        let side = thick.round().max(1.0) as i64;
        let steps = length.ceil().max(1.0);
        for step in 0..=steps as i64 {
            let share = step as f64 / steps;
            let place = [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]));
            let corner = place.map(|coordinate| (coordinate - 0.5 * thick).round() as i64);
            self.fill(corner, [side, side], colour);
        }
    }

    /// Returns the width of a text, pixels.
    pub(super) fn text_width(text: &str, size: f32, weight: Weight) -> f32 {
        layout(text, size, weight).map_or(0.0, |(_, width)| width)
    }

    /// Draws a text with its baseline through `at`; `size` is the line height in pixels.
    pub(super) fn text(&mut self, text: &str, at: [f32; 2], size: f32, weight: Weight, anchor: Anchor) {
        let (Some(font), Some((glyphs, width))) = (font(weight), layout(text, size, weight)) else {
            return;
        };
        let left = match anchor {
            Anchor::Left => at[0],
            Anchor::Middle => at[0] - 0.5 * width,
            Anchor::Right => at[0] - width,
        };
        for mut glyph in glyphs {
            // Whole pixels keep the stems of all letters sharp.
            glyph.position += point(left.round(), at[1].round());
            let Some(outline) = font.outline_glyph(glyph) else {
                continue;
            };
            let corner = outline.px_bounds().min;
            outline.draw(|x, y, cover| {
                let place = (corner.x as i64 + i64::from(x), corner.y as i64 + i64::from(y));
                if let Some(pixel) = self.pixel_mut(place.0, place.1) {
                    for (channel, ink) in pixel.0.iter_mut().zip(INK) {
                        let mixed =
                            f32::from(*channel) + (f32::from(ink) - f32::from(*channel)) * cover.min(1.0);
                        *channel = mixed.round() as u8;
                    }
                }
            });
        }
    }

    /// Writes the picture as PNG, completely or not at all.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub(super) fn save(&self, path: &Path) -> Result<(), OutputError> {
        let mut bytes = std::io::Cursor::new(Vec::new());
        self.image.write_to(&mut bytes, ImageFormat::Png).map_err(|error| OutputError::Io {
            path: path.to_path_buf(),
            doing: "write",
            cause: std::io::Error::other(error),
        })?;
        crate::disk::write_whole(path, bytes.get_ref())
    }
}

/// Returns the glyphs of a text along a baseline from the origin, and its width in pixels.
fn layout(text: &str, size: f32, weight: Weight) -> Option<(Vec<Glyph>, f32)> {
    let font = font(weight)?;
    let scale = PxScale::from(size);
    let scaled = font.as_scaled(scale);
    let mut pen = 0.0;
    let mut previous = None;
    let mut glyphs = Vec::new();
    for letter in text.chars() {
        let id = font.glyph_id(letter);
        if let Some(previous) = previous {
            pen += scaled.kern(previous, id);
        }
        glyphs.push(id.with_scale_and_position(scale, point(pen, 0.0)));
        pen += scaled.h_advance(id);
        previous = Some(id);
    }
    Some((glyphs, pen))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn text_is_drawn_at_its_anchor() {
        let mut canvas = Canvas::new(200, 40);
        canvas.text("Δp = −3 kg/m³", [190.0, 30.0], 20.0, Weight::Regular, Anchor::Right);
        let width = Canvas::text_width("Δp = −3 kg/m³", 20.0, Weight::Regular);
        let inked = |x: u32| (0..40).any(|y| canvas.pixel(x, y) != PAPER);
        let columns: Vec<u32> = (0..200).filter(|&x| inked(x)).collect();
        assert!(columns[0] as f32 >= 189.0 - width && columns[columns.len() - 1] <= 191, "{columns:?}");
    }

    #[test]
    fn drawing_outside_is_ignored() {
        let mut canvas = Canvas::new(10, 10);
        canvas.fill([-5, 8], [30, 30], INK);
        canvas.text("far away", [-500.0, 900.0], 30.0, Weight::Bold, Anchor::Left);
        assert_eq!(canvas.pixel(0, 9), INK);
        assert_eq!(canvas.pixel(0, 0), PAPER);
    }
}
