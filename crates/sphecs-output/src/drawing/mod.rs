//! Drawings of lines, areas, images and text, written as PNG, SVG or PDF.
//!
//! All pictures and plots of sphecs are such a list of shapes, so that a picture looks the same in
//! every format: `png` turns it into pixels, `svg` and `pdf` keep lines and text sharp at any size.
//! Plots were drawn by the crate plotters before. It writes SVG only without a font engine of its
//! own, knows no PDF, and its axes would have been second ones beside those of the pictures.
//!
//! - `letters`: fonts and the place of each letter
//! - [`ticks`]: round numbers on axes and their labels
//! - [`colours`]: colour maps
//! - [`chart`], `chart_panel`: curves over an axis, in panels
//! - `png`, `svg`, `pdf`: the formats

pub mod chart;
mod chart_panel;
pub mod colours;
mod letters;
mod pdf;
mod png;
mod svg;
pub mod ticks;

use std::path::Path;

use crate::error::OutputError;

pub(crate) use letters::{Anchor, Weight, text_width};

/// Colour as red, green and blue.
pub type Colour = [u8; 3];

/// Colour of axes and text, softer than black on white.
pub(crate) const INK: Colour = [0x22, 0x26, 0x2b];
/// Background.
pub(crate) const PAPER: Colour = [0xff; 3];

/// Formats of a drawing, by the ending of its file.
pub const FORMATS: [&str; 3] = ["png", "svg", "pdf"];

/// Pen of a line.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pen {
    /// Width, pixels.
    pub(crate) width: f64,
    /// Colour.
    pub(crate) colour: Colour,
    /// Lengths of dash and gap, pixels; None for an unbroken line.
    pub(crate) dash: Option<[f64; 2]>,
}

/// Part of a drawing, in pixels from the upper left corner.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Shape {
    /// Image, row by row from the top.
    Image { corner: [i64; 2], size: [usize; 2], pixels: Vec<Colour> },
    /// Rectangle on whole pixels.
    Rectangle { corner: [i64; 2], size: [i64; 2], colour: Colour },
    /// Filled polygon.
    Area { points: Vec<[f64; 2]>, colour: Colour },
    /// Line through points.
    Line { points: Vec<[f64; 2]>, pen: Pen },
    /// Text with its baseline through `at`; `size` is the line height.
    Text { text: String, at: [f32; 2], size: f32, weight: Weight, anchor: Anchor },
}

/// A list of shapes, each drawn over those before it.
#[derive(Clone, Debug, PartialEq)]
pub struct Drawing {
    /// Width and height, pixels.
    pub(crate) size: [u32; 2],
    pub(crate) shapes: Vec<Shape>,
}

impl Drawing {
    /// Returns an empty drawing of a size in pixels.
    pub(crate) fn new(width: u32, height: u32) -> Self {
        Self { size: [width, height], shapes: Vec::new() }
    }

    /// Fills a rectangle from its upper left corner.
    pub(crate) fn fill(&mut self, corner: [i64; 2], size: [i64; 2], colour: Colour) {
        self.shapes.push(Shape::Rectangle { corner, size, colour });
    }

    /// Draws the outline of a rectangle, `thick` pixels outside it.
    pub(crate) fn outline(&mut self, [x, y]: [i64; 2], [width, height]: [i64; 2], thick: i64) {
        let (outer, high) = (width + 2 * thick, height + 2 * thick);
        self.fill([x - thick, y - thick], [outer, thick], INK);
        self.fill([x - thick, y + height], [outer, thick], INK);
        self.fill([x - thick, y - thick], [thick, high], INK);
        self.fill([x + width, y - thick], [thick, high], INK);
    }

    /// Draws a straight line, `thick` pixels wide.
    pub(crate) fn line(&mut self, from: [f64; 2], to: [f64; 2], thick: f64, colour: Colour) {
        self.curve(vec![from, to], Pen { width: thick, colour, dash: None });
    }

    /// Draws a line through points.
    pub(crate) fn curve(&mut self, points: Vec<[f64; 2]>, pen: Pen) {
        if points.len() > 1 {
            self.shapes.push(Shape::Line { points, pen });
        }
    }

