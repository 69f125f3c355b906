//! Drawing as SVG, whose text stays text.
//!
//! Letters are those of the reader's font, which has other widths than the one of the program; the
//! anchor of a text is kept.

use std::fmt::Write;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;

use super::letters::em_of_line_height;
use super::{Anchor, Colour, Drawing, INK, Pen, Shape, Weight};

/// Returns the drawing as an SVG file.
///
/// # Errors
/// The reason why an image of the drawing cannot be encoded.
pub(super) fn encode(drawing: &Drawing) -> Result<String, String> {
    let [width, height] = drawing.size;
    let mut text = String::new();
    let _infallible = write!(
        text,
        "<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"{width}\" height=\"{height}\" \
         viewBox=\"0 0 {width} {height}\" \
         font-family=\"DejaVu Sans, Verdana, Helvetica, Arial, sans-serif\">\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n"
    );
    for shape in &drawing.shapes {
        add(&mut text, shape)?;
    }
    text.push_str("</svg>\n");
    Ok(text)
}

fn add(text: &mut String, shape: &Shape) -> Result<(), String> {
    let _infallible = match shape {
        Shape::Image { corner, size, pixels } => {
            let mut image = Drawing::new(size[0] as u32, size[1] as u32);
            image.image([0, 0], *size, pixels.clone());
            let data = STANDARD.encode(super::png::encode(&image)?);
            writeln!(
                text,
                "<image x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" href=\"data:image/png;base64,{data}\"/>",
                corner[0], corner[1], size[0], size[1]
            )
        }
        Shape::Rectangle { corner, size, colour } => writeln!(
            text,
            "<rect x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" fill=\"{}\"/>",
            corner[0],
            corner[1],
            size[0],
            size[1],
            hexadecimal(*colour)
        ),
        Shape::Area { points, colour } => {
            writeln!(text, "<polygon points=\"{}\" fill=\"{}\"/>", list(points), hexadecimal(*colour))
        }
        Shape::Line { points, pen } => {
            writeln!(text, "<polyline points=\"{}\" fill=\"none\" {}/>", list(points), stroke(pen))
        }
        Shape::Text { text: content, at, size, weight, anchor } => writeln!(
            text,
            "<text x=\"{}\" y=\"{}\" font-size=\"{:.2}\"{}{} fill=\"{}\">{}</text>",
            at[0].round(),
            at[1].round(),
            size * em_of_line_height(*weight),
            match anchor {
                Anchor::Left => "",
                Anchor::Middle => " text-anchor=\"middle\"",
                Anchor::Right => " text-anchor=\"end\"",
            },
            if *weight == Weight::Bold { " font-weight=\"bold\"" } else { "" },
            hexadecimal(INK),
            escaped(content)
        ),
    };
    Ok(())
}

fn hexadecimal([red, green, blue]: Colour) -> String {
    format!("#{red:02x}{green:02x}{blue:02x}")
}

/// Returns points with a hundredth of a pixel, which no reader can see.
fn list(points: &[[f64; 2]]) -> String {
    points.iter().map(|[x, y]| format!("{x:.2},{y:.2}")).collect::<Vec<_>>().join(" ")
}

fn stroke(pen: &Pen) -> String {
    let dash = pen.dash.map_or_else(String::new, |[dash, gap]| format!(" stroke-dasharray=\"{dash},{gap}\""));
    format!(
        "stroke=\"{}\" stroke-width=\"{:.2}\" stroke-linejoin=\"round\"{dash}",
        hexadecimal(pen.colour),
        pen.width
    )
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}
