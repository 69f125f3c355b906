//! Plots of a case as SVG.

use std::path::Path;

use plotters::backend::SVGBackend;
use plotters::chart::{ChartBuilder, SeriesLabelPosition};
use plotters::drawing::IntoDrawingArea;
use plotters::element::PathElement;
use plotters::series::{DashedLineSeries, LineSeries};
use plotters::style::{BLACK, Color, RGBColor, WHITE};

use super::measures::profile::{distance_over_time, profiles};
use super::measures::reference::{self, coordinate};
use super::measures::{Context, FORCES, MONITOR, series};
use super::schema::{CurveFile, PlotFile};
use sphecs_core::format::significant;

/// Size, points: twice the display size, since coordinates are whole points.
const SIZE: (u32, u32) = (1440, 960);
/// Font size, points.
const FONT_SIZE: u32 = 26;
/// Colours of the curves in turn, distinguishable to colour-blind readers (Okabe and Ito).
const COLOURS: [RGBColor; 7] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
    RGBColor(0, 0, 0),
];
/// Lengths of dash and gap, points.
const DASH: (i32, i32) = (10, 14);
/// Length of a line in the legend, points.
const KEY: i32 = 40;

/// Curve with its points.
struct Curve {
    label: String,
    points: Vec<(f64, f64)>,
    /// Points of the reference.
    reference: Vec<(f64, f64)>,
}

/// Draws the curves of a plot whose runs have results to an SVG file.
///
/// # Errors
/// Missing results, or the reason why the file cannot be written.
pub fn draw(plot: &PlotFile, context: Context<'_>, path: &Path) -> Result<(), String> {
    let present = plot.curves.iter().filter(|curve| context.runs.contains_key(&curve.run().value));
    let mut curves = present.map(|curve| gather(curve, context)).collect::<Result<Vec<_>, _>>()?;
    if plot.logarithmic {
        // A magnitude of zero has no logarithm.
        for curve in &mut curves {
            for points in [&mut curve.points, &mut curve.reference] {
                points.iter_mut().for_each(|point| point.1 = point.1.abs().log10());
                points.retain(|point| point.1.is_finite());
            }
        }
    }
    render(plot, &curves, path).map_err(|error| format!("{}: {error}", path.display()))
}

fn gather(curve: &CurveFile, context: Context<'_>) -> Result<Curve, String> {
    match curve {
        CurveFile::Profile { run, probe, field, when, axis, upright, reference, label } => {
            let probe = context.run(&run.value)?.probe(&probe.value)?;
            let found = profiles(&probe, field, &when.value)?;
            let profile = found.first().ok_or("no samples")?;
            let along = probe.places.iter().map(|&place| coordinate(place, *axis));
            let oriented = |(at, value): (f64, f64)| match upright {
                Some((station, scale)) => (station.value + scale.value * value, at),
                None => (at, value),
            };
            let points = along.clone().zip(profile.values.iter().copied()).map(oriented).collect();
            let function = match reference {
                Some(reference) => reference::function(reference, context.case)?,
                None => None,
            };
            let line = function.map_or_else(Vec::new, |function| {
                let values = probe.places.iter().map(|&place| function(place, profile.time));
                along.zip(values).map(oriented).collect()
            });
            Ok(Curve { label: label.clone(), points, reference: line })
        }
        CurveFile::Series { run, table, column, over, reference, label } => {
            let run = context.run(&run.value)?;
            let (times, values) = series::column(run, &table.value, &column.value)?;
            let (from, to) =
                over.as_ref().map_or((f64::NEG_INFINITY, f64::INFINITY), |(from, to)| (from.value, to.value));
            let points = times.into_iter().zip(values);
            let shown = |point: &(f64, f64)| point.1.is_finite() && point.0 >= from && point.0 <= to;
            let points = thinned(&points.filter(shown).collect::<Vec<_>>());
            let function = match reference {
                Some(reference) => reference::function(reference, context.case)?,
                None => None,
            };
            let line = match function {
                Some(function) => {
                    let has_place = !matches!(table.value.as_str(), MONITOR | FORCES);
                    let places = if has_place { run.probe(&table.value)?.places.clone() } else { Vec::new() };
                    let place = places.first().copied().unwrap_or_default();
                    points.iter().map(|&(time, _)| (time, function(place, time))).collect()
                }
                None => Vec::new(),
            };
            Ok(Curve { label: label.clone(), points, reference: line })
        }
        CurveFile::Distance { run, probe, field, reference, norm, scale, label } => {
            let probe = context.run(&run.value)?.probe(&probe.value)?;
            let function = reference::function(reference, context.case)?.ok_or("no reference")?;
            let scale = scale.map_or(1.0, |scale| scale.value);
            let found = distance_over_time(&probe, field, &function, *norm)?;
            let points = found.into_iter().map(|(time, value)| (time, value / scale));
            let points = points.filter(|point| point.1.is_finite()).collect();
            Ok(Curve { label: label.clone(), points, reference: Vec::new() })
        }
    }
}

