//! What a figure of a case is, computed from the results of its runs.
//!
//! Rooms: `reference` (what a profile should be), `profile` (distances from it), `series` (columns over time), `waves`
//! (growth and reflection). To add a way to measure: a variant of `ValueFile` in `schema`, a room here, an arm below.

pub mod profile;
pub mod reference;
pub mod series;
pub mod waves;

use std::collections::BTreeMap;
use std::path::Path;

use super::case::Case;
use super::schema::{FieldFile, ValueFile};
use crate::output::error::OutputError;
use crate::output::monitor;
use crate::output::probes::history::ProbeHistory;
use crate::output::summary::Summary;
use crate::scene::expression::Constants;

/// The name under which the monitor is asked for.
pub const MONITOR: &str = "monitor";

/// What a run left.
#[derive(Clone, Debug)]
pub struct RunResults {
    /// How it went.
    pub summary: Summary,
    /// Its probes.
    pub probes: Vec<ProbeHistory>,
    /// Columns of the monitor.
    pub monitor: Vec<(String, Vec<f64>)>,
}

impl RunResults {
    /// Reads a run folder.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let summary = Summary::read(folder)?;
        let probes = ProbeHistory::read_all(folder, &summary.run)?;
        Ok(Self { probes, monitor: monitor::read_history(folder)?, summary })
    }

    /// A probe by name.
    ///
    /// # Errors
    /// That there is none.
    pub fn probe(&self, name: &str) -> Result<&ProbeHistory, String> {
        self.probes.iter().find(|probe| probe.name == name).ok_or_else(|| format!("no probe `{name}`"))
    }
}

/// What figures are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The case.
    pub case: &'a Case,
    /// Results of the runs, by name.
    pub runs: &'a BTreeMap<String, RunResults>,
    /// The case's constants and the figures so far.
    pub known: &'a Constants,
}

impl<'a> Context<'a> {
    /// The results of a run.
    ///
    /// # Errors
    /// That it has none.
    pub fn run(&self, name: &str) -> Result<&'a RunResults, String> {
        self.runs.get(name).ok_or_else(|| format!("run `{name}` has no results"))
    }
}

/// The runs that a value looks at; a formula and an order look at none.
pub fn runs_of(value: &ValueFile) -> Vec<&str> {
    match value {
        ValueFile::Profile { run, reference, .. } => {
            let mut runs = vec![run.value.as_str()];
            runs.extend(reference::run_of(reference));
            runs
        }
        ValueFile::Series { run, .. } | ValueFile::Growth { run, .. } | ValueFile::Reflection { run, .. } => {
            vec![&run.value]
        }
        ValueFile::Order { .. } | ValueFile::Formula(_) => Vec::new(),
    }
}

/// The value of a figure.
///
/// # Errors
/// Why it cannot be told.
pub fn evaluate(value: &ValueFile, context: Context<'_>) -> Result<f64, String> {
    let found = match value {
        ValueFile::Profile { run, probe, field, when, reference, norm, scale } => {
            let scale = scale.map_or(1.0, |scale| scale.value);
            let distances =
                profile::distances(context, (&run.value, &probe.value), *field, &when.value, reference)?;
            profile::norm(&distances, *norm) / scale
        }
        ValueFile::Series { run, table, column, over, take } => {
            let (times, values) = series::column(context.run(&run.value)?, &table.value, &column.value)?;
            series::take(&times, &values, (over.0.value, over.1.value), *take)?
        }
        ValueFile::Growth { run, probe, field, waves, between } => {
            let probe = context.run(&run.value)?.probe(&probe.value)?;
            waves::growth(probe, field.column(), waves.value, (between.0.value, between.1.value))?
        }
        ValueFile::Reflection { run, probe, waves, impedance, incident, reflected } => {
            let probe = context.run(&run.value)?.probe(&probe.value)?;
            let intervals = [incident, reflected].map(|interval| (interval.0.value, interval.1.value));
            waves::reflection(probe, waves.map_or(0.0, |waves| waves.value), impedance.value, intervals)?
        }
        ValueFile::Order { figures, spacings } => {
            let figure =
                |name: &str| context.known.get(name).ok_or_else(|| format!("`{name}` was not measured"));
            let errors = figures.iter().map(|name| figure(&name.value)).collect::<Result<Vec<_>, _>>()?;
            order(&errors, &spacings.iter().map(|spacing| spacing.value).collect::<Vec<_>>())
        }
        ValueFile::Formula(text) => {
            context.known.number(&text.value).map_err(|_| "of figures that were not measured".to_owned())?
        }
    };
    if found.is_finite() { Ok(found) } else { Err(format!("is {found}")) }
}

/// Slope of the logarithms of errors over those of spacings, by least squares.
fn order(errors: &[f64], spacings: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = spacings.iter().zip(errors).map(|(s, e)| (s.ln(), e.ln())).collect();
    slope(&points)
}

/// Slope of the straight line nearest to some points, by least squares.
fn slope(points: &[(f64, f64)]) -> f64 {
    let count = points.len() as f64;
    let mean = |of: fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / count;
    let (x, y) = (mean(|point| point.0), mean(|point| point.1));
    let products: f64 = points.iter().map(|point| (point.0 - x) * (point.1 - y)).sum();
    products / points.iter().map(|point| (point.0 - x).powi(2)).sum::<f64>()
}

impl FieldFile {
    /// The column of `probes.csv`.
    pub fn column(self) -> &'static str {
        match self {
            FieldFile::U => "u",
            FieldFile::V => "v",
            FieldFile::W => "w",
            FieldFile::Pressure => "pressure",
            FieldFile::Density => "density",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_the_power_of_the_error() {
        let spacings = [0.4, 0.2, 0.1, 0.05];
        assert!((order(&spacings.map(|s: f64| 7.0 * s.powf(1.7)), &spacings) - 1.7).abs() < 1e-12);
    }
}
