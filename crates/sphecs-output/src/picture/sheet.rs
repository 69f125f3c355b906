//! Layout of a picture around its field: title, time, axes in metres, colour scale or legend.

use super::canvas::{Anchor, Canvas, INK, Weight};
use super::field::Field;
use super::raster::WALL;
use super::scale::{Colours, labels, ticks, with_power};
use super::view::View;
use sphecs_core::format::{coordinate, with_digits};
use sphecs_core::particles::zone::Zone;

/// Meaning of the colours.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ColourKey {
    /// A continuous scale between two values.
    Scale {
        /// Colour map.
        colours: Colours,
        /// Values of its ends.
        range: (f64, f64),
    },
    /// The zones.
    Zones,
}

impl ColourKey {
    /// Returns the colour of a value.
    pub(super) fn colour(&self, value: f64) -> [u8; 3] {
        match self {
            ColourKey::Scale { colours, range } => colours.at((value - range.0) / (range.1 - range.0)),
            ColourKey::Zones => zone_colour(value as u8),
        }
    }
}

/// Returns time and plane of a picture: `z = 0 m,  t = 4.65 s`.
fn clock(view: &View, time: f64) -> String {
    // Five digits distinguish the frames of a long run.
    let time = format!("t = {} s", with_digits(time, 5));
    match view.dimensions {
        3 => format!("{} = {} m,  {time}", view.axis_name(2), coordinate(view.at, view.spacing)),
        _ => time,
    }
}

fn zone_colour(zone: u8) -> [u8; 3] {
    match zone {
        0 => [0x3d, 0x7f, 0xc4],
        1 => WALL,
        2 => [0x2c, 0xa0, 0x6a],
        3 => [0xe0, 0x82, 0x2c],
        _ => [0xff; 3],
    }
}

/// Positions and sizes, pixels.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Sheet {
    width: u32,
    height: u32,
    /// Upper left corner of the field.
    pub(super) corner: [i64; 2],
    /// Width and height of the field.
    pub(super) size: [i64; 2],
    /// Height of the small text.
    pub(super) text: f32,
    /// True if the colour scale is upright at the right instead of horizontal below.
    upright: bool,
}

impl Sheet {
    /// Returns the layout of a view for a width in pixels.
    pub(super) fn new(view: &View, width: u32) -> Self {
        let width = width.max(320);
        // At 1600 pixels width the text has 26 pixels, legible on a slide from a distance.
        let text = (width as f32 / 62.0).max(11.0);
        let unit = f64::from(text);
        let extent = view.extent();
        let upright = extent[0] < 1.8 * extent[1];
        let left = 4.6 * unit;
        let right = if upright { 8.0 * unit } else { 1.6 * unit };
        let mut size = [f64::from(width) - left - right, 0.0];
        size[1] = size[0] * extent[1] / extent[0];
        // A tall domain would exceed the screen.
        let tallest = 0.8 * f64::from(width);
        if size[1] > tallest {
            size = [tallest * extent[0] / extent[1], tallest];
        }
        let size = [size[0].round().max(1.0) as i64, size[1].round().max(1.0) as i64];
        let top = (3.9 * unit).round() as i64;
        let below = if upright { 3.2 * unit } else { 6.3 * unit };
        // Video encoders need even sizes.
        let height = (top + size[1] + below.round() as i64 + 1) & !1;
        Self {
            width: (width + 1) & !1,
            height: height as u32,
            corner: [left.round() as i64, top],
            size,
            text,
            upright,
        }
    }

    /// Draws all parts but the field.
    pub(super) fn draw(&self, view: &View, field: Field, key: &ColourKey, title: &str, time: f64) -> Canvas {
        let mut canvas = Canvas::new(self.width, self.height);
        self.heading(&mut canvas, view, title, time);
        self.axes(&mut canvas, view);
        match key {
            ColourKey::Scale { colours, range } => self.scale(&mut canvas, view, field, *colours, *range),
            ColourKey::Zones => self.legend(&mut canvas),
        }
        canvas
    }

    fn stroke(&self) -> i64 {
        (self.text / 14.0).round().max(1.0) as i64
    }

