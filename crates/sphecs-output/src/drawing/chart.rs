//! Plot of curves in panels one below the other, which have the horizontal axis in common.
//!
//! Curves with equal labels have one colour and one line in the legend.

use super::chart_panel::{Area, draw_panel};
use super::ticks::{labels, ticks};
use super::{Anchor, Colour, Drawing, Weight, text_width};

/// Default width of a plot, pixels.
pub const WIDTH: u32 = 1440;

/// Colours of the curves in turn, distinguishable to colour-blind readers (Okabe and Ito).
const COLOURS: [Colour; 7] = [
    [0, 114, 178],
    [213, 94, 0],
    [0, 158, 115],
    [204, 121, 167],
    [230, 159, 0],
    [86, 180, 233],
    [0x22, 0x26, 0x2b],
];

/// Lengths of dash and gap of the curves after the seventh, in widths of the line.
const DASHES: [Option<[f64; 2]>; 3] = [None, Some([4.0, 2.0]), Some([1.5, 1.5])];

/// Curve with its points.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Curve {
    /// Text in the legend; empty for none.
    pub label: String,
    /// Points; one that is not finite interrupts the curve.
    pub points: Vec<(f64, f64)>,
    /// Points of the reference with which it is compared.
    pub reference: Vec<(f64, f64)>,
}

/// Curves with a vertical axis.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Panel {
    /// Quantity with its unit, as `u [m/s]`.
    pub upward: String,
    /// True for the magnitudes on a logarithmic axis.
    pub is_logarithmic: bool,
    /// Curves.
    pub curves: Vec<Curve>,
}

/// A plot.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Chart {
    /// Title.
    pub title: String,
    /// Quantity of the horizontal axis with its unit, as `time [s]`.
    pub across: String,
    /// Panels from the top.
    pub panels: Vec<Panel>,
}

/// Labels of all curves in the order of their colours.
pub(super) struct Palette(Vec<String>);

impl Palette {
    /// Returns colour and dash of a label.
    pub(super) fn style(&self, label: &str) -> (Colour, Option<[f64; 2]>) {
        let index = self.0.iter().position(|known| known == label).unwrap_or_default();
        (COLOURS[index % COLOURS.len()], DASHES[index / COLOURS.len() % DASHES.len()])
    }
}

impl Chart {
    /// Draws the plot, `width` pixels wide.
    pub fn draw(&self, width: u32) -> Drawing {
        let panels: Vec<Panel> = self.panels.iter().map(Panel::on_its_axis).collect();
        let text = (width as f32 / 55.0).max(11.0);
        let unit = f64::from(text);
        let rows = panels.len().max(1);
        let share = if rows == 1 { 0.52 } else { 0.3 };
        let high = (share * f64::from(width)).round() as i64;
        let lines_above = if self.title.is_empty() { 2.2 } else { 4.4 };
        let (top, gap, below) = (lines_above * unit, 3.0 * unit, 4.4 * unit);
        let height = top + rows as f64 * high as f64 + (rows as f64 - 1.0) * gap + below;

        let mut drawing = Drawing::new(width, height.round() as u32);
        let across = range(panels.iter().flat_map(Panel::points).map(|point| point.0), 0.0);
        let upward: Vec<(f64, f64)> =
            panels.iter().map(|panel| range(panel.points().map(|point| point.1), 0.05)).collect();
        let widest = panels.iter().zip(&upward).map(|(panel, &range)| panel.widest_label(range, high, text));
        let left = f64::from(widest.fold(2.0 * text, f32::max)) + 1.6 * unit;
        let wide = (f64::from(width) - left - 2.2 * unit).max(1.0).round() as i64;
        let palette = self.palette();
        heading(&mut drawing, &self.title, left as f32, text);
        for (row, (panel, &upward)) in panels.iter().zip(&upward).enumerate() {
            let y = (top + row as f64 * (high as f64 + gap)).round() as i64;
            let area = Area { corner: [left.round() as i64, y], size: [wide, high], across, upward, text };
            let name = (row + 1 == rows).then_some(self.across.as_str());
            draw_panel(&mut drawing, panel, &area, name, &palette);
        }
        drawing
    }

    fn palette(&self) -> Palette {
        let mut labels: Vec<String> = Vec::new();
        for curve in self.panels.iter().flat_map(|panel| &panel.curves) {
            if !labels.contains(&curve.label) {
                labels.push(curve.label.clone());
            }
        }
        Palette(labels)
    }
}

impl Panel {
    /// Returns the panel with the values at which its axis has them: logarithms, or the values.
    fn on_its_axis(&self) -> Panel {
        let mut panel = self.clone();
        if self.is_logarithmic {
            for curve in &mut panel.curves {
                for points in [&mut curve.points, &mut curve.reference] {
                    // A magnitude of zero has no logarithm, and interrupts the curve.
                    points.iter_mut().for_each(|point| point.1 = point.1.abs().log10());
                }
            }
        }
        panel
    }

