//! Plots of a case as SVG.

use std::path::Path;

use super::measures::profile::{distance_over_time, profiles};
use super::measures::reference::{self, coordinate};
use super::measures::{Context, FORCES, MONITOR, series};
use super::schema::{CurveFile, PlotFile};
use sphecs_output::drawing::chart::{Chart, Curve, Panel, WIDTH};

/// Draws the curves of a plot whose runs have results to an SVG file.
///
/// # Errors
/// Missing results, or the reason why the file cannot be written.
pub fn draw(plot: &PlotFile, context: Context<'_>, path: &Path) -> Result<(), String> {
    let present = plot.curves.iter().filter(|curve| context.runs.contains_key(&curve.run().value));
    let curves = present.map(|curve| gather(curve, context)).collect::<Result<Vec<_>, _>>()?;
    let panel = Panel { upward: plot.upward.clone(), is_logarithmic: plot.logarithmic, curves };
    let chart = Chart { title: plot.title.clone(), across: plot.across.clone(), panels: vec![panel] };
    chart.draw(WIDTH).save(path).map_err(|error| error.to_string())
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
            let points: Vec<(f64, f64)> = points.filter(shown).collect();
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
