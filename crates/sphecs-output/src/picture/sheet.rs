//! Layout of a picture around its field: title, time, axes in metres, colour scale or legend.

use super::arrows::head;
use super::field::Field;
use super::raster::WALL;
use super::view::View;
use crate::drawing::colours::Colours;
use crate::drawing::ticks::{labels, ticks, with_power};
use crate::drawing::{Anchor, Colour, Drawing, INK, Weight, text_width};
use sphecs_core::format::{coordinate, significant, with_digits};
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
pub(super) fn clock(view: &View, time: f64) -> String {
    in_plane(view, &time_of(time))
}

/// Returns time and plane of a mean: `z = 0 m,  mean of 1 to 2 s`.
pub(super) fn interval(view: &View, (from, to): (f64, f64)) -> String {
    in_plane(view, &format!("mean of {} to {} s", with_digits(from, 5), with_digits(to, 5)))
}

/// Returns `t = 4.65 s`.
fn time_of(time: f64) -> String {
    // Five digits distinguish the frames of a long run.
    format!("t = {} s", with_digits(time, 5))
}

fn in_plane(view: &View, time: &str) -> String {
    match view.dimensions {
        3 => format!("{} = {} m,  {time}", view.axis_name(2), coordinate(view.at, view.spacing)),
        _ => time.to_owned(),
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
    pub(super) width: u32,
    pub(super) height: u32,
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
        Self::around(view.extent(), width)
    }

    /// Returns the layout of a picture in space with an extent to the right and upwards.
    pub(super) fn in_space(extent: [f64; 2], width: u32) -> Self {
        Self::around(extent, width)
    }

    fn around(extent: [f64; 2], width: u32) -> Self {
        let width = width.max(320);
        // At 1600 pixels width the text has 26 pixels, legible on a slide from a distance.
        let text = (width as f32 / 62.0).max(11.0);
        let unit = f64::from(text);
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
    pub(super) fn draw(
        &self,
        view: &View,
        field: Field,
        key: &ColourKey,
        title: &str,
        when: &str,
    ) -> Drawing {
        let mut drawing = Drawing::new(self.width, self.height);
        self.heading(&mut drawing, title, when);
        self.axes(&mut drawing, view);
        self.key(&mut drawing, field, view.dimensions, key);
        drawing
    }

    /// Draws all parts of a picture in space but the particles.
    pub(super) fn draw_in_space(&self, field: Field, key: &ColourKey, title: &str, time: f64) -> Drawing {
        let mut drawing = Drawing::new(self.width, self.height);
        self.heading(&mut drawing, title, &time_of(time));
        self.key(&mut drawing, field, 3, key);
        drawing
    }

    fn key(&self, drawing: &mut Drawing, field: Field, dimensions: usize, key: &ColourKey) {
        match key {
            ColourKey::Scale { colours, range } => self.scale(drawing, field, dimensions, *colours, *range),
            ColourKey::Zones => self.legend(drawing),
        }
    }

    fn stroke(&self) -> i64 {
        (self.text / 14.0).round().max(1.0) as i64
    }

    fn heading(&self, drawing: &mut Drawing, title: &str, clock: &str) {
        let size = 1.15 * self.text;
        let baseline = 1.7 * self.text;
        let right = self.width as f32 - self.text;
        let available = right - self.corner[0] as f32 - text_width(clock, size, Weight::Regular) - self.text;
        // A long title shrinks, and is cut off only when it would be too small to read.
        let mut title = title.to_owned();
        let mut title_size = size;
        let natural = text_width(&title, size, Weight::Bold);
        if natural > available {
            title_size = (size * available / natural).max(0.6 * size);
            while title.chars().count() > 4 && text_width(&title, title_size, Weight::Bold) > available {
                title = title.trim_end_matches('…').chars().collect();
                title.pop();
                title.push('…');
            }
        }
        drawing.text(&title, [self.corner[0] as f32, baseline], title_size, Weight::Bold, Anchor::Left);
        drawing.text(clock, [right, baseline], size, Weight::Regular, Anchor::Right);
    }

    fn axes(&self, drawing: &mut Drawing, view: &View) {
        let [x, y] = self.corner;
        let [width, height] = self.size;
        let (stroke, text) = (self.stroke(), self.text);
        drawing.outline(self.corner, self.size, stroke);
        let tick = (0.35 * text).round() as i64;

        let found = ticks(view.low[0], view.high[0], ((width as f32 / (5.0 * text)) as usize).max(2));
        let baseline = (y + height + tick) as f32 + 1.25 * text;
        let mut end = x as f32;
        for (value, label) in found.iter().zip(labels(&found, true).0) {
            let at = x + (width as f64 * (value - view.low[0]) / view.extent()[0]).round() as i64;
            drawing.fill([at, y + height], [stroke, tick + stroke], INK);
            drawing.text(&label, [at as f32, baseline], text, Weight::Regular, Anchor::Middle);
            end = at as f32 + 0.5 * text_width(&label, text, Weight::Regular);
        }
        let name = format!("{} [m]", view.axis_name(0));
        let wide = text_width(&name, text, Weight::Regular);
        // At the right end of the axis, or one line lower if the last label is there.
        let right = (x + width) as f32;
        let lower = if end + 0.5 * text > right - wide { 1.2 * text } else { 0.0 };
        drawing.text(&name, [right, baseline + lower], text, Weight::Regular, Anchor::Right);

        let found = ticks(view.low[1], view.high[1], ((height as f32 / (2.2 * text)) as usize).max(2));
        for (value, label) in found.iter().zip(labels(&found, true).0) {
            let at = y + (height as f64 * (view.high[1] - value) / view.extent()[1]).round() as i64;
            drawing.fill([x - tick - stroke, at], [tick + stroke, stroke], INK);
            let place = [(x - tick) as f32 - 0.4 * text, at as f32 + 0.36 * text];
            drawing.text(&label, place, text, Weight::Regular, Anchor::Right);
        }
        let name = format!("{} [m]", view.axis_name(1));
        let place = [(x - tick) as f32 - 0.4 * text, y as f32 - 0.75 * text];
        drawing.text(&name, place, text, Weight::Regular, Anchor::Right);
    }

    fn scale(
        &self,
        drawing: &mut Drawing,
        field: Field,
        dimensions: usize,
        colours: Colours,
        range: (f64, f64),
    ) {
        let [x, y] = self.corner;
        let [width, height] = self.size;
        let (stroke, text) = (self.stroke(), self.text);
        let tick = (0.3 * text).round() as i64;
        let breadth = (0.8 * text).round() as i64;
        let label_of = |power| {
            let unit = with_power(field.unit(), power);
            let name = match (field, dimensions) {
                (Field::Vorticity, 2) => "vorticity",
                (Field::Vorticity, _) => "vorticity |ω|",
                (other, _) => other.name(),
            };
            if unit.is_empty() { name.to_owned() } else { format!("{name} [{unit}]") }
        };
        let share = |value: f64| (value - range.0) / (range.1 - range.0);
        if self.upright {
            let corner = [x + width + (1.6 * text).round() as i64, y];
            let shade =
                |row: i64| [colours.at(1.0 - (row as f64 + 0.5) / height as f64)].repeat(breadth as usize);
            let pixels = (0..height).flat_map(shade).collect();
            drawing.image(corner, [breadth, height].map(|length| length as usize), pixels);
            drawing.outline(corner, [breadth, height], stroke);
            let found = ticks(range.0, range.1, ((height as f32 / (2.5 * text)) as usize).clamp(2, 11));
            let (written, power) = labels(&found, false);
            for (value, label) in found.iter().zip(written) {
                let at = y + (height as f64 * (1.0 - share(*value))).round() as i64;
                drawing.fill([corner[0] + breadth, at], [tick + stroke, stroke], INK);
                let place = [(corner[0] + breadth + tick) as f32 + 0.4 * text, at as f32 + 0.36 * text];
                drawing.text(&label, place, text, Weight::Regular, Anchor::Left);
            }
            let right = self.width as f32 - 0.5 * text;
            drawing.text(
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
        let shade = |column: i64| colours.at((column as f64 + 0.5) / length as f64);
        let row: Vec<Colour> = (0..length).map(shade).collect();
        let size = [length, breadth].map(|length| length as usize);
        drawing.image(corner, size, row.repeat(breadth as usize));
        drawing.outline(corner, [length, breadth], stroke);
        let found = ticks(range.0, range.1, ((length as f32 / (4.2 * text)) as usize).clamp(2, 11));
        let (written, power) = labels(&found, false);
        for (value, label) in found.iter().zip(written) {
            let at = corner[0] + (length as f64 * share(*value)).round() as i64;
            drawing.fill([at, corner[1] + breadth], [stroke, tick + stroke], INK);
            let place = [at as f32, (corner[1] + breadth + tick) as f32 + 1.2 * text];
            drawing.text(&label, place, text, Weight::Regular, Anchor::Middle);
        }
        let place = [corner[0] as f32 - 0.8 * text, corner[1] as f32 + 0.75 * text];
        drawing.text(&label_of(power), place, text, Weight::Regular, Anchor::Right);
    }

    /// Draws the arrow of a round speed beside the colour scale, with its speed in m/s, if the
    /// arrow of the largest speed has a length in pixels.
    pub(super) fn arrow_key(&self, drawing: &mut Drawing, largest_speed: f64, length: f64) {
        let Some(&speed) = ticks(0.0, largest_speed, 4).last().filter(|speed| **speed > 0.0) else { return };
        let text = self.text;
        let shaft = (length * speed / largest_speed) as f32;
        let label = format!("{} m/s", significant(speed));
        let right = if self.upright {
            self.width as f32 - 0.5 * text
        } else {
            (self.corner[0] + self.size[0]) as f32
        };
        let lines = if self.upright { 1.6 } else { 4.1 };
        let baseline = (self.corner[1] + self.size[1]) as f32 + lines * text;
        drawing.text(&label, [right, baseline], text, Weight::Regular, Anchor::Right);
        let tip = f64::from(right - text_width(&label, text, Weight::Regular) - 0.5 * text);
        let (tail, y) = (tip - f64::from(shaft), f64::from(baseline - 0.36 * text));
        let size = (0.4 * f64::from(shaft)).min(0.6 * f64::from(text));
        drawing.line([tail, y], [tip - 0.6 * size, y], f64::from(text) / 14.0, INK);
        drawing.area(head([tip, y], [1.0, 0.0], size), INK);
    }

    /// Draws the axes of space in the lower left corner of a picture in space: directions to the
    /// right and upwards.
    pub(super) fn triad(&self, drawing: &mut Drawing, axes: [[f64; 2]; 3]) {
        let text = f64::from(self.text);
        let corner = [self.corner[0] as f64, (self.corner[1] + self.size[1]) as f64];
        let origin = [corner[0] - 1.6 * text, corner[1] - 1.2 * text];
        for (name, [right, up]) in ["x", "y", "z"].into_iter().zip(axes) {
            let along = [2.6 * text * right, -2.6 * text * up];
            let tip = [origin[0] + along[0], origin[1] + along[1]];
            drawing.line(origin, tip, text / 14.0, INK);
            if along[0].hypot(along[1]) > 0.6 * text {
                drawing.area(head(tip, along, 0.5 * text), INK);
            }
            let place = [0, 1].map(|k| (origin[k] + 1.3 * along[k]) as f32);
            let at = [place[0], place[1] + 0.36 * self.text];
            drawing.text(name, at, self.text, Weight::Regular, Anchor::Middle);
        }
    }

    fn legend(&self, drawing: &mut Drawing) {
        let text = self.text;
        let side = (0.8 * text).round() as i64;
        let zones = [Zone::Fluid, Zone::Inflow, Zone::Outflow, Zone::Wall];
        let [mut x, mut y] = if self.upright {
            [self.corner[0] + self.size[0] + (1.6 * text) as i64, self.corner[1]]
        } else {
            [self.corner[0] + self.size[0] / 4, self.corner[1] + self.size[1] + (3.6 * text) as i64]
        };
        for zone in zones {
            drawing.fill([x, y], [side, side], zone_colour(zone as u8));
            drawing.outline([x, y], [side, side], self.stroke());
            let place = [(x + side) as f32 + 0.5 * text, y as f32 + 0.75 * text];
            drawing.text(zone.name(), place, text, Weight::Regular, Anchor::Left);
            if self.upright {
                y += (1.8 * text) as i64;
            } else {
                let wide = text_width(zone.name(), text, Weight::Regular);
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
