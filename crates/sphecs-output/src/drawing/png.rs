//! Drawing as pixels and as PNG.
//!
//! Rectangles and images cover whole pixels; edges of lines, areas and letters are smoothed.

use ab_glyph::Font;
use image::{ImageFormat, RgbImage};
use tiny_skia::{
    Color, FillRule, LineCap, LineJoin, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform,
};

use super::letters::{font, placed};
use super::{Anchor, Colour, Drawing, Pen, Shape, Weight};

/// Returns the drawing as a PNG file.
///
/// # Errors
/// The reason why it cannot be encoded.
pub(super) fn encode(drawing: &Drawing) -> Result<Vec<u8>, String> {
    let mut bytes = std::io::Cursor::new(Vec::new());
    let written = pixels(drawing).write_to(&mut bytes, ImageFormat::Png);
    written.map_err(|error| error.to_string())?;
    Ok(bytes.into_inner())
}

/// Returns the drawing in pixels.
pub(super) fn pixels(drawing: &Drawing) -> RgbImage {
    let [width, height] = drawing.size.map(|length| length.max(1));
    let mut image = RgbImage::new(width, height);
    // No memory is left for a picture of this size if there is no pixmap.
    let Some(mut pixmap) = Pixmap::new(width, height) else { return image };
    pixmap.fill(Color::WHITE);
    for shape in &drawing.shapes {
        paint(&mut pixmap, shape);
    }
    for (pixel, colour) in image.pixels_mut().zip(pixmap.pixels()) {
        pixel.0 = [colour.red(), colour.green(), colour.blue()];
    }
    image
}

fn paint(pixmap: &mut Pixmap, shape: &Shape) {
    match shape {
        Shape::Image { corner, size, pixels } => {
            for (index, &colour) in pixels.iter().enumerate() {
                let place = [corner[0] + (index % size[0]) as i64, corner[1] + (index / size[0]) as i64];
                blend(pixmap, place, colour, 1.0);
            }
        }
        Shape::Rectangle { corner, size, colour } => {
            let [x, y] = corner.map(|coordinate| coordinate as f32);
            if let Some(area) = Rect::from_xywh(x, y, size[0] as f32, size[1] as f32) {
                pixmap.fill_rect(area, &ink(*colour, false), Transform::identity(), None);
            }
        }
        Shape::Area { points, colour } => {
            if let Some(path) = path(points, true) {
                let (rule, still) = (FillRule::Winding, Transform::identity());
                pixmap.fill_path(&path, &ink(*colour, true), rule, still, None);
            }
        }
        Shape::Line { points, pen } => {
            if let Some(path) = path(points, false) {
                pixmap.stroke_path(&path, &ink(pen.colour, true), &stroke(pen), Transform::identity(), None);
            }
        }
        Shape::Text { text, at, size, weight, anchor } => {
            letters(pixmap, text, *at, *size, *weight, *anchor);
        }
    }
}

fn ink([red, green, blue]: Colour, is_smooth: bool) -> Paint<'static> {
    let mut paint = Paint::default();
    paint.set_color_rgba8(red, green, blue, 255);
    paint.anti_alias = is_smooth;
    paint
}

fn stroke(pen: &Pen) -> Stroke {
    Stroke {
        width: pen.width as f32,
        line_cap: LineCap::Butt,
        line_join: LineJoin::Round,
        dash: pen.dash.and_then(|dash| StrokeDash::new(dash.map(|length| length as f32).to_vec(), 0.0)),
        ..Stroke::default()
    }
}

fn path(points: &[[f64; 2]], is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    let mut all = points.iter().map(|point| point.map(|coordinate| coordinate as f32));
    let [x, y] = all.next()?;
    builder.move_to(x, y);
    all.for_each(|[x, y]| builder.line_to(x, y));
    if is_closed {
        builder.close();
    }
    builder.finish()
}

/// Draws the letters with the exact share of each pixel that they cover, which keeps small text
/// legible.
fn letters(pixmap: &mut Pixmap, text: &str, at: [f32; 2], size: f32, weight: Weight, anchor: Anchor) {
    let Some(font) = font(weight) else { return };
    for glyph in placed(text, at, size, weight, anchor) {
        let Some(outline) = font.outline_glyph(glyph) else { continue };
        let corner = outline.px_bounds().min;
        outline.draw(|x, y, cover| {
            let place = [corner.x as i64 + i64::from(x), corner.y as i64 + i64::from(y)];
            blend(pixmap, place, super::INK, cover);
        });
    }
}

/// Mixes a colour into a pixel; places outside the picture are ignored.
fn blend(pixmap: &mut Pixmap, [x, y]: [i64; 2], colour: Colour, share: f32) {
    let (width, height) = (i64::from(pixmap.width()), i64::from(pixmap.height()));
    if !(0..width).contains(&x) || !(0..height).contains(&y) {
        return;
    }
    let first = 4 * (y * width + x) as usize;
    for (channel, ink) in pixmap.data_mut()[first..first + 3].iter_mut().zip(colour) {
        let below = f32::from(*channel);
        *channel = (below + (f32::from(ink) - below) * share.min(1.0)).round() as u8;
    }
}
