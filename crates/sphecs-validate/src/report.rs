//! What a case came to: a page in Markdown, and its figures for programs.

use serde::Serialize;

use super::case::Case;
use super::schema::{CaseFile, FigureFile};
use super::value::reading::Reading;
use super::verdict::{Verdict, figures, number, signs};
use sphecs_core::format::{duration, grouped};

/// A figure with its value.
#[derive(Clone, Debug)]
pub struct Measured {
    /// Its place among the case's figures.
    pub index: usize,
    /// The value, or why there is none.
    pub value: Result<Reading, String>,
    /// How it stands.
    pub verdict: Verdict,
}

/// A run as the page tells it.
#[derive(Clone, Debug, Serialize)]
pub struct RunLine {
    /// Name.
    pub name: String,
    /// Scene.
    pub scene: String,
    /// Values put in.
    pub set: Vec<(String, String)>,
    /// Particles, reservoir not included.
    pub particles: u64,
    /// Steps.
    pub steps: u64,
    /// Wall time, s.
    pub wall_time: f64,
    /// Threads.
    pub threads: usize,
    /// Lanes.
    pub lanes: String,
    /// What its outlets were seen to do that they should not.
    pub notes: Vec<String>,
    /// True if another build of this version made it.
    pub of_another_build: bool,
    /// Why it has no results.
    pub failure: Option<String>,
    /// True if a failure is no miss.
    pub may_fail: bool,
}

/// What a case came to.
#[derive(Clone, Debug, Default)]
pub struct Outcome {
    /// Its runs.
    pub runs: Vec<RunLine>,
    /// Its figures, those of runs that this tier leaves out not among them.
    pub figures: Vec<Measured>,
    /// Places among the case's figures of those with a band to be met that were not looked at: their runs are of another tier, or blew up
    /// and may.
    pub unseen: Vec<usize>,
    /// Plots and pictures that were drawn: file and title.
    pub plots: Vec<(String, String)>,
}

impl Outcome {
    /// Returns true if a band to be met was missed, or a run failed.
    pub fn is_missed(&self) -> bool {
        self.runs.iter().any(|run| run.failure.is_some() && !run.may_fail)
            || self.figures.iter().any(|figure| figure.verdict == Verdict::Missed)
    }
}

fn value_text(measured: &Measured) -> String {
    match &measured.value {
        Ok(reading) => {
            let bound = if reading.at_least { "≥ " } else { "" };
            let error = reading.error.filter(|error| *error > 0.0);
            let error = error.map_or(String::new(), |error| format!(" ± {}", figures(error, 2)));
            format!("{bound}{}{error}", number(reading.value))
        }
        Err(reason) => format!("– ({reason})"),
    }
}

/// One line of the table on the console.
pub fn console_line(figure: &FigureFile, measured: &Measured) -> String {
    let band = |band: &Option<_>| band.as_ref().map_or(String::new(), signs);
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

/// Head of that table.
pub fn console_head() -> String {
    format!("  {:<44}  {:>11}  {:>18}  {:>14}  verdict", "figure", "measured", "must", "goal")
}

/// Returns the page of a case; `command` is what makes it again.
pub fn page(case: &Case, outcome: &Outcome, command: &str) -> String {
    let file = &case.file;
    let mut text = format!("# {}\n\n{}\n\nSource: {}.\n", file.title, file.setting.trim(), file.source);
    text +=
        "\n## Figures\n| figure | measured | must | goal | printed there | |\n|---|---|---|---|---|---|\n";
    for measured in &outcome.figures {
        let figure = &file.figures[measured.index];
        let band = |band: &Option<_>| band.as_ref().map_or(String::new(), signs);
        let printed = figure.printed.map_or(String::new(), |printed| number(printed.value));
        // A bar would end the cell.
        text += &format!(
            "| {} | {} | {} | {} | {printed} | {} |\n",
            figure.what.replace('|', "\\|"),
            value_text(measured),
            band(&figure.must),
            band(&figure.goal),
            measured.verdict.word()
        );
    }
    text += &unseen_line(file, outcome);
    for (path, title) in &outcome.plots {
        text += &format!("\n![{title}]({path})\n");
    }
    text += "\n## Runs\n| run | scene | particles | steps | wall time |\n|---|---|---|---|---|\n";
    for run in &outcome.runs {
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
        outcome.runs.iter().filter(|run| run.of_another_build).map(|run| run.name.as_str()).collect();
    if !earlier.is_empty() {
        text += &format!("\nTaken from an earlier build of this version: {}.\n", earlier.join(", "));
    }
    for run in outcome.runs.iter().filter(|run| !run.notes.is_empty()) {
        text += &format!("\n`{}` said: {}.\n", run.name, run.notes.join("; "));
    }
    if let Some(run) = outcome.runs.first() {
        let threads = match run.threads {
            1 => "1 thread".to_owned(),
            count => format!("{count} threads, with as many runs at a time"),
        };
        text += &format!("\n{threads}, {} lanes. Again by\n", run.lanes);
    }
    text += &format!("```sh\n{command}\n```\n");
    if let Some(remarks) = &file.remarks {
        text += &format!("\n## Remarks\n{}\n", remarks.trim());
    }
    text
}

/// What should be met and was not measured; nothing where all was.
fn unseen_line(file: &CaseFile, outcome: &Outcome) -> String {
    if outcome.unseen.is_empty() {
        return String::new();
    }
    let what: Vec<&str> = outcome.unseen.iter().map(|&index| file.figures[index].what.as_str()).collect();
    format!(
        "\nTo be met, too, but not measured here, as their runs are of another tier or have no results: {}.\n",
        what.join("; ").replace('|', "\\|")
    )
}

/// A figure as `report.json` has it.
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

/// Returns the contents of `report.json`: runs and figures of all cases.
pub fn json(outcomes: &[(&Case, Outcome)]) -> String {
    let figures: Vec<FigureEntry<'_>> = outcomes
        .iter()
        .flat_map(|(case, outcome)| {
            outcome.figures.iter().map(move |measured| {
                let figure = &case.file.figures[measured.index];
                let reading = measured.value.as_ref().ok();
                FigureEntry {
                    case: &case.name,
                    figure: &figure.name.value,
                    what: &figure.what,
                    value: reading.map(|reading| reading.value),
                    error: reading.and_then(|reading| reading.error),
                    at_least: reading.is_some_and(|reading| reading.at_least),
                    members: reading.map_or(&[], |reading| &reading.members),
                    reason: measured.value.as_ref().err().map(String::as_str),
                    must: figure.must.as_ref().map(signs),
                    goal: figure.goal.as_ref().map(signs),
                    printed: figure.printed.map(|printed| printed.value),
                    verdict: measured.verdict.word(),
                }
            })
        })
        .collect();
    let runs: Vec<(&str, &RunLine)> = outcomes
        .iter()
        .flat_map(|(case, outcome)| outcome.runs.iter().map(|run| (case.name.as_str(), run)))
        .collect();
    let unseen: Vec<(&str, &str)> = outcomes
        .iter()
        .flat_map(|(case, outcome)| {
            let name = |index: &usize| case.file.figures[*index].name.value.as_str();
            outcome.unseen.iter().map(move |index| (case.name.as_str(), name(index)))
        })
        .collect();
    let report = serde_json::json!({
        "version": env!("CARGO_PKG_VERSION"), "runs": runs, "figures": figures, "not_measured": unseen,
    });
    format!("{report:#}\n")
}
