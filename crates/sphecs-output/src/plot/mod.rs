//! Plots of what a run measured: columns over time, and profiles of line probes.
//!
//! - `names`: results of a run by name, as `monitor.kinetic_energy` or `probes.gap.u`
//! - `curves`: their values over time or along a line
//! - `units`: units as people write them
//!
//! Results with different units are in panels of their own. Several runs are drawn in each panel.

mod curves;
mod names;
mod units;

use std::path::PathBuf;

use curves::{Abscissa, Measured};
use names::RunTables;

use crate::drawing::Drawing;
use crate::drawing::chart::{Chart, Curve, Panel, WIDTH};
use crate::error::OutputError;

/// Options of a plot.
#[derive(Clone, Debug, PartialEq)]
pub struct PlotOptions {
    /// Names of the results, as `monitor.kinetic_energy`, `forces.c_d_body` or `probes.gap.u`.
    pub names: Vec<String>,
    /// Times of profiles, s; empty for the last sample.
    pub times: Vec<f64>,
    /// Interval of the mean of profiles, s, in place of times.
    pub mean: Option<(f64, f64)>,
    /// Part of the time axis that is drawn, s.
    pub over: Option<(f64, f64)>,
    /// True for magnitudes on a logarithmic axis.
    pub is_logarithmic: bool,
    /// Width, pixels.
    pub width: u32,
}

impl Default for PlotOptions {
    fn default() -> Self {
        Self {
            names: Vec::new(),
            times: Vec::new(),
            mean: None,
            over: None,
            is_logarithmic: false,
            width: WIDTH,
        }
    }
}

/// Draws results of runs.
///
/// # Errors
/// [`OutputError`] when a folder is not a run, a run has no such result, or the options do not
/// match the results.
pub fn plot(runs: &[PathBuf], options: &PlotOptions) -> Result<Drawing, OutputError> {
    Ok(chart(runs, options)?.draw(options.width))
}

/// Returns the names of all results of a run, those of a table or a probe in a line.
///
/// # Errors
/// [`OutputError`] when a folder is not a run.
pub fn results_of(run: &std::path::Path) -> Result<String, OutputError> {
    Ok(RunTables::read(run)?.list())
}

fn chart(runs: &[PathBuf], options: &PlotOptions) -> Result<Chart, OutputError> {
    let tables = runs.iter().map(|run| RunTables::read(run)).collect::<Result<Vec<_>, _>>()?;
    let mut measured = Vec::new();
    for (run, tables) in tables.iter().enumerate() {
        for name in &options.names {
            let found = tables.find(name)?;
            measured.extend(curves::measured(&found, options)?.into_iter().map(|curve| (run, curve)));
        }
    }
    let across = abscissa(&measured)?;
    let labels = run_labels(&tables);
    let mut panels: Vec<(String, Vec<(usize, &Measured)>)> = Vec::new();
    for (run, curve) in &measured {
        match panels.iter_mut().find(|(unit, _)| *unit == curve.unit) {
            Some((_, curves)) => curves.push((*run, curve)),
            None => panels.push((curve.unit.clone(), vec![(*run, curve)])),
        }
    }
    let title = match tables.as_slice() {
        [only] => only.header.title.clone(),
        _ => String::new(),
    };
    let is_along_one_axis = across.starts_with(['x', 'y', 'z']);
    let panel = |(unit, curves): (String, Vec<(usize, &Measured)>)| {
        let upward = upward(&unit, &curves);
        let names = distinct(curves.iter().map(|(_, curve)| curve.name.as_str()));
        let curve = |&(run, curve): &(usize, &Measured)| {
            let mut parts = Vec::new();
            if labels.len() > 1 {
                parts.push(labels[run].clone());
            }
            if names.len() > 1 {
                parts.push(curve.name.clone());
            }
            parts.extend(curve.when.clone());
            Curve { label: parts.join(", "), points: curve.points(is_along_one_axis), reference: Vec::new() }
        };
        let curves = curves.iter().map(curve).collect();
        Panel { upward, is_logarithmic: options.is_logarithmic, curves }
    };
    Ok(Chart { title, across, panels: panels.into_iter().map(panel).collect() })
}

/// Returns the name of the horizontal axis.
fn abscissa(measured: &[(usize, Measured)]) -> Result<String, OutputError> {
    let (profiles, series): (Vec<_>, Vec<_>) =
        measured.iter().map(|(_, curve)| curve).partition(|curve| curve.abscissa != Abscissa::Time);
    match (profiles.first(), series.first()) {
        (Some(profile), Some(series)) => Err(OutputError::Request(format!(
            "`{}` is a profile along a line, `{}` a series over time: draw them in two plots",
            profile.name, series.name
        ))),
        (Some(first), None) => {
            let axis = first.abscissa;
            Ok(match axis {
                Abscissa::Axis(axis) if profiles.iter().all(|other| other.abscissa == first.abscissa) => {
                    format!("{} [m]", ["x", "y", "z"][axis])
                }
                _ => "distance from the first point [m]".to_owned(),
            })
        }
        _ => Ok("time [s]".to_owned()),
    }
}

/// Returns the name of a vertical axis: the quantities, if they are few, with their unit.
fn upward(unit: &str, curves: &[(usize, &Measured)]) -> String {
    let names = distinct(curves.iter().map(|(_, curve)| curve.name.as_str()));
    let unit = if unit.is_empty() { "–" } else { unit };
    if names.len() <= 3 { format!("{} [{unit}]", names.join(", ")) } else { format!("[{unit}]") }
}

fn distinct<'a>(names: impl Iterator<Item = &'a str>) -> Vec<&'a str> {
    let mut found: Vec<&str> = Vec::new();
    for name in names {
        if !found.contains(&name) {
            found.push(name);
        }
    }
    found
}

/// Returns the names of the run folders, or their paths if two have one name.
fn run_labels(tables: &[RunTables]) -> Vec<String> {
    let name = |run: &RunTables| run.folder.file_name().map(|name| name.to_string_lossy().into_owned());
    let names: Vec<String> =
        tables.iter().map(|run| name(run).unwrap_or_else(|| run.folder.display().to_string())).collect();
    if distinct(names.iter().map(String::as_str)).len() == tables.len() {
        return names;
    }
    tables.iter().map(|run| run.folder.display().to_string()).collect()
}
