//! `sphecs validate`: named cases are run, measured and held against their references.
//!
//! ```text
//! case file ─ case (checked) ─▶ runs of shipped scenes ─ value ─▶ figures ─ verdict ─▶ console, pages, plots, report.json
//! ```
//!
//! Rooms: `schema/` (what may stand in a case file), `case` (reading), `check` (its faults), `value/` (ways to measure),
//! `exact/` (solutions in closed form), `verdict` (bands), `plot`, `picture` and `report` (what is left of it).
//!
//! To add a case: `assets/validation/NAME.ron`. Runs are scenes of `scenes/`, references formulas, exact solutions, tables
//! beside the case or other runs: no code.

pub mod case;
mod check;
pub mod exact;
mod picture;
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
use schema::{ReferenceFile, RunFile, Tier, ValueFile};
use value::reading::{Reading, error_of, names};
use value::{Context, RunResults, evaluate, runs_of};
use verdict::Verdict;

use crate::output::disk::write_whole;
use crate::output::error::OutputError;
use crate::output::summary::{Status, Summary};
use crate::run::console::Console;
use crate::run::error::RunError;
use crate::run::resume::{self, ResumeOptions};
use crate::run::signals::Signal;
use crate::run::words::duration;
use crate::run::{self, Ending, RunOptions};
use crate::scene::faults::SceneFaults;
use crate::scene::model::Scene;

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
    /// Take completed runs of the same scene and version from the folder, and go on with those that were begun.
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
    let mut outcome = Outcome::default();
    if wanted.is_empty() {
        return Ok(Ok(outcome));
    }
    options.console.say(&format!("{}: {}", case.name, file.title));
    let mut results: BTreeMap<String, Vec<RunResults>> = BTreeMap::new();
    for run in &wanted {
        for (member, set) in run.members(options.tier).iter().enumerate() {
            let name = run.member_name(member);
            let folder = options.folder.join(&case.name).join(&name);
            let failure = match sail(case.member_scene(run, set)?, &folder, options)? {
                Ok(failure) => failure,
                Err(signal) => return Ok(Err(signal)),
            };
            let found = RunResults::read(&folder)?;
            let line = run_line(name, run, set, &found.summary, failure);
            let took = line.failure.clone().unwrap_or_else(|| duration(line.wall_time));
            options.console.say(&format!("  run {:<20} {took}", line.name));
            if line.failure.is_none() {
                results.entry(run.name.value.clone()).or_default().push(found);
            }
            outcome.runs.push(line);
        }
    }
    measure(case, &wanted, &results, &mut outcome, options);
    draw(case, &results, &mut outcome, options);
    options.console.say("");
    Ok(Ok(outcome))
}

/// What a folder has of a run.
enum Earlier {
    Nothing,
    /// It was stopped or killed.
    Begun,
    Whole,
}

impl Earlier {
    /// What the folder has of the run of this scene to its end, by this version.
    fn of(scene: &Scene, folder: &Path) -> Self {
        let Ok(summary) = Summary::read(folder) else { return Earlier::Nothing };
        let run = &summary.run;
        let same_text =
            || std::fs::read_to_string(folder.join("scene.ron")).is_ok_and(|text| text == scene.text);
        let to_its_end = run.until.is_none() && run.most_steps.is_none();
        if run.version != env!("CARGO_PKG_VERSION") || !to_its_end || !same_text() {
            return Earlier::Nothing;
        }
        match summary.status {
            Status::Completed => Earlier::Whole,
            Status::Running | Status::Interrupted | Status::Terminated | Status::OutOfTime => Earlier::Begun,
            Status::BlownUp | Status::Failed => Earlier::Nothing,
        }
    }
}

/// Sails one run, goes on with one that was begun, or takes an earlier one; why it has no results, or the signal that stopped it.
fn sail(
    scene: Scene,
    folder: &Path,
    options: &ValidateOptions,
) -> Result<Result<Option<String>, Signal>, ValidateError> {
    let earlier = if options.reuse { Earlier::of(&scene, folder) } else { Earlier::Nothing };
    if let Earlier::Whole = earlier {
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
        allow_oversize: false,
        console: Console::Quiet,
    };
    let ending = match earlier {
        Earlier::Begun => match resume::resume(&ResumeOptions {
            run: run_options.clone(),
            sets: Vec::new(),
            allow_other_isa: false,
        }) {
            // Nothing to go on from: its checkpoints are damaged, of another layout or of another machine. What else may
            // fail, a full disk say, would fail again, and leaves what was begun.
            Err(RunError::Output(OutputError::Request(_) | OutputError::Damaged { .. })) => {
                run::run(scene, &run_options)
            }
            ending => ending,
        },
        Earlier::Nothing | Earlier::Whole => run::run(scene, &run_options),
    };
    match ending {
        Ok(Ending::Completed | Ending::OutOfTime) => Ok(Ok(None)),
        Ok(Ending::Stopped(signal)) => Ok(Err(signal)),
        Err(RunError::Flow { stop, .. }) => Ok(Ok(Some(stop.to_string()))),
        Err(error) => Err(error.into()),
    }
}

