//! Drawing as a PDF file of one page.
//!
//! Letters are outlines, so that the file needs no font and looks the same everywhere.

use ab_glyph::{Font, Glyph, OutlineCurve};
use pdf_writer::types::{LineCapStyle, LineJoinStyle};
use pdf_writer::{Content, Filter, Finish, Name, Pdf, Rect, Ref};

use super::letters::{font, placed};
use super::{Colour, Drawing, INK, PAPER, Shape, Weight};

/// Width of the page, points of 1/72 inch: 20 cm, at which the text of a picture has 9 points.
const PAGE: f32 = 576.0;

/// Number of the objects before the images: catalogue, list of pages, page and content.
const FIRST_IMAGE: i32 = 5;

/// Returns the drawing as a PDF file.
///
/// # Errors
/// The reason why an image of the drawing cannot be encoded.
pub(super) fn encode(drawing: &Drawing) -> Result<Vec<u8>, String> {
    let [catalogue, pages, page, content] = [1, 2, 3, 4].map(Ref::new);
    let [width, height] = drawing.size.map(|length| length as f32);
    let scale = PAGE / width.max(1.0);
    let media = Rect::new(0.0, 0.0, width * scale, height * scale);

    let mut pdf = Pdf::new();
    pdf.catalog(catalogue).pages(pages);
    pdf.pages(pages).kids([page]).count(1);
    let mut drawn = Content::new();
    // The origin of a page is its lower left corner.
    drawn.transform([scale, 0.0, 0.0, -scale, 0.0, height * scale]);
    fill(&mut drawn, PAPER);
    drawn.rect(0.0, 0.0, width, height).fill_nonzero();
    let mut images = Vec::new();
    for shape in &drawing.shapes {
        add(&mut drawn, shape, &mut images);
    }
    pdf.stream(content, &deflated(&drawn.finish())?).filter(Filter::FlateDecode);

    let mut sheet = pdf.page(page);
    sheet.media_box(media).parent(pages).contents(content);
    let mut resources = sheet.resources();
    let mut objects = resources.x_objects();
    for index in 0..images.len() {
        objects.pair(Name(name(index).as_bytes()), Ref::new(FIRST_IMAGE + index as i32));
    }
    objects.finish();
    resources.finish();
    sheet.finish();
    for (index, (size, pixels)) in images.into_iter().enumerate() {
        let data = deflated(pixels.as_flattened())?;
        let mut image = pdf.image_xobject(Ref::new(FIRST_IMAGE + index as i32), &data);
        image.filter(Filter::FlateDecode);
        image.width(size[0] as i32).height(size[1] as i32);
        image.color_space().device_rgb();
        image.bits_per_component(8);
    }
    Ok(pdf.finish())
}

fn name(index: usize) -> String {
    format!("Image{index}")
}

fn add<'a>(content: &mut Content, shape: &'a Shape, images: &mut Vec<([usize; 2], &'a [Colour])>) {
    match shape {
        Shape::Image { corner, size, pixels } => {
            let [width, height] = size.map(|length| length as f32);
            let [left, top] = corner.map(|coordinate| coordinate as f32);
            content.save_state().transform([width, 0.0, 0.0, -height, left, top + height]);
            content.x_object(Name(name(images.len()).as_bytes())).restore_state();
            images.push((*size, pixels));
        }
        Shape::Rectangle { corner, size, colour } => {
            fill(content, *colour);
            content.rect(corner[0] as f32, corner[1] as f32, size[0] as f32, size[1] as f32).fill_nonzero();
        }
        Shape::Area { points, colour } => {
            fill(content, *colour);
            trace(content, points);
            content.close_path().fill_nonzero();
        }
        Shape::Line { points, pen } => {
            let [red, green, blue] = pen.colour.map(|channel| f32::from(channel) / 255.0);
            content.save_state().set_stroke_rgb(red, green, blue).set_line_width(pen.width as f32);
            content.set_line_join(LineJoinStyle::RoundJoin).set_line_cap(LineCapStyle::ButtCap);
            if let Some(dash) = pen.dash {
                content.set_dash_pattern(dash.map(|length| length as f32), 0.0);
            }
            trace(content, points);
            content.stroke().restore_state();
        }
        Shape::Text { text, at, size, weight, anchor } => {
            fill(content, INK);
            for glyph in placed(text, *at, *size, *weight, *anchor) {
                letter(content, &glyph, *weight);
            }
        }
    }
}

fn fill(content: &mut Content, colour: Colour) {
    let [red, green, blue] = colour.map(|channel| f32::from(channel) / 255.0);
    content.set_fill_rgb(red, green, blue);
}

fn trace(content: &mut Content, points: &[[f64; 2]]) {
    for (index, point) in points.iter().enumerate() {
        let [x, y] = point.map(|coordinate| coordinate as f32);
        if index == 0 {
            content.move_to(x, y)
        } else {
            content.line_to(x, y)
        };
    }
}

fn letter(content: &mut Content, glyph: &Glyph, weight: Weight) {
    let Some(font) = font(weight) else { return };
    let Some(outline) = font.outline(glyph.id) else { return };
    let scale = glyph.scale.y / font.height_unscaled();
    let place =
        |point: ab_glyph::Point| [glyph.position.x + scale * point.x, glyph.position.y - scale * point.y];
    let mut pen = None;
    for curve in outline.curves {
        let (start, end) = match curve {
            OutlineCurve::Line(start, end)
            | OutlineCurve::Quad(start, _, end)
            | OutlineCurve::Cubic(start, _, _, end) => (start, end),
        };
        let [x, y] = place(start);
        if pen != Some((start.x, start.y)) {
            content.move_to(x, y);
        }
        let [end_x, end_y] = place(end);
        match curve {
            OutlineCurve::Line(..) => content.line_to(end_x, end_y),
            OutlineCurve::Quad(start, control, end) => {
                // The cubic curve of a parabola has its controls at two thirds of the way.
                let towards = |from: f32, to: f32| from + 2.0 / 3.0 * (to - from);
                let first = place(ab_glyph::point(towards(start.x, control.x), towards(start.y, control.y)));
                let second = place(ab_glyph::point(towards(end.x, control.x), towards(end.y, control.y)));
                content.cubic_to(first[0], first[1], second[0], second[1], end_x, end_y)
            }
            OutlineCurve::Cubic(_, first, second, _) => {
                let ([a, b], [c, d]) = (place(first), place(second));
                content.cubic_to(a, b, c, d, end_x, end_y)
            }
        };
        pen = Some((end.x, end.y));
    }
    content.fill_nonzero();
}

/// Returns bytes compressed as PDF readers expect.
fn deflated(bytes: &[u8]) -> Result<Vec<u8>, String> {
    use std::io::Write;
    let mut encoder = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
    encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(|error| error.to_string())
}