/// Returns the points of a curve that a plot can resolve: first, smallest, largest and last of each
/// pixel column.
fn thinned(points: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    let column = |point: &(f64, f64)| {
        (f64::from(SIZE.0) * (point.0 - first.0) / (last.0 - first.0).max(1e-300)).floor()
    };
    let mut kept = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by = |a: &usize, b: &usize| group[*a].1.total_cmp(&group[*b].1);
        let ends = [0, group.len() - 1];
        let peaks = [(0..group.len()).min_by(by), (0..group.len()).max_by(by)];
        let mut at: Vec<usize> = ends.into_iter().chain(peaks.into_iter().flatten()).collect();
        at.sort_unstable();
        at.dedup();
        kept.extend(at.into_iter().map(|at| group[at]));
    }
    kept
}

/// Returns the range of one coordinate of all curves, with a margin.
fn range(curves: &[Curve], of: fn(&(f64, f64)) -> f64, margin: f64) -> std::ops::Range<f64> {
    let all = || curves.iter().flat_map(|curve| curve.points.iter().chain(&curve.reference)).map(of);
    let (low, high) = (all().fold(f64::INFINITY, f64::min), all().fold(f64::NEG_INFINITY, f64::max));
    if low > high {
        return 0.0..1.0;
    }
    let padding = margin * if high > low { high - low } else { high.abs().max(1e-300) };
    low - padding..high + padding
}

fn render(plot: &PlotFile, curves: &[Curve], path: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let root = SVGBackend::new(path, SIZE).into_drawing_area();
    root.fill(&WHITE)?;
    let (across, upward) = (range(curves, |point| point.0, 0.0), range(curves, |point| point.1, 0.05));
    let corner = emptiest_corner(curves, &across, &upward);
    let logarithmic = plot.logarithmic;
    // The grid line at zero may be a rounding error.
    let spans = [across.end - across.start, upward.end - upward.start];
    let plain = move |value: f64, axis: usize| {
        significant(if value.abs() < 1e-9 * spans[axis] { 0.0 } else { value })
    };
    let label = |value: &f64| {
        if logarithmic { format!("{:.1e}", 10_f64.powf(*value)) } else { plain(*value, 1) }
    };
    let mut chart = ChartBuilder::on(&root)
        .caption(&plot.title, ("sans-serif", FONT_SIZE + 8))
        .margin(24)
        .margin_right(60)
        .x_label_area_size(88)
        .y_label_area_size(150)
        .build_cartesian_2d(across, upward)?;
    chart
        .configure_mesh()
        .x_desc(&plot.across)
        .y_desc(&plot.upward)
        .label_style(("sans-serif", FONT_SIZE))
        .x_labels(8)
        .x_label_formatter(&|value| plain(*value, 0))
        .y_label_formatter(&label)
        .light_line_style(WHITE.mix(0.0))
        .draw()?;
    // Curves with equal labels have one colour and one line in the legend.
    let mut labels: Vec<&str> = Vec::new();
    for curve in curves {
        let known = labels.iter().position(|label| *label == curve.label);
        let style = COLOURS[known.unwrap_or(labels.len()) % COLOURS.len()].stroke_width(4);
        let drawn = chart.draw_series(LineSeries::new(curve.points.iter().copied(), style))?;
        if known.is_none() {
            labels.push(&curve.label);
            drawn.label(&curve.label).legend(move |(x, y)| PathElement::new([(x, y), (x + KEY, y)], style));
        }
    }
    // The reference is drawn on top, so that the dashes show where both agree.
    let style = BLACK.stroke_width(2);
    for (number, curve) in curves.iter().filter(|curve| !curve.reference.is_empty()).enumerate() {
        let dashed = DashedLineSeries::new(curve.reference.iter().copied(), DASH.0, DASH.1, style);
        let drawn = chart.draw_series(dashed)?;
        if number == 0 {
            drawn.label("reference").legend(move |(x, y)| PathElement::new([(x, y), (x + KEY, y)], style));
        }
    }
    chart
        .configure_series_labels()
        .position(corner)
        .label_font(("sans-serif", FONT_SIZE))
        .legend_area_size(KEY + 14)
        .margin(20)
        .background_style(WHITE.mix(0.85))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    root.present()?;
    Ok(())
}