    fn heading(&self, canvas: &mut Canvas, view: &View, title: &str, time: f64) {
        let size = 1.15 * self.text;
        let baseline = 1.7 * self.text;
        let clock = clock(view, time);
        let right = self.width as f32 - self.text;
        let available =
            right - self.corner[0] as f32 - Canvas::text_width(&clock, size, Weight::Regular) - self.text;
        // A long title shrinks, and is cut off only when it would be too small to read.
        let mut title = title.to_owned();
        let mut title_size = size;
        let natural = Canvas::text_width(&title, size, Weight::Bold);
        if natural > available {
            title_size = (size * available / natural).max(0.6 * size);
            while title.chars().count() > 4
                && Canvas::text_width(&title, title_size, Weight::Bold) > available
            {
                title = title.trim_end_matches('…').chars().collect();
                title.pop();
                title.push('…');
            }
        }
        canvas.text(&title, [self.corner[0] as f32, baseline], title_size, Weight::Bold, Anchor::Left);
        canvas.text(&clock, [right, baseline], size, Weight::Regular, Anchor::Right);
    }

    fn axes(&self, canvas: &mut Canvas, view: &View) {
        let [x, y] = self.corner;
        let [width, height] = self.size;
        let (stroke, text) = (self.stroke(), self.text);
        canvas.outline(self.corner, self.size, stroke);
        let tick = (0.35 * text).round() as i64;

        let found = ticks(view.low[0], view.high[0], ((width as f32 / (5.0 * text)) as usize).max(2));
        let baseline = (y + height + tick) as f32 + 1.25 * text;
        let mut end = x as f32;
        for (value, label) in found.iter().zip(labels(&found, true).0) {
            let at = x + (width as f64 * (value - view.low[0]) / view.extent()[0]).round() as i64;
            canvas.fill([at, y + height], [stroke, tick + stroke], INK);
            canvas.text(&label, [at as f32, baseline], text, Weight::Regular, Anchor::Middle);
            end = at as f32 + 0.5 * Canvas::text_width(&label, text, Weight::Regular);
        }
        let name = format!("{} [m]", view.axis_name(0));
        let wide = Canvas::text_width(&name, text, Weight::Regular);
        // At the right end of the axis, or one line lower if the last label is there.
        let right = (x + width) as f32;
        let lower = if end + 0.5 * text > right - wide { 1.2 * text } else { 0.0 };
        canvas.text(&name, [right, baseline + lower], text, Weight::Regular, Anchor::Right);

        let found = ticks(view.low[1], view.high[1], ((height as f32 / (2.2 * text)) as usize).max(2));
        for (value, label) in found.iter().zip(labels(&found, true).0) {
            let at = y + (height as f64 * (view.high[1] - value) / view.extent()[1]).round() as i64;
            canvas.fill([x - tick - stroke, at], [tick + stroke, stroke], INK);
            let place = [(x - tick) as f32 - 0.4 * text, at as f32 + 0.36 * text];
            canvas.text(&label, place, text, Weight::Regular, Anchor::Right);
        }
        let name = format!("{} [m]", view.axis_name(1));
        let place = [(x - tick) as f32 - 0.4 * text, y as f32 - 0.75 * text];
        canvas.text(&name, place, text, Weight::Regular, Anchor::Right);
    }

