//! Results of a case as a page in Markdown and as JSON.

use serde::Serialize;

use super::case::Case;
use super::measures::measurement::Measurement;
use super::schema::{CaseFile, FigureFile};
use super::verdict::{Verdict, band_text};
use sphecs_core::format::{duration, grouped, significant, with_digits};

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

fn value_text(measured: &FigureResult) -> String {
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

/// Returns the page of a case; `command` reproduces it.
pub fn page(case: &Case, result: &CaseResult, command: &str) -> String {
    let file = &case.file;
    let mut text = format!("# {}\n\n{}\n\nSource: {}.\n", file.title, file.setting.trim(), file.source);
    text +=
        "\n## Figures\n| figure | measured | required | goal | published | |\n|---|---|---|---|---|---|\n";
    for measured in &result.figures {
        let figure = &file.figures[measured.index];
        let band = |band: &Option<_>| band.as_ref().map_or(String::new(), band_text);
        let printed = figure.printed.map_or(String::new(), |printed| significant(printed.value));
        // A vertical bar would end the cell.
        text += &format!(
            "| {} | {} | {} | {} | {printed} | {} |\n",
            figure.what.replace('|', "\\|"),
            value_text(measured),
            band(&figure.must),
            band(&figure.goal),
            measured.verdict.word()
        );
    }
    text += &not_measured_line(file, result);
    for (path, title) in &result.plots {
        text += &format!("\n![{title}]({path})\n");
    }
    text += "\n## Runs\n| run | scene | particles | steps | wall time |\n|---|---|---|---|---|\n";
    for run in &result.runs {
        let sets: Vec<String> = run.set.iter().map(|(path, value)| format!("`{path}={value}`")).collect();
        let with = if sets.is_empty() { String::new() } else { format!(" with {}", sets.join(", ")) };
        let took = match &run.failure {
            Some(failure) => format!("failed: {failure}"),
            None => duration(run.wall_time),
        };
        let (particles, steps) = (grouped(run.particles), grouped(run.steps));
        text += &format!("| {} | `{}`{with} | {particles} | {steps} | {took} |\n", run.name, run.scene);
    }
    let earlier: Vec<&str> =
        result.runs.iter().filter(|run| run.of_another_build).map(|run| run.name.as_str()).collect();
    if !earlier.is_empty() {
        text += &format!("\nReused from another build of this version: {}.\n", earlier.join(", "));
    }
    for run in result.runs.iter().filter(|run| !run.notes.is_empty()) {
        text += &format!("\nNotes of `{}`: {}.\n", run.name, run.notes.join("; "));
    }
    if let Some(run) = result.runs.first() {
        let threads = match run.threads {
            1 => "1 thread".to_owned(),
            count => format!("{count} threads with as many concurrent runs"),
        };
        text += &format!("\n{threads}, {} lanes. To reproduce:\n", run.lanes);
    }
    text += &format!("```sh\n{command}\n```\n");
    if let Some(remarks) = &file.remarks {
        text += &format!("\n## Remarks\n{}\n", remarks.trim());
    }
    text
}

/// Returns a line on required figures that were not measured.
fn not_measured_line(file: &CaseFile, result: &CaseResult) -> String {
    if result.not_measured.is_empty() {
        return String::new();
    }
    let what: Vec<&str> =
        result.not_measured.iter().map(|&index| file.figures[index].what.as_str()).collect();
    format!(
        "\nRequired but not measured, because the runs belong to another tier or have no results: {}.\n",
        what.join("; ").replace('|', "\\|")
    )
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
