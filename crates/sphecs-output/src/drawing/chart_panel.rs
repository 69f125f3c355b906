//! Panel of a plot: axes, grid lines, curves and legend.

use super::chart::{Curve, Palette, Panel};
use super::ticks::{labels, ticks, with_power};
use super::{Anchor, Colour, Drawing, INK, PAPER, Pen, Weight, text_width};

/// Colour of grid lines.
const GRID: Colour = [0xe4, 0xe6, 0xe9];

/// Colour of a reference.
const REFERENCE: Colour = [0; 3];

/// Label of the references.
const REFERENCE_LABEL: &str = "reference";

/// Lengths of dash and gap of a reference, text heights.
const DASH: [f64; 2] = [0.4, 0.5];

/// Place of a panel in pixels, and the values at its edges.
pub(super) struct Area {
    /// Upper left corner.
    pub(super) corner: [i64; 2],
    /// Width and height.
    pub(super) size: [i64; 2],
    /// Values at the left and right edge.
    pub(super) across: (f64, f64),
    /// Values at the lower and upper edge.
    pub(super) upward: (f64, f64),
    /// Line height of the text, pixels.
    pub(super) text: f32,
}

impl Area {
    fn place(&self, (x, y): (f64, f64)) -> [f64; 2] {
        let share = |value: f64, (low, high): (f64, f64)| (value - low) / (high - low);
        [
            self.corner[0] as f64 + self.size[0] as f64 * share(x, self.across),
            self.corner[1] as f64 + self.size[1] as f64 * (1.0 - share(y, self.upward)),
        ]
    }

    fn thin(&self) -> f64 {
        (f64::from(self.text) / 14.0).max(1.0)
    }

    /// Returns the unbroken lines of a curve with the points that the panel can resolve: first,
    /// smallest, largest and last of each pixel column.
    fn lines(&self, points: &[(f64, f64)]) -> Vec<Vec<[f64; 2]>> {
        let is_known = |point: &(f64, f64)| point.0.is_finite() && point.1.is_finite();
        let parts = points.chunk_by(|a, b| is_known(a) && is_known(b));
        let parts = parts.filter(|part| is_known(&part[0]));
        let parts = parts.map(|part| part.iter().map(|&point| self.place(point)).collect::<Vec<_>>());
        parts.map(|part| thinned(&part)).collect()
    }
}

/// Returns the points of a line that pixels can resolve.
fn thinned(points: &[[f64; 2]]) -> Vec<[f64; 2]> {
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| a[0].floor() == b[0].floor()) {
        let by = |a: &usize, b: &usize| group[*a][1].total_cmp(&group[*b][1]);
        let peaks = [(0..group.len()).min_by(by), (0..group.len()).max_by(by)];
        let mut at: Vec<usize> =
            [0, group.len() - 1].into_iter().chain(peaks.into_iter().flatten()).collect();
        at.sort_unstable();
        at.dedup();
        kept.extend(at.into_iter().map(|at| group[at]));
    }
    kept
}

/// Draws a panel, with the labels of its horizontal axis if that has a name here.
pub(super) fn draw_panel(
    drawing: &mut Drawing,
    panel: &Panel,
    area: &Area,
    across: Option<&str>,
    palette: &Palette,
) {
    horizontal_axis(drawing, area, across);
    vertical_axis(drawing, panel, area);
    drawing.outline(area.corner, area.size, area.thin() as i64);
    let mut drawn = Vec::new();
    for curve in &panel.curves {
        let (colour, dash) = palette.style(&curve.label);
        let width = 1.9 * area.thin();
        let pen = Pen { width, colour, dash: dash.map(|dash| dash.map(|length| length * width)) };
        for line in area.lines(&curve.points) {
            drawing.curve(line.clone(), pen);
            drawn.push(line);
        }
    }
    // References are drawn on top, so that the dashes show where both agree.
    let dash = Some(DASH.map(|length| length * f64::from(area.text)));
    let pen = Pen { width: area.thin(), colour: REFERENCE, dash };
    for line in panel.curves.iter().flat_map(|curve| area.lines(&curve.reference)) {
        drawing.curve(line.clone(), pen);
        drawn.push(line);
    }
    legend(drawing, &panel.curves, area, palette, &drawn);
}

