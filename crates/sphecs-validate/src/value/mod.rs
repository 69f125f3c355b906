//! What a figure of a case is, computed from the results of its runs.
//!
//! Rooms: `reading` (a value with its error, formulas), `fields` (which probes, which quantity), `reference` (what a
//! profile should be), `profile` (distances from it), `feature` (what a profile looks like), `ensemble` (how far apart two
//! flows are), `series` (columns over time), `waves` (growth and reflection). To add a way to measure: a variant of
//! `ValueFile` in `schema`, a room here, an arm below.
//!
//! A run is an ensemble of one or more members. What one run can tell is measured of each, and the figure is their mean.

pub mod ensemble;
pub mod feature;
pub mod fields;
pub mod profile;
pub mod reading;
pub mod reference;
pub mod series;
pub mod waves;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use super::case::Case;
use super::schema::{ReferenceFile, ValueFile};
use ensemble::Comparison;
use reading::Reading;
use sphecs_output::error::OutputError;
use sphecs_output::forces::{self, ForcesHistory};
use sphecs_output::monitor;
use sphecs_output::probes::history::ProbeHistory;
use sphecs_output::summary::Summary;
use sphecs_scene::expression::Constants;
use sphecs_scene::schema::Number;

/// The name under which the monitor is asked for.
pub const MONITOR: &str = "monitor";

/// The name under which the forces on bodies are asked for.
pub const FORCES: &str = "forces";

/// What a run left.
#[derive(Clone, Debug, Default)]
pub struct RunResults {
    /// How it went.
    pub summary: Summary,
    /// Its probes.
    pub probes: Vec<ProbeHistory>,
    /// Columns of the monitor.
    pub monitor: Vec<(String, Vec<f64>)>,
    /// Forces on its bodies.
    pub forces: ForcesHistory,
}

impl RunResults {
    /// Reads a run folder.
    ///
    /// # Errors
    /// [`OutputError`] with the path and the cause.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let summary = Summary::read(folder)?;
        let probes = ProbeHistory::read_all(folder, &summary.run)?;
        let forces = forces::read_history(folder, &summary.run)?;
        Ok(Self { probes, monitor: monitor::read_history(folder)?, forces, summary })
    }

    /// Returns a probe by name, or all of a pattern as one.
    ///
    /// # Errors
    /// That there is none.
    pub fn probe(&self, name: &str) -> Result<Cow<'_, ProbeHistory>, String> {
        fields::probe(&self.probes, name)
    }
}

/// What figures are computed from.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// The case.
    pub case: &'a Case,
    /// Results of the members of the runs, by name.
    pub runs: &'a BTreeMap<String, Vec<RunResults>>,
    /// The case's constants and the figures so far.
    pub known: &'a Constants,
    /// The figures so far.
    pub readings: &'a BTreeMap<String, Reading>,
}

impl<'a> Context<'a> {
    /// Returns the results of all members of a run.
    ///
    /// # Errors
    /// That it has none.
    pub fn members(&self, name: &str) -> Result<&'a [RunResults], String> {
        let found = self.runs.get(name).filter(|members| !members.is_empty());
        found.map(Vec::as_slice).ok_or_else(|| format!("run `{name}` has no results"))
    }

    /// Returns the results of a run, of an ensemble those of its first member.
    ///
    /// # Errors
    /// That it has none.
    pub fn run(&self, name: &str) -> Result<&'a RunResults, String> {
        self.members(name).map(|members| &members[0])
    }
}

/// Returns the runs that a value looks at; a formula and an order look at none.
pub fn runs_of(value: &ValueFile) -> Vec<&str> {
    match value {
        ValueFile::Profile { run, reference, .. } => {
            let mut runs = vec![run.value.as_str()];
            runs.extend(reference::run_of(reference));
            runs
        }
        ValueFile::Departure { run, from, .. } => vec![&run.value, &from.value],
        ValueFile::Feature { run, .. }
        | ValueFile::Series { run, .. }
        | ValueFile::Body { run, .. }
        | ValueFile::Growth { run, .. }
        | ValueFile::Reflection { run, .. } => vec![&run.value],
        ValueFile::Order { .. } | ValueFile::Formula(_) => Vec::new(),
    }
}