fn run_line(
    name: String,
    run: &RunFile,
    set: &[(String, String)],
    summary: &Summary,
    failure: Option<String>,
) -> RunLine {
    let ledger = &summary.ledger;
    RunLine {
        name,
        scene: run.scene.value.clone(),
        set: set.to_vec(),
        particles: ledger.fluid + ledger.wall + ledger.inflow + ledger.outflow,
        steps: summary.steps,
        wall_time: summary.wall_time,
        threads: summary.threads,
        lanes: summary.lanes.clone(),
        failure,
        may_fail: run.may_fail,
    }
}

/// Measures the figures of the runs of this tier, in their order.
fn measure(
    case: &Case,
    wanted: &[&RunFile],
    runs: &BTreeMap<String, Vec<RunResults>>,
    outcome: &mut Outcome,
    options: &ValidateOptions,
) {
    let mut known = case.constants.clone();
    let mut readings = BTreeMap::new();
    let mut left_out: Vec<&str> = Vec::new();
    let is_present = |run: &&&RunFile| !run.may_fail || runs.contains_key(&run.name.value);
    let present: Vec<&RunFile> = wanted.iter().filter(is_present).copied().collect();
    options.console.say(&report::console_head());
    for (index, figure) in case.file.figures.iter().enumerate() {
        let name = &figure.name.value;
        if is_left_out(&figure.value, &present, options.tier, &left_out, &readings) {
            left_out.push(name);
            continue;
        }
        let value = evaluate(&figure.value, Context { case, runs, known: &known, readings: &readings });
        if let Ok(reading) = &value {
            known.define(name, reading.value);
            if let Some(error) = reading.error {
                known.define(&error_of(name), error);
            }
            readings.insert(name.clone(), reading.clone());
        }
        let found = value.as_ref().ok().map(|reading| reading.value);
        let verdict = Verdict::on(found, figure.must.as_ref(), figure.goal.as_ref());
        let measured = Measured { index, value, verdict };
        options.console.say(&report::console_line(figure, &measured));
        outcome.figures.push(measured);
    }
}

/// Whether a figure looks at figures that were left out, or at runs or members that are not there and need not be.
fn is_left_out(
    value: &ValueFile,
    present: &[&RunFile],
    tier: Tier,
    left_out: &[&str],
    readings: &BTreeMap<String, Reading>,
) -> bool {
    let run_of = |name: &str| present.iter().find(|run| run.name.value == name);
    match value {
        ValueFile::Order { figures, .. } => {
            figures.iter().any(|name| left_out.contains(&name.value.as_str()))
        }
        ValueFile::Formula(text) => names(&text.value).any(|word| {
            let figure = word.strip_suffix("_error").unwrap_or(word);
            let without_error = |reading: &Reading| figure != word && reading.error.is_none();
            left_out.contains(&word)
                || figure != word && left_out.contains(&figure)
                || readings.get(figure).is_some_and(without_error)
        }),
        value => {
            let runs = runs_of(value);
            let needs_members = matches!(value, ValueFile::Profile { reference: ReferenceFile::Members, .. });
            !runs.iter().all(|name| run_of(name).is_some())
                || needs_members
                    && runs.iter().filter_map(|name| run_of(name)).any(|run| run.members(tier).len() < 2)
        }
    }
}

/// Draws the plots and pictures whose runs have results; one that cannot be drawn is said and left out.
fn draw(
    case: &Case,
    runs: &BTreeMap<String, Vec<RunResults>>,
    outcome: &mut Outcome,
    options: &ValidateOptions,
) {
    let context = Context { case, runs, known: &case.constants, readings: &BTreeMap::new() };
    let has_results = |curve: &schema::CurveFile| runs.contains_key(&curve.run().value);
    for plot in case.file.plots.iter().filter(|plot| plot.curves.iter().any(has_results)) {
        let name = format!("{}_{}.svg", case.name, plot.name.value);
        match plot::draw(plot, context, &options.folder.join(&name)) {
            Ok(()) => outcome.plots.push((name, plot.title.clone())),
            Err(reason) => options.console.say(&format!("  no plot {name}: {reason}")),
        }
    }
    for file in case.file.pictures.iter().filter(|file| runs.contains_key(&file.run.value)) {
        let run = options.folder.join(&case.name).join(&file.run.value);
        let stem = format!("{}_{}", case.name, file.name.value);
        for (name, drawn) in picture::draw(file, &run, &options.folder, &stem) {
            match drawn {
                Ok(title) => outcome.plots.push((name, title)),
                Err(reason) => options.console.say(&format!("  no picture {name}: {reason}")),
            }
        }
    }
}
