//! `sphecs validate`: named cases are run, measured and held against their references.
//!
//! ```text
//! case file ─ case (checked) ─▶ runs of shipped scenes ─ value ─▶ figures ─ verdict ─▶ console, pages, plots, report.json
//! ```
//!
//! Rooms: `schema` (what may stand in a case file), `case` (reading and checking), `value/` (ways to measure), `exact/`
//! (solutions in closed form), `verdict` (bands), `plot` and `report` (what is left of it).
//!
//! To add a case: `assets/validation/NAME.ron`. Runs are scenes of `scenes/`, references formulas, exact solutions, tables
//! beside the case or other runs: no code.

pub mod case;
pub mod exact;
pub mod plot;
pub mod report;
pub mod schema;
pub mod value;
pub mod verdict;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use miette::Diagnostic;

use case::Case;
use report::{Measured, Outcome, RunLine};
use schema::{RunFile, Tier, ValueFile};
use value::{Context, RunResults, evaluate, runs_of};
use verdict::Verdict;

use crate::output::disk::write_whole;
use crate::output::error::OutputError;
use crate::output::summary::{Status, Summary};
use crate::run::console::Console;
use crate::run::error::RunError;
use crate::run::signals::Signal;
use crate::run::words::duration;
use crate::run::{self, Ending, RunOptions};
use crate::scene::faults::SceneFaults;

/// Name of the report for programs.
const REPORT: &str = "report.json";

/// What the user asks of a validation.
#[derive(Clone, Debug)]
pub struct ValidateOptions {
    /// Names or paths of the cases.
    pub cases: Vec<String>,
    /// How much is run.
    pub tier: Tier,
    /// Folder for runs, pages and plots.
    pub folder: PathBuf,
    /// Take completed runs of the same scene and version from the folder.
    pub reuse: bool,
    /// Threads; None: as many as the machine has cores.
    pub threads: Option<usize>,
    /// Where the words go.
    pub console: Console,
}

/// How a validation ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judgement {
    /// Every band that must be met was met.
    Met,
    /// Some was missed, or a run failed.
    Missed,
    /// A signal stopped it.
    Stopped(Signal),
}

/// Why a validation ended without its verdict.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum ValidateError {
    /// A case has faults.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Case(#[from] SceneFaults),
    /// A run could not begin.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Runs the cases, measures them and leaves pages, plots and `report.json` in the folder.
///
/// # Errors
/// [`ValidateError`]: faults of any case before anything runs, and files that cannot be written.
pub fn validate(options: &ValidateOptions) -> Result<Judgement, ValidateError> {
    let cases = options.cases.iter().map(|name| Case::load(name)).collect::<Result<Vec<_>, _>>()?;
    let mut outcomes = Vec::new();
    for case in cases {
        let outcome = match run_case(&case, options)? {
            Ok(outcome) => outcome,
            Err(signal) => return Ok(Judgement::Stopped(signal)),
        };
        if outcome.runs.is_empty() {
            options.console.say(&format!("{}: nothing to do in this tier\n", case.name));
            continue;
        }
        let page = report::page(&case, &outcome, &command(options, &case));
        write(&options.folder.join(format!("{}.md", case.name)), &page)?;
        outcomes.push((case, outcome));
        write(&options.folder.join(REPORT), &report::json(&outcomes))?;
    }
    let missed: Vec<&str> = outcomes
        .iter()
        .filter(|(_, outcome)| outcome.is_missed())
        .map(|(case, _)| case.name.as_str())
        .collect();
    let folder = options.folder.display();
    options.console.say(&if missed.is_empty() {
        format!("all that must be met is met; pages and plots in {folder}")
    } else {
        format!("missed: {}; pages and plots in {folder}", missed.join(", "))
    });
    Ok(if missed.is_empty() { Judgement::Met } else { Judgement::Missed })
}

fn command(options: &ValidateOptions, case: &Case) -> String {
    let tier = match options.tier {
        Tier::Quick => " --quick",
        Tier::Usual => "",
        Tier::Full => " --full",
    };
    let name = options.cases.iter().find(|name| name.ends_with(&format!("{}.ron", case.name)));
    format!("sphecs validate{tier} --case {}", name.unwrap_or(&case.name))
}

fn write(path: &Path, text: &str) -> Result<(), OutputError> {
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(OutputError::io(folder, "make the folder"))?;
    }
    write_whole(path, text.as_bytes())
}

/// Runs and measures a case, or tells the signal that stopped it.
fn run_case(case: &Case, options: &ValidateOptions) -> Result<Result<Outcome, Signal>, ValidateError> {
    let file = &case.file;
    let wanted: Vec<&RunFile> = file.runs.iter().filter(|run| run.tier <= options.tier).collect();
    let mut outcome = Outcome { runs: Vec::new(), figures: Vec::new(), plots: Vec::new() };
    if wanted.is_empty() {
        return Ok(Ok(outcome));
    }
    options.console.say(&format!("{}: {}", case.name, file.title));
    let mut results = BTreeMap::new();
    for run in &wanted {
        let folder = options.folder.join(&case.name).join(&run.name.value);
        let failure = match sail(case, run, &folder, options)? {
            Ok(failure) => failure,
            Err(signal) => return Ok(Err(signal)),
        };
        let found = RunResults::read(&folder)?;
        let line = run_line(run, &found.summary, failure);
        let took = line.failure.clone().unwrap_or_else(|| duration(line.wall_time));
        options.console.say(&format!("  run {:<20} {took}", run.name.value));
        if line.failure.is_none() {
            results.insert(run.name.value.clone(), found);
        }
        outcome.runs.push(line);
    }
    measure(case, &wanted, &results, &mut outcome, options.console);
    draw(case, &wanted, &results, &mut outcome, options)?;
    options.console.say("");
    Ok(Ok(outcome))
}

