//! Results of a case on the console and as JSON.

use serde::Serialize;

use super::case::Case;
use super::measures::measurement::Measurement;
use super::schema::FigureFile;
use super::verdict::{Verdict, band_text};
use sphecs_core::format::{significant, with_digits};

/// Value and verdict of a figure.
#[derive(Clone, Debug)]
pub struct FigureResult {
    /// Index among the figures of the case.
    pub index: usize,
    /// Value, or the reason why there is none.
    pub value: Result<Measurement, String>,
    /// Verdict.
    pub verdict: Verdict,
}

/// Run as listed on the page.
#[derive(Clone, Debug, Serialize)]
pub struct RunLine {
    /// Name.
    pub name: String,
    /// Scene.
    pub scene: String,
    /// Values changed in the scene.
    pub set: Vec<(String, String)>,
    /// Number of particles, reservoir excluded.
    pub particles: u64,
    /// Number of steps.
    pub steps: u64,
    /// Wall time, s.
    pub wall_time: f64,
    /// Number of threads.
    pub threads: usize,
    /// Instruction set.
    pub lanes: String,
    /// Notes on its outlets.
    pub notes: Vec<String>,
    /// True if the run was made by another build of this version.
    pub of_another_build: bool,
    /// Reason of a failure.
    pub failure: Option<String>,
    /// True if a failure is permitted.
    pub may_fail: bool,
}

/// Results of a case.
#[derive(Clone, Debug, Default)]
pub struct CaseResult {
    /// Runs.
    pub runs: Vec<RunLine>,
    /// Measured figures.
    pub figures: Vec<FigureResult>,
    /// Indices of figures with a required band that were not measured: their runs belong to another
    /// tier or were permitted to diverge and did.
    pub not_measured: Vec<usize>,
    /// Files and titles of plots and pictures.
    pub plots: Vec<(String, String)>,
}

impl CaseResult {
    /// Returns true if a required band was missed or a run failed without permission.
    pub fn is_missed(&self) -> bool {
        self.runs.iter().any(|run| run.failure.is_some() && !run.may_fail)
            || self.figures.iter().any(|figure| figure.verdict == Verdict::Missed)
    }
}

/// Returns the value of a figure with its error, or the reason why there is none.
pub(crate) fn value_text(measured: &FigureResult) -> String {
    match &measured.value {
        Ok(measurement) => {
            let bound = if measurement.at_least { "≥ " } else { "" };
            let error = measurement.error.filter(|error| *error > 0.0);
            let error = error.map_or(String::new(), |error| format!(" ± {}", with_digits(error, 2)));
            format!("{bound}{}{error}", significant(measurement.value))
        }
        Err(reason) => format!("– ({reason})"),
    }
}

/// Returns the line of a figure in the table on the console.
pub fn console_line(figure: &FigureFile, measured: &FigureResult) -> String {
    let band = |band: &Option<_>| band.as_ref().map_or(String::new(), band_text);
    format!(
        "  {:<44}  {:>11}  {:>18}  {:>14}  {}",
        figure.what,
        value_text(measured),
        band(&figure.must),
        band(&figure.goal),
        measured.verdict.word()
    )
    .trim_end()
    .to_owned()
}

/// Returns the head of the table on the console.
pub fn console_head() -> String {
    format!("  {:<44}  {:>11}  {:>18}  {:>14}  verdict", "figure", "measured", "required", "goal")
}

/// Figure in `report.json`.
#[derive(Clone, Debug, Serialize)]
struct FigureEntry<'a> {
    case: &'a str,
    figure: &'a str,
    what: &'a str,
    value: Option<f64>,
    error: Option<f64>,
    at_least: bool,
    members: &'a [f64],
    reason: Option<&'a str>,
    must: Option<String>,
    goal: Option<String>,
    printed: Option<f64>,
    verdict: &'static str,
}

/// Returns the contents of `report.json` for all cases.
pub fn json(results: &[(&Case, CaseResult)]) -> String {
    let figures: Vec<FigureEntry<'_>> = results
        .iter()
        .flat_map(|(case, result)| {
            result.figures.iter().map(move |measured| {
                let figure = &case.file.figures[measured.index];
                let measurement = measured.value.as_ref().ok();
                FigureEntry {
                    case: &case.name,
                    figure: &figure.name.value,
                    what: &figure.what,
                    value: measurement.map(|measurement| measurement.value),
                    error: measurement.and_then(|measurement| measurement.error),
                    at_least: measurement.is_some_and(|measurement| measurement.at_least),
                    members: measurement.map_or(&[], |measurement| &measurement.members),
                    reason: measured.value.as_ref().err().map(String::as_str),
                    must: figure.must.as_ref().map(band_text),
                    goal: figure.goal.as_ref().map(band_text),
                    printed: figure.printed.map(|printed| printed.value),
                    verdict: measured.verdict.word(),
                }
            })
        })
        .collect();
    let runs: Vec<(&str, &RunLine)> = results
        .iter()
        .flat_map(|(case, result)| result.runs.iter().map(|run| (case.name.as_str(), run)))
        .collect();
    let not_measured: Vec<(&str, &str)> = results
        .iter()
        .flat_map(|(case, result)| {
            let name = |index: &usize| case.file.figures[*index].name.value.as_str();
            result.not_measured.iter().map(move |index| (case.name.as_str(), name(index)))
        })
        .collect();
    let report = serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"), "runs": runs, "figures": figures, "not_measured": not_measured,
    });
    format!("{report:#}\n")
}