/// Returns the corner of the plot with the fewest points of curves, for the legend.
fn emptiest_corner(
    curves: &[Curve],
    across: &std::ops::Range<f64>,
    upward: &std::ops::Range<f64>,
) -> SeriesLabelPosition {
    let corners = [
        (true, true, SeriesLabelPosition::UpperRight),
        (false, true, SeriesLabelPosition::UpperLeft),
        (true, false, SeriesLabelPosition::LowerRight),
        (false, false, SeriesLabelPosition::LowerLeft),
    ];
    let share = |value: f64, range: &std::ops::Range<f64>| (value - range.start) / (range.end - range.start);
    let points_in = |right: bool, upper: bool| {
        let near = |share: f64, high: bool| if high { share > 0.6 } else { share < 0.4 };
        let all = curves.iter().flat_map(|curve| curve.points.iter().chain(&curve.reference));
        all.filter(|point| near(share(point.0, across), right) && near(share(point.1, upward), upper)).count()
    };
    let least = corners.into_iter().min_by_key(|&(right, upper, _)| points_in(right, upper));
    least.map_or(SeriesLabelPosition::UpperRight, |(_, _, corner)| corner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn long_series_keeps_its_ends_and_peaks() {
        let wave = |step: u32| (f64::from(step) * 1e-3, (f64::from(step) * 0.7).sin());
        let mut points: Vec<(f64, f64)> = (0..100_000).map(wave).collect();
        points[54_321].1 = 3.0;
        let kept = thinned(&points);
        assert!(kept.len() <= 4 * 1441, "{} points", kept.len());
        assert_eq!((kept.first(), kept.last()), (points.first(), points.last()));
        assert!(kept.contains(&points[54_321]));
        assert!(kept.is_sorted_by(|a, b| a.0 < b.0));
        assert_eq!(thinned(&points[..9]), points[..9]);
        assert!(thinned(&[]).is_empty());
    }

    #[test]
    fn ranges_contain_all_points_and_are_never_empty() {
        let curve = |points: &[(f64, f64)]| Curve {
            label: String::new(),
            points: points.to_vec(),
            reference: vec![(5.0, -1.0)],
        };
        assert_eq!(range(&[curve(&[(1.0, 2.0), (3.0, 0.0)])], |point| point.0, 0.0), 1.0..5.0);
        assert_eq!(range(&[], |point| point.1, 0.0), 0.0..1.0);
        let rising = curve(&[(0.0, 0.0), (1.0, 1.0), (2.0, 2.0)]);
        assert!(matches!(
            emptiest_corner(&[rising], &(0.0..2.0), &(0.0..2.0)),
            SeriesLabelPosition::UpperLeft
        ));
        let flat = range(&[curve(&[(1.0, -1.0)])], |point| point.1, 0.05);
        assert!(flat.start < -1.0 && flat.end > -1.0);
    }
}
