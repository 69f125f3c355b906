//! Figures of a case computed from the results of its runs.
//!
//! - [`measurement`]: value with its error, formulas of figures
//! - [`fields`]: selection of probes and their quantities
//! - [`reference`](mod@reference): reference of a profile
//! - [`profile`]: distances from the reference
//! - [`feature`]: features of a profile
//! - [`ensemble`]: distance of two flows
//! - [`series`]: columns over time
//! - [`waves`]: growth and reflection
//! - [`torque`]: torque through a closed curve
//!
//! To add a measure: a variant of `ValueFile` in `schema`, a module here and an arm below.
//!
//! A run is an ensemble of one or more members. A figure of a single run is measured for each
//! member and averaged.

pub mod ensemble;
pub mod feature;
pub mod fields;
pub mod measurement;
pub mod profile;
pub mod reference;
pub mod series;
pub mod torque;
pub mod waves;

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::path::Path;

use super::case::Case;
use super::schema::{FieldFile, ReferenceFile, ValueFile};
use ensemble::Comparison;
use measurement::Measurement;
use sphecs_output::error::OutputError;
use sphecs_output::forces::{self, ForcesHistory};
use sphecs_output::monitor;
use sphecs_output::probes::history::ProbeHistory;
use sphecs_output::summary::Summary;
use sphecs_scene::expression::Constants;
use sphecs_scene::schema::Number;

/// Name of the monitor in a case file.
pub const MONITOR: &str = "monitor";

/// Name of the forces on bodies in a case file.
pub const FORCES: &str = "forces";

/// Results of a run.
#[derive(Clone, Debug, Default)]
pub struct RunResults {
    /// Summary.
    pub summary: Summary,
    /// Probes.
    pub probes: Vec<ProbeHistory>,
    /// Columns of the monitor.
    pub monitor: Vec<(String, Vec<f64>)>,
    /// Forces on the bodies.
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

    /// Returns the probe of a name, or all probes that match a pattern as one.
    ///
    /// # Errors
    /// There is none.
    pub fn probe(&self, name: &str) -> Result<Cow<'_, ProbeHistory>, String> {
        fields::probe(&self.probes, name)
    }
}

/// Input of the figures.
#[derive(Clone, Copy, Debug)]
pub struct Context<'a> {
    /// Case.
    pub case: &'a Case,
    /// Results of the members of the runs by name.
    pub runs: &'a BTreeMap<String, Vec<RunResults>>,
    /// Constants of the case and values of the figures so far.
    pub known: &'a Constants,
    /// Figures so far.
    pub measurements: &'a BTreeMap<String, Measurement>,
}

impl<'a> Context<'a> {
    /// Returns the results of all members of a run.
    ///
    /// # Errors
    /// The run has no results.
    pub fn members(&self, name: &str) -> Result<&'a [RunResults], String> {
        let found = self.runs.get(name).filter(|members| !members.is_empty());
        found.map(Vec::as_slice).ok_or_else(|| format!("run `{name}` has no results"))
    }

    /// Returns the results of a run, or of the first member of an ensemble.
    ///
    /// # Errors
    /// The run has no results.
    pub fn run(&self, name: &str) -> Result<&'a RunResults, String> {
        self.members(name).map(|members| &members[0])
    }
}

/// Returns the runs that a figure needs; a formula and an order need none.
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
        | ValueFile::Signal { run, .. }
        | ValueFile::TorqueThrough { run, .. }
        | ValueFile::Body { run, .. }
        | ValueFile::Growth { run, .. }
        | ValueFile::Reflection { run, .. } => vec![&run.value],
        ValueFile::Order { .. } | ValueFile::Formula(_) => Vec::new(),
    }
}