    fn points(&self) -> impl Iterator<Item = (f64, f64)> + '_ {
        let all = self.curves.iter().flat_map(|curve| curve.points.iter().chain(&curve.reference));
        all.copied().filter(|point| point.0.is_finite() && point.1.is_finite())
    }

    /// Returns positions and labels of the vertical axis, and the power of ten of the labels.
    pub(super) fn ticks(&self, range: (f64, f64), high: i64, text: f32) -> (Vec<f64>, Vec<String>, i32) {
        let most = ((high as f32 / (2.4 * text)) as usize).clamp(2, 9);
        if self.is_logarithmic {
            return logarithmic_ticks(range, most);
        }
        let found = ticks(range.0, range.1, most);
        let (written, power) = labels(&found, false);
        (found, written, power)
    }

    fn widest_label(&self, range: (f64, f64), high: i64, text: f32) -> f32 {
        let (_, labels, _) = self.ticks(range, high, text);
        labels.iter().map(|label| text_width(label, text, Weight::Regular)).fold(0.0, f32::max)
    }
}

/// Returns the logarithms of round numbers in a range of logarithms, with their labels.
fn logarithmic_ticks((low, high): (f64, f64), most: usize) -> (Vec<f64>, Vec<String>, i32) {
    let decades: Vec<f64> = (low.ceil() as i64..=high.floor() as i64).map(|power| power as f64).collect();
    if decades.len() >= 2 {
        let stride = decades.len().div_ceil(most);
        let kept: Vec<f64> = decades.into_iter().step_by(stride).collect();
        let text = |power: &f64| super::ticks::with_power("", *power as i32);
        let labels = kept.iter().map(|power| if *power == 0.0 { "1".to_owned() } else { text(power) });
        let labels = labels.collect();
        return (kept, labels, 0);
    }
    let powers = low.floor() as i32..=high.ceil() as i32;
    let round = powers.flat_map(|power| [1.0, 2.0, 5.0].map(|digit| digit * 10_f64.powi(power)));
    let inside = round.filter(|value| (low..=high).contains(&value.log10()));
    let kept: Vec<f64> = inside.collect();
    let labels = kept.iter().map(|&value| sphecs_core::format::significant(value)).collect();
    (kept.into_iter().map(f64::log10).collect(), labels, 0)
}

/// Returns the range of values with a margin.
pub(super) fn range(values: impl Iterator<Item = f64>, margin: f64) -> (f64, f64) {
    let (low, high) = values
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), value| (low.min(value), high.max(value)));
    if low > high {
        return (0.0, 1.0);
    }
    let length = high - low;
    // A constant has no range of its own.
    if length <= 1e-9 * high.abs().max(low.abs()) {
        let pad = if high == 0.0 { 1.0 } else { 0.1 * high.abs() };
        return (low - pad, high + pad);
    }
    (low - margin * length, high + margin * length)
}

/// Writes the title, smaller if it is long.
fn heading(drawing: &mut Drawing, title: &str, left: f32, text: f32) {
    let available = drawing.size[0] as f32 - left - text;
    let natural = text_width(title, 1.15 * text, Weight::Bold);
    let size = 1.15 * text * (available / natural.max(1.0)).clamp(0.5, 1.0);
    drawing.text(title, [left, 1.9 * text], size, Weight::Bold, Anchor::Left);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranges_contain_all_points_and_are_never_empty() {
        assert_eq!(range([1.0, 3.0, 5.0].into_iter(), 0.0), (1.0, 5.0));
        assert_eq!(range([].into_iter(), 0.0), (0.0, 1.0));
        let flat = range([-1.0, -1.0].into_iter(), 0.05);
        assert!(flat.0 < -1.0 && flat.1 > -1.0);
    }

    #[test]
    fn logarithmic_axis_has_decades_or_round_numbers() {
        let (at, labels, _) = logarithmic_ticks((-3.2, 1.1), 9);
        assert_eq!(at, [-3.0, -2.0, -1.0, 0.0, 1.0]);
        assert_eq!(labels, ["10⁻³", "10⁻²", "10⁻¹", "1", "10¹"]);
        assert_eq!(logarithmic_ticks((-0.1, 0.8), 9).1, ["1", "2", "5"]);
    }

    #[test]
    fn curves_have_their_colours_and_equal_labels_share_one() {
        let curve = |label: &str, value: f64| Curve {
            label: label.to_owned(),
            points: (0..50).map(|k| (f64::from(k), value)).collect(),
            reference: Vec::new(),
        };
        let panel = |curves| Panel { upward: "u [m/s]".to_owned(), is_logarithmic: false, curves };
        let chart = Chart {
            title: "Two panels".to_owned(),
            across: "time [s]".to_owned(),
            panels: vec![panel(vec![curve("a", 1.0), curve("b", 2.0)]), panel(vec![curve("b", 3.0)])],
        };
        let pixels = chart.draw(600).pixels();
        let count = |colour: Colour| pixels.pixels().filter(|pixel| pixel.0 == colour).count();
        // A curve of a panel is about 500 pixels long; the colour of `b` is in both panels.
        assert!(count(COLOURS[0]) > 400 && count(COLOURS[1]) > 800, "{:?}", COLOURS.map(count));
        assert_eq!(COLOURS[2..6].iter().map(|&colour| count(colour)).sum::<usize>(), 0);
    }
}