/// Sails one run, or takes an earlier one; why it has no results, or the signal that stopped it.
fn sail(
    case: &Case,
    run: &RunFile,
    folder: &Path,
    options: &ValidateOptions,
) -> Result<Result<Option<String>, Signal>, ValidateError> {
    let scene = case.scene(run)?;
    if options.reuse
        && let Ok(summary) = Summary::read(folder)
        && summary.status == Status::Completed
        && summary.run.version == env!("CARGO_PKG_VERSION")
        && std::fs::read_to_string(folder.join("scene.ron")).is_ok_and(|text| text == scene.text)
    {
        return Ok(Ok(None));
    }
    let run_options = RunOptions {
        folder: folder.to_path_buf(),
        force: true,
        threads: options.threads,
        until: None,
        steps: None,
        checkpoint_every: None,
        most_wall_time: None,
        console: Console::Quiet,
    };
    match run::run(scene, &run_options) {
        Ok(Ending::Completed | Ending::OutOfTime) => Ok(Ok(None)),
        Ok(Ending::Stopped(signal)) => Ok(Err(signal)),
        Err(RunError::Flow { stop, .. }) => Ok(Ok(Some(stop.to_string()))),
        Err(error) => Err(error.into()),
    }
}

fn run_line(run: &RunFile, summary: &Summary, failure: Option<String>) -> RunLine {
    let ledger = &summary.ledger;
    RunLine {
        name: run.name.value.clone(),
        scene: run.scene.value.clone(),
        set: run.set.iter().map(|(path, value)| (path.value.clone(), value.value.clone())).collect(),
        particles: ledger.fluid + ledger.wall + ledger.inflow + ledger.outflow,
        steps: summary.steps,
        wall_time: summary.wall_time,
        threads: summary.threads,
        lanes: summary.lanes.clone(),
        failure,
    }
}

/// Measures the figures of the runs of this tier, in their order.
fn measure(
    case: &Case,
    wanted: &[&RunFile],
    runs: &BTreeMap<String, RunResults>,
    outcome: &mut Outcome,
    console: Console,
) {
    let mut known = case.constants.clone();
    let mut left_out: Vec<&str> = Vec::new();
    console.say(&report::console_head());
    for (index, figure) in case.file.figures.iter().enumerate() {
        let is_run = |name: &str| wanted.iter().any(|run| run.name.value == name);
        let needs_left_out = match &figure.value {
            ValueFile::Order { figures, .. } => {
                figures.iter().any(|name| left_out.contains(&name.value.as_str()))
            }
            ValueFile::Formula(text) => left_out.iter().any(|name| names(&text.value, name)),
            value => !runs_of(value).into_iter().all(is_run),
        };
        if needs_left_out {
            left_out.push(&figure.name.value);
            continue;
        }
        let value = evaluate(&figure.value, Context { case, runs, known: &known });
        if let Ok(value) = value {
            known.define(&figure.name.value, value);
        }
        let verdict = Verdict::on(value.as_ref().ok().copied(), figure.must.as_ref(), figure.goal.as_ref());
        let measured = Measured { index, value, verdict };
        console.say(&report::console_line(figure, &measured));
        outcome.figures.push(measured);
    }
}

/// Whether a formula speaks of a name.
fn names(formula: &str, name: &str) -> bool {
    formula.split(|c: char| !c.is_ascii_alphanumeric() && c != '_').any(|word| word == name)
}

/// Draws the plots whose runs are of this tier; one that cannot be drawn is said and left out.
fn draw(
    case: &Case,
    wanted: &[&RunFile],
    runs: &BTreeMap<String, RunResults>,
    outcome: &mut Outcome,
    options: &ValidateOptions,
) -> Result<(), OutputError> {
    for plot in &case.file.plots {
        let run_of = |curve: &schema::CurveFile| match curve {
            schema::CurveFile::Profile { run, .. } | schema::CurveFile::Series { run, .. } => {
                run.value.clone()
            }
        };
        let has_runs =
            plot.curves.iter().all(|curve| wanted.iter().any(|run| run.name.value == run_of(curve)));
        if !has_runs {
            continue;
        }
        let name = format!("{}_{}.svg", case.name, plot.name.value);
        match plot::draw(plot, Context { case, runs, known: &case.constants }, &options.folder.join(&name)) {
            Ok(()) => outcome.plots.push((name, plot.title.clone())),
            Err(reason) => options.console.say(&format!("  no plot {name}: {reason}")),
        }
    }
    Ok(())
}
