//! `sphecs validate`: named cases are run, measured and held against their references.
//!
//! ```text
//! case file ─ case (checked) ─▶ runs of shipped scenes ─ value ─▶ figures ─ verdict ─▶ console, pages, plots, report.json
//! ```
//!
//! Rooms: `schema/` (what may stand in a case file), `case` (reading), `check` (its faults), `fleet` (the runs, side by side), `value/` (ways to measure),
//! `exact/` (solutions in closed form), `verdict` (bands), `plot`, `picture` and `report` (what is left of it).
//!
//! To add a case: `assets/validation/NAME.ron`. Runs are scenes of `scenes/`, references formulas, exact solutions, tables
//! beside the case or other runs: no code.

pub mod case;
mod check;
pub mod exact;
mod fleet;
mod picture;
pub mod plot;
pub mod report;
pub mod schema;
pub mod value;
pub mod verdict;

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use miette::Diagnostic;

use case::Case;
use fleet::{Landed, Passage};
use report::{Measured, Outcome};
use schema::{ReferenceFile, RunFile, Tier, ValueFile};
use value::reading::{Reading, error_of, names};
use value::{Context, RunResults, evaluate, runs_of};
use verdict::Verdict;

use sphecs_output::disk::write_whole;
use sphecs_output::error::OutputError;
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::signals::Signal;
use sphecs_run::words::duration;
use sphecs_scene::faults::SceneErrors;

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
    /// Threads, on which runs go side by side; None: as many as the machine has cores.
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
    Case(#[from] SceneErrors),
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
    let passages_of = |(index, case)| Passage::of_case(index, case, options.tier, &options.folder);
    let passages: Vec<Passage<'_>> = cases.iter().enumerate().flat_map(passages_of).collect();
    let mut judge = Judge::new(&cases, &passages, options);
    judge.hear_complete_cases()?;
    let judge = Mutex::new(judge);
    let stopped = fleet::sail_all(&cases, &passages, options, |index, landed| {
        judge.lock().unwrap_or_else(PoisonError::into_inner).land(index, landed)
    })?;
    if let Some(signal) = stopped {
        return Ok(Judgement::Stopped(signal));
    }
    Ok(judge.into_inner().unwrap_or_else(PoisonError::into_inner).judgement())
}

/// Hears the cases in their order, each as soon as its runs and those of the cases before it are made.
struct Judge<'a> {
    cases: &'a [Case],
    passages: &'a [Passage<'a>],
    options: &'a ValidateOptions,
    /// By passage, until its case is heard.
    landed: Vec<Option<Landed>>,
    /// The case to be heard next.
    next: usize,
    outcomes: Vec<(&'a Case, Outcome)>,
}

impl<'a> Judge<'a> {
    fn new(cases: &'a [Case], passages: &'a [Passage<'a>], options: &'a ValidateOptions) -> Self {
        let landed = passages.iter().map(|_| None).collect();
        Self { cases, passages, options, landed, next: 0, outcomes: Vec::new() }
    }

    fn land(&mut self, index: usize, landed: Landed) -> Result<(), ValidateError> {
        let case = &self.cases[self.passages[index].case_index].name;
        let took = landed.line.failure.clone().unwrap_or_else(|| duration(landed.line.wall_time));
        let name = format!("{case}/{}", landed.line.name);
        self.options.console.say(&format!("ran {name:<32} {took}"));
        self.landed[index] = Some(landed);
        self.hear_complete_cases()
    }

    fn hear_complete_cases(&mut self) -> Result<(), ValidateError> {
        while let Some(case) = self.cases.get(self.next) {
            let of_case = |index: &usize| self.passages[*index].case_index == self.next;
            let of_case: Vec<usize> = (0..self.passages.len()).filter(of_case).collect();
            if of_case.iter().any(|&index| self.landed[index].is_none()) {
                break;
            }
            self.next += 1;
            if of_case.is_empty() {
                self.options.console.say(&format!("{}: nothing to do in this tier\n", case.name));
                continue;
            }
            let outcome = self.hear(case, &of_case);
            let page = report::page(case, &outcome, &command(self.options, case));
            write(&self.options.folder.join(format!("{}.md", case.name)), &page)?;
            self.outcomes.push((case, outcome));
            write(&self.options.folder.join(REPORT), &report::json(&self.outcomes))?;
        }
        Ok(())
    }

    /// Measures a case by its runs.
    fn hear(&mut self, case: &Case, runs: &[usize]) -> Outcome {
        self.options.console.say(&format!("\n{}: {}", case.name, case.file.title));
        let mut outcome = Outcome::default();
        let mut results: BTreeMap<String, Vec<RunResults>> = BTreeMap::new();
        for &index in runs {
            let Some(landed) = self.landed[index].take() else { continue };
            if let Some(found) = landed.results {
                results.entry(self.passages[index].run.name.value.clone()).or_default().push(found);
            }
            outcome.runs.push(landed.line);
        }
        let mut wanted: Vec<&RunFile> = runs.iter().map(|&index| self.passages[index].run).collect();
        wanted.dedup_by_key(|run| run.name.value.as_str());
        measure(case, &wanted, &results, &mut outcome, self.options);
        draw(case, &results, &mut outcome, self.options);
        self.options.console.say("");
        outcome
    }

    /// What all cases come to.
    fn judgement(&self) -> Judgement {
        let missed: Vec<&str> = self
            .outcomes
            .iter()
            .filter(|(_, outcome)| outcome.is_missed())
            .map(|(case, _)| case.name.as_str())
            .collect();
        let folder = self.options.folder.display();
        let of_case = |case: &Case| case.file.figures.iter().filter(|figure| figure.must.is_some()).count();
        let measured = |(case, outcome): &(&Case, Outcome)| of_case(case) - outcome.unseen.len();
        let (all, measured): (usize, usize) =
            (self.cases.iter().map(of_case).sum(), self.outcomes.iter().map(measured).sum());
        let unseen = match all - measured {
            0 => String::new(),
            count => format!(
                " ({measured} of {all} figures, {count} are of runs that this tier leaves out or that blew up and may)"
            ),
        };
        self.options.console.say(&if missed.is_empty() {
            format!("all that must be met is met{unseen}; pages and plots in {folder}")
        } else {
            format!("missed: {}{unseen}; pages and plots in {folder}", missed.join(", "))
        });
        if missed.is_empty() { Judgement::Met } else { Judgement::Missed }
    }
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
            if figure.must.is_some() {
                outcome.unseen.push(index);
            }
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