fn horizontal_axis(drawing: &mut Drawing, area: &Area, name: Option<&str>) {
    let ([x, y], [width, height], text) = (area.corner, area.size, area.text);
    let thin = area.thin() as i64;
    let tick = (0.3 * text).round() as i64;
    let found = ticks(area.across.0, area.across.1, ((width as f32 / (5.0 * text)) as usize).clamp(2, 11));
    let (written, power) = labels(&found, false);
    let baseline = (y + height + tick) as f32 + 1.25 * text;
    for (&value, label) in found.iter().zip(written) {
        let at = area.place((value, area.upward.0))[0].round() as i64;
        drawing.fill([at, y], [thin, height], GRID);
        drawing.fill([at, y + height], [thin, tick + thin], INK);
        if name.is_some() {
            drawing.text(&label, [at as f32, baseline], text, Weight::Regular, Anchor::Middle);
        }
    }
    if let Some(name) = name {
        let middle = [(x + width / 2) as f32, baseline + 1.5 * text];
        drawing.text(&scaled(name, power), middle, text, Weight::Regular, Anchor::Middle);
    }
}

fn vertical_axis(drawing: &mut Drawing, panel: &Panel, area: &Area) {
    let ([x, y], [width, height], text) = (area.corner, area.size, area.text);
    let thin = area.thin() as i64;
    let tick = (0.3 * text).round() as i64;
    let (found, written, power) = panel.ticks(area.upward, height, text);
    for (value, label) in found.into_iter().zip(written) {
        let at = area.place((area.across.0, value))[1].round() as i64;
        drawing.fill([x, at], [width, thin], GRID);
        drawing.fill([x - tick - thin, at], [tick + thin, thin], INK);
        let place = [(x - tick) as f32 - 0.4 * text, at as f32 + 0.36 * text];
        drawing.text(&label, place, text, Weight::Regular, Anchor::Right);
    }
    let place = [x as f32, y as f32 - 0.55 * text];
    drawing.text(&scaled(&panel.upward, power), place, text, Weight::Regular, Anchor::Left);
}

/// Returns the name of an axis with the power of ten of its labels: `u [10⁻³ m/s]`.
fn scaled(name: &str, power: i32) -> String {
    match name.rsplit_once(" [") {
        _ if power == 0 => name.to_owned(),
        Some((quantity, unit)) if unit.ends_with(']') => {
            format!("{quantity} [{}]", with_power(unit.trim_end_matches(']'), power))
        }
        _ => format!("{name} [{}]", with_power("", power)),
    }
}

/// Draws the legend in the corner where it covers the least of the curves.
fn legend(drawing: &mut Drawing, curves: &[Curve], area: &Area, palette: &Palette, drawn: &[Vec<[f64; 2]>]) {
    let mut labels: Vec<&str> = Vec::new();
    for curve in curves.iter().filter(|curve| !curve.label.is_empty()) {
        if !labels.contains(&curve.label.as_str()) {
            labels.push(&curve.label);
        }
    }
    if curves.iter().any(|curve| !curve.reference.is_empty()) {
        labels.push(REFERENCE_LABEL);
    }
    if labels.is_empty() {
        return;
    }
    let text = f64::from(area.text);
    let (line, key, pad) = (1.35 * text, 1.8 * text, 0.5 * text);
    let widths = labels.iter().map(|label| f64::from(text_width(label, area.text, Weight::Regular)));
    let size = [widths.fold(0.0, f64::max) + key + 3.0 * pad, line * labels.len() as f64 + pad];
    let corner = emptiest_corner(area, size, 0.6 * text, drawn);
    let whole = |values: [f64; 2]| values.map(|value| value.round() as i64);
    drawing.fill(whole(corner), whole(size), PAPER);
    for (row, label) in labels.into_iter().enumerate() {
        let y = corner[1] + 0.5 * pad + line * (row as f64 + 0.5);
        let is_reference = row > 0 && label == REFERENCE_LABEL;
        let (colour, dash) = if is_reference { (REFERENCE, None) } else { palette.style(label) };
        let width = if is_reference { area.thin() } else { 1.9 * area.thin() };
        let dash = match is_reference {
            true => Some(DASH.map(|length| length * text)),
            false => dash.map(|dash| dash.map(|length| length * width)),
        };
        let left = corner[0] + pad;
        drawing.curve(vec![[left, y], [left + key, y]], Pen { width, colour, dash });
        let at = [(left + key + pad) as f32, (y + 0.36 * text) as f32];
        drawing.text(label, at, area.text, Weight::Regular, Anchor::Left);
    }
}