    /// Fills a polygon.
    pub(crate) fn area(&mut self, points: Vec<[f64; 2]>, colour: Colour) {
        self.shapes.push(Shape::Area { points, colour });
    }

    /// Draws an image whose `pixels` are given row by row from the top.
    pub(crate) fn image(&mut self, corner: [i64; 2], size: [usize; 2], pixels: Vec<Colour>) {
        self.shapes.push(Shape::Image { corner, size, pixels });
    }

    /// Draws a text with its baseline through `at`; `size` is the line height in pixels.
    pub(crate) fn text(&mut self, text: &str, at: [f32; 2], size: f32, weight: Weight, anchor: Anchor) {
        self.shapes.push(Shape::Text { text: text.to_owned(), at, size, weight, anchor });
    }

    /// Returns the drawing in pixels.
    pub(crate) fn pixels(&self) -> image::RgbImage {
        png::pixels(self)
    }

    /// Writes the drawing in the format of the ending of its path, PNG without one, completely or
    /// not at all.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause, or the formats for any other ending.
    pub fn save(&self, path: &Path) -> Result<(), OutputError> {
        let ending = path.extension().unwrap_or("png".as_ref()).to_string_lossy().to_ascii_lowercase();
        let bytes = match ending.as_str() {
            "png" => png::encode(self),
            "svg" => svg::encode(self).map(String::into_bytes),
            "pdf" => pdf::encode(self),
            _ => {
                return Err(OutputError::Request(format!(
                    "`{}`: must end in one of {}",
                    path.display(),
                    FORMATS.map(|format| format!("`.{format}`")).join(", ")
                )));
            }
        };
        let bytes = bytes.map_err(|cause| OutputError::io(path, "write")(std::io::Error::other(cause)))?;
        crate::disk::write_whole(path, &bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Drawing {
        let mut drawing = Drawing::new(120, 60);
        drawing.image([10, 10], [2, 1], vec![[255, 0, 0], [0, 0, 255]]);
        drawing.fill([20, 20], [10, 5], INK);
        drawing.area(vec![[40.0, 10.0], [60.0, 10.0], [60.0, 30.0], [40.0, 30.0]], [0, 128, 0]);
        drawing.curve(
            vec![[0.0, 50.0], [60.0, 50.0], [120.0, 50.0]],
            Pen { width: 4.0, colour: [128, 0, 0], dash: Some([10.0, 10.0]) },
        );
        drawing.text("Δp < 3 & ω", [110.0, 25.0], 16.0, Weight::Regular, Anchor::Right);
        drawing
    }

    #[test]
    fn shapes_have_their_pixels() {
        let pixels = sample().pixels();
        let at = |x, y| pixels.get_pixel(x, y).0;
        assert_eq!((at(10, 10), at(11, 10), at(12, 10)), ([255, 0, 0], [0, 0, 255], PAPER));
        assert_eq!((at(20, 20), at(29, 24), at(30, 24)), (INK, INK, PAPER));
        assert_eq!((at(50, 20), at(61, 20)), ([0, 128, 0], PAPER));
        // Dashes of ten pixels, then gaps of ten.
        assert_eq!((at(5, 50), at(15, 50), at(25, 50)), ([128, 0, 0], PAPER, [128, 0, 0]));
    }

    #[test]
    fn every_format_is_written_and_others_are_refused() {
        let folder = tempfile::tempdir().expect("a folder");
        let written = |name: &str| {
            let path = folder.path().join(name);
            sample().save(&path).expect("written");
            std::fs::read(path).expect("read")
        };
        assert!(written("a.png").starts_with(b"\x89PNG"));
        let svg = String::from_utf8(written("a.SVG")).expect("text");
        assert!(svg.contains("Δp &lt; 3 &amp; ω") && svg.trim_end().ends_with("</svg>"), "{svg}");
        assert_eq!((svg.matches("<polygon").count(), svg.matches("<polyline").count()), (1, 1));
        let pdf = written("a.pdf");
        assert!(pdf.starts_with(b"%PDF-1.7") && pdf.trim_ascii_end().ends_with(b"%%EOF"));
        let refused = sample().save(&folder.path().join("a.jpg")).expect_err("refused").to_string();
        assert!(refused.contains("`.svg`") && !folder.path().join("a.jpg").exists(), "{refused}");
    }
}
