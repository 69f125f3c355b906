//! Letters of a text: fonts, and the place of each letter along the baseline.

use std::sync::OnceLock;

use ab_glyph::{Font, FontRef, Glyph, PxScale, ScaleFont, point};

/// Edge of a text at its position.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Anchor {
    /// Left edge.
    Left,
    /// Middle.
    Middle,
    /// Right edge.
    Right,
}

/// Weight of a text.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Weight {
    /// Regular.
    Regular,
    /// Bold.
    Bold,
}

/// Returns a font that is part of the program, so that pictures are equal on all machines.
pub(super) fn font(weight: Weight) -> Option<&'static FontRef<'static>> {
    static REGULAR: OnceLock<Option<FontRef>> = OnceLock::new();
    static BOLD: OnceLock<Option<FontRef>> = OnceLock::new();
    match weight {
        Weight::Regular => REGULAR.get_or_init(|| FontRef::try_from_slice(dejavu::sans::regular()).ok()),
        Weight::Bold => BOLD.get_or_init(|| FontRef::try_from_slice(dejavu::sans::bold()).ok()),
    }
    .as_ref()
}

/// Returns the width of a text, pixels.
pub(crate) fn text_width(text: &str, size: f32, weight: Weight) -> f32 {
    layout(text, size, weight).map_or(0.0, |(_, width)| width)
}

/// Returns the height of a capital M over the line height, by which other programs state sizes.
pub(super) fn em_of_line_height(weight: Weight) -> f32 {
    let em = font(weight).and_then(|font| Some(font.units_per_em()? / font.height_unscaled()));
    em.unwrap_or(1.0)
}

/// Returns the glyphs of a text with their places, for a baseline that begins at `at`, has its
/// middle there or ends there.
pub(super) fn placed(text: &str, at: [f32; 2], size: f32, weight: Weight, anchor: Anchor) -> Vec<Glyph> {
    let Some((mut glyphs, width)) = layout(text, size, weight) else { return Vec::new() };
    let left = match anchor {
        Anchor::Left => at[0],
        Anchor::Middle => at[0] - 0.5 * width,
        Anchor::Right => at[0] - width,
    };
    // Whole pixels keep the stems of all letters sharp.
    glyphs.iter_mut().for_each(|glyph| glyph.position += point(left.round(), at[1].round()));
    glyphs
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
    use super::super::{Drawing, INK, PAPER};
    use super::*;

    #[test]
    fn text_is_drawn_at_its_anchor() {
        let mut drawing = Drawing::new(200, 40);
        drawing.text("Δp = −3 kg/m³", [190.0, 30.0], 20.0, Weight::Regular, Anchor::Right);
        let width = text_width("Δp = −3 kg/m³", 20.0, Weight::Regular);
        let pixels = drawing.pixels();
        let inked = |x: u32| (0..40).any(|y| pixels.get_pixel(x, y).0 != PAPER);
        let columns: Vec<u32> = (0..200).filter(|&x| inked(x)).collect();
        assert!(columns[0] as f32 >= 189.0 - width && columns[columns.len() - 1] <= 191, "{columns:?}");
    }

    #[test]
    fn drawing_outside_is_ignored() {
        let mut drawing = Drawing::new(10, 10);
        drawing.fill([-5, 8], [30, 30], INK);
        drawing.text("far away", [-500.0, 900.0], 30.0, Weight::Bold, Anchor::Left);
        let pixels = drawing.pixels();
        assert_eq!(pixels.get_pixel(0, 9).0, INK);
        assert_eq!(pixels.get_pixel(0, 0).0, PAPER);
    }
}