    fn scale(&self, canvas: &mut Canvas, view: &View, field: Field, colours: Colours, range: (f64, f64)) {
        let [x, y] = self.corner;
        let [width, height] = self.size;
        let (stroke, text) = (self.stroke(), self.text);
        let tick = (0.3 * text).round() as i64;
        let breadth = (0.8 * text).round() as i64;
        let label_of = |power| {
            let unit = with_power(field.unit(), power);
            let name = match (field, view.dimensions) {
                (Field::Vorticity, 2) => "vorticity",
                (Field::Vorticity, _) => "vorticity |ω|",
                (other, _) => other.name(),
            };
            if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
        };
        let share = |value: f64| (value - range.0) / (range.1 - range.0);
        if self.upright {
            let corner = [x + width + (1.6 * text).round() as i64, y];
            for row in 0..height {
                let at = 1.0 - (row as f64 + 0.5) / height as f64;
                canvas.fill([corner[0], y + row], [breadth, 1], colours.at(at));
            }
            canvas.outline(corner, [breadth, height], stroke);
            let found = ticks(range.0, range.1, ((height as f32 / (2.5 * text)) as usize).clamp(2, 11));
            let (written, power) = labels(&found, false);
            for (value, label) in found.iter().zip(written) {
                let at = y + (height as f64 * (1.0 - share(*value))).round() as i64;
                canvas.fill([corner[0] + breadth, at], [tick + stroke, stroke], INK);
                let place = [(corner[0] + breadth + tick) as f32 + 0.4 * text, at as f32 + 0.36 * text];
                canvas.text(&label, place, text, Weight::Regular, Anchor::Left);
            }
            let right = self.width as f32 - 0.5 * text;
            canvas.text(
                &label_of(power),
                [right, y as f32 - 0.75 * text],
                text,
                Weight::Regular,
                Anchor::Right,
            );
            return;
        }
        let length = width / 2;
        let corner = [x + (width - length) / 2, y + height + (3.3 * text).round() as i64];
        for column in 0..length {
            let at = (column as f64 + 0.5) / length as f64;
            canvas.fill([corner[0] + column, corner[1]], [1, breadth], colours.at(at));
        }
        canvas.outline(corner, [length, breadth], stroke);
        let found = ticks(range.0, range.1, ((length as f32 / (4.2 * text)) as usize).clamp(2, 11));
        let (written, power) = labels(&found, false);
        for (value, label) in found.iter().zip(written) {
            let at = corner[0] + (length as f64 * share(*value)).round() as i64;
            canvas.fill([at, corner[1] + breadth], [stroke, tick + stroke], INK);
            let place = [at as f32, (corner[1] + breadth + tick) as f32 + 1.2 * text];
            canvas.text(&label, place, text, Weight::Regular, Anchor::Middle);
        }
        let place = [corner[0] as f32 - 0.8 * text, corner[1] as f32 + 0.75 * text];
        canvas.text(&label_of(power), place, text, Weight::Regular, Anchor::Right);
    }

    fn legend(&self, canvas: &mut Canvas) {
        let text = self.text;
        let side = (0.8 * text).round() as i64;
        let zones = [Zone::Fluid, Zone::Inflow, Zone::Outflow, Zone::Wall];
        let [mut x, mut y] = if self.upright {
            [self.corner[0] + self.size[0] + (1.6 * text) as i64, self.corner[1]]
        } else {
            [self.corner[0] + self.size[0] / 4, self.corner[1] + self.size[1] + (3.6 * text) as i64]
        };
        for zone in zones {
            canvas.fill([x, y], [side, side], zone_colour(zone as u8));
            canvas.outline([x, y], [side, side], self.stroke());
            let place = [(x + side) as f32 + 0.5 * text, y as f32 + 0.75 * text];
            canvas.text(zone.name(), place, text, Weight::Regular, Anchor::Left);
            if self.upright {
                y += (1.8 * text) as i64;
            } else {
                let wide = Canvas::text_width(zone.name(), text, Weight::Regular);
                x += side + (wide + 2.5 * text) as i64;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::header::Header;
    use crate::picture::view::Slice;

    /// A frame of 1 ms in a channel of 100 µm, and a middle that rounding moves off zero.
    #[test]
    fn heading_has_significant_digits_at_any_scale() {
        let view = |size: f64| {
            let bounds = [[0.0, -0.3 * size, -0.1 * size], [size, 0.3 * size, (0.3 - 0.2) * size]];
            let header = Header { dimensions: 3, spacing: 0.01 * size, bounds, ..Header::default() };
            move |slice| View::new(&header, slice).expect("a view")
        };
        assert_eq!(clock(&view(1.0)(None), 4.650_01), "z = 0 m,  t = 4.65 s");
        let slice = Slice { axis: 1, at: Some(2.5e-5) };
        assert_eq!(clock(&view(1e-4)(Some(slice)), 1.2345e-3), "y = 2.5e-5 m,  t = 0.0012345 s");
    }
}