/// Returns the value of a figure.
///
/// # Errors
/// Why it cannot be told.
pub fn evaluate(value: &ValueFile, context: Context<'_>) -> Result<Reading, String> {
    let found = match value {
        ValueFile::Profile {
            run,
            probe,
            field,
            when,
            reference: reference @ (ReferenceFile::Run(_) | ReferenceFile::Members),
            norm,
            scale,
        } => {
            let comparison = Comparison { probe: &probe.value, field, when: &when.value, norm: *norm };
            let members = context.members(&run.value)?;
            let found = match reference::run_of(reference) {
                Some(other) => comparison.apart(members, context.members(other)?)?,
                None => comparison.within(members)?,
            };
            let scale = factor(scale);
            Reading { value: found.value / scale, error: found.error.map(|error| error / scale), ..found }
        }
        ValueFile::Departure { run, table, column, from, over } => {
            let other = series::column(context.run(&from.value)?, &table.value, &column.value)?;
            let of_member = |member: &RunResults| {
                let (times, values) = series::column(member, &table.value, &column.value)?;
                series::departure((&times, &values), (&other.0, &other.1), (over.0.value, over.1.value))
            };
            let members = context.members(&run.value)?.iter().map(of_member).collect::<Result<_, _>>()?;
            Reading::over(&run.value, members)
        }
        ValueFile::Order { figures, spacings } => {
            let figure =
                |name: &str| context.known.get(name).ok_or_else(|| format!("`{name}` was not measured"));
            let errors = figures.iter().map(|name| figure(&name.value)).collect::<Result<Vec<_>, _>>()?;
            Reading::plain(order(&errors, &spacings.iter().map(|spacing| spacing.value).collect::<Vec<_>>()))
        }
        ValueFile::Formula(text) => reading::formula(&text.value, context.known, context.readings)?,
        single => {
            let run = runs_of(single).first().copied().unwrap_or_default();
            let members = context.members(run)?.iter().map(|member| of_member(single, member, context.case));
            let members = members.collect::<Result<Vec<_>, String>>()?;
            let at_least = members.iter().any(|found| found.at_least);
            Reading { at_least, ..Reading::over(run, members.into_iter().map(|found| found.value).collect()) }
        }
    };
    if found.value.is_finite() { Ok(found) } else { Err(format!("is {}", found.value)) }
}

/// What a value is divided by.
fn factor(scale: &Option<Number>) -> f64 {
    scale.map_or(1.0, |scale| scale.value)
}

/// What one member of a run has for a value.
fn of_member(value: &ValueFile, run: &RunResults, case: &Case) -> Result<feature::Feature, String> {
    let found = match value {
        ValueFile::Profile { probe, field, when, reference, norm, scale, .. } => {
            let function = reference::function(reference, case)?.ok_or("no reference")?;
            let distances = profile::distances(&*run.probe(&probe.value)?, field, &when.value, &function)?;
            profile::norm(&distances, *norm) / factor(scale)
        }
        ValueFile::Feature { probe, field, when, take, scale, .. } => {
            let probe = run.probe(&probe.value)?;
            let profiles = profile::profiles(&probe, field, &when.value)?;
            let found = feature::feature(&probe.places, &profiles, take)?;
            return Ok(feature::Feature { value: found.value / factor(scale), ..found });
        }
        ValueFile::Series { table, column, over, take, scale, .. } => {
            let (times, values) = series::column(run, &table.value, &column.value)?;
            series::take(&times, &values, (over.0.value, over.1.value), *take)? / factor(scale)
        }
        ValueFile::Body { body, take, .. } => series::coefficient(run, &body.value, *take)?,
        ValueFile::Growth { probe, field, waves, between, .. } => {
            let probe = run.probe(&probe.value)?;
            let column = fields::column(&probe, field)?;
            waves::growth(&probe, &column, waves.value, (between.0.value, between.1.value))?
        }
        ValueFile::Reflection { probe, waves, impedance, incident, reflected, .. } => {
            let intervals = [incident, reflected].map(|interval| (interval.0.value, interval.1.value));
            let waves = waves.map_or(0.0, |waves| waves.value);
            waves::reflection(&*run.probe(&probe.value)?, waves, impedance.value, intervals)?
        }
        ValueFile::Departure { .. } | ValueFile::Order { .. } | ValueFile::Formula(_) => {
            return Err("not of one run".to_owned());
        }
    };
    Ok(feature::Feature { value: found, at_least: false })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_the_power_of_the_error() {
        let spacings = [0.4, 0.2, 0.1, 0.05];
        assert!((order(&spacings.map(|s: f64| 7.0 * s.powf(1.7)), &spacings) - 1.7).abs() < 1e-12);
    }
}