/// Returns the upper left corner of a legend where it covers the shortest part of the lines.
fn emptiest_corner(area: &Area, size: [f64; 2], gap: f64, lines: &[Vec<[f64; 2]>]) -> [f64; 2] {
    let [x, y] = area.corner.map(|coordinate| coordinate as f64);
    let [left, top] = [x + gap, y + gap];
    let right = (x + area.size[0] as f64 - size[0] - gap).max(left);
    let bottom = (y + area.size[1] as f64 - size[1] - gap).max(top);
    let covered = |[left, top]: [f64; 2]| {
        let inside = |point: &[f64; 2]| {
            (left..=left + size[0]).contains(&point[0]) && (top..=top + size[1]).contains(&point[1])
        };
        let points = lines.iter().flat_map(|line| line.windows(2)).flat_map(|pair| {
            let steps = ((pair[1][0] - pair[0][0]).hypot(pair[1][1] - pair[0][1]) / 2.0).ceil().max(1.0);
            (0..steps as usize).map(move |step| {
                let share = step as f64 / steps;
                [0, 1].map(|axis| pair[0][axis] + share * (pair[1][axis] - pair[0][axis]))
            })
        });
        points.filter(inside).count()
    };
    let corners = [[right, top], [left, top], [right, bottom], [left, bottom]];
    corners.into_iter().min_by_key(|&corner| covered(corner)).unwrap_or([right, top])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area() -> Area {
        let (corner, size) = ([0, 0], [1000, 500]);
        Area { corner, size, across: (0.0, 1.0), upward: (0.0, 1.0), text: 20.0 }
    }

    #[test]
    fn long_curve_keeps_its_ends_and_peaks() {
        let wave = |step: u32| [f64::from(step) * 1e-2, 250.0 * (1.0 + (f64::from(step) * 0.7).sin())];
        let mut points: Vec<[f64; 2]> = (0..100_000).map(wave).collect();
        points[54_321][1] = 900.0;
        let kept = thinned(&points);
        assert!(kept.len() <= 4 * 1001, "{} points", kept.len());
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.contains(&points[54_321]) && kept.is_sorted_by(|a, b| a[0] <= b[0]));
        assert!(thinned(&[]).is_empty());
    }

    #[test]
    fn missing_value_interrupts_a_curve() {
        let lines = area().lines(&[(0.0, 0.5), (0.1, 0.5), (0.2, f64::NAN), (0.3, 0.5), (0.4, 0.5)]);
        assert_eq!(lines, [vec![[0.0, 250.0], [100.0, 250.0]], vec![[300.0, 250.0], [400.0, 250.0]]]);
    }

    #[test]
    fn legend_avoids_the_curves() {
        let rising = area().lines(&[(0.0, 0.0), (1.0, 1.0)]);
        let corner = emptiest_corner(&area(), [200.0, 100.0], 10.0, &rising);
        assert_eq!(corner, [10.0, 10.0], "the upper left one");
    }

    #[test]
    fn power_of_ten_is_in_the_brackets() {
        assert_eq!(scaled("u [m/s]", -3), "u [10⁻³ m/s]");
        assert_eq!(scaled("u/u0", 4), "u/u0 [10⁴]");
        assert_eq!(scaled("u [m/s]", 0), "u [m/s]");
    }
}