/// Returns the value of a figure.
///
/// # Errors
/// Reason why it cannot be measured.
pub fn evaluate(value: &ValueFile, context: Context<'_>) -> Result<Measurement, String> {
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
                Some(other) => comparison.between(members, context.members(other)?)?,
                None => comparison.within(members)?,
            };
            let scale = factor(scale);
            Measurement { value: found.value / scale, error: found.error.map(|error| error / scale), ..found }
        }
        ValueFile::Departure { run, table, column, from, over } => {
            let other = series::column(context.run(&from.value)?, &table.value, &column.value)?;
            let of_member = |member: &RunResults| {
                let (times, values) = series::column(member, &table.value, &column.value)?;
                series::departure((&times, &values), (&other.0, &other.1), (over.0.value, over.1.value))
            };
            let members = context.members(&run.value)?.iter().map(of_member).collect::<Result<_, _>>()?;
            Measurement::over(&run.value, members)
        }
        ValueFile::Order { figures, spacings } => {
            let figure =
                |name: &str| context.known.get(name).ok_or_else(|| format!("`{name}` was not measured"));
            let errors = figures.iter().map(|name| figure(&name.value)).collect::<Result<Vec<_>, _>>()?;
            Measurement::plain(order(
                &errors,
                &spacings.iter().map(|spacing| spacing.value).collect::<Vec<_>>(),
            ))
        }
        ValueFile::Formula(text) => measurement::formula(&text.value, context.known, context.measurements)?,
        single => {
            let run = runs_of(single).first().copied().unwrap_or_default();
            let members = context.members(run)?.iter().map(|member| of_member(single, member, context.case));
            let members = members.collect::<Result<Vec<_>, String>>()?;
            let at_least = members.iter().any(|found| found.at_least);
            Measurement {
                at_least,
                ..Measurement::over(run, members.into_iter().map(|found| found.value).collect())
            }
        }
    };
    if found.value.is_finite() { Ok(found) } else { Err(format!("is {}", found.value)) }
}

/// Returns the divisor of a value.
fn factor(scale: &Option<Number>) -> f64 {
    scale.map_or(1.0, |scale| scale.value)
}

/// Returns the value of one member of a run.
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
            series::statistic(&times, &values, (over.0.value, over.1.value), *take)? / factor(scale)
        }
        ValueFile::Signal { table, column, over, reference, take, scale, .. } => {
            let (times, values) = series::column(run, &table.value, &column.value)?;
            let function = reference::formula(reference, case)?;
            let of_time = |time: f64| function([0.0; 3], time);
            series::signal((&times, &values), (over.0.value, over.1.value), of_time, *take)? / factor(scale)
        }
        ValueFile::TorqueThrough { probes, over, .. } => {
            torque::through(&*run.probe(&probes.value)?, (over.0.value, over.1.value))?
        }
        ValueFile::Body { body, take, .. } => series::coefficient(run, &body.value, *take)?,
        ValueFile::Growth { probe, field, waves, between, .. } => {
            let probe = run.probe(&probe.value)?;
            let column = fields::column(&probe, field)?;
            waves::growth(&probe, &column, waves.value, (between.0.value, between.1.value))?
        }
        ValueFile::Reflection { probe, waves, velocity, impedance, incident, reflected, .. } => {
            let intervals = [incident, reflected].map(|interval| (interval.0.value, interval.1.value));
            let waves = waves.map_or(0.0, |waves| waves.value);
            let velocity = velocity.as_ref().unwrap_or(&FieldFile::U);
            waves::reflection(&*run.probe(&probe.value)?, velocity, waves, impedance.value, intervals)?
        }
        ValueFile::Departure { .. } | ValueFile::Order { .. } | ValueFile::Formula(_) => {
            return Err("needs more than one run".to_owned());
        }
    };
    Ok(feature::Feature { value: found, at_least: false })
}

/// Returns the least-squares slope of the logarithms of errors over those of spacings.
fn order(errors: &[f64], spacings: &[f64]) -> f64 {
    let points: Vec<(f64, f64)> = spacings.iter().zip(errors).map(|(s, e)| (s.ln(), e.ln())).collect();
    slope(&points)
}

/// Returns the least-squares slope of some points.
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
