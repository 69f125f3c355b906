//! Validation: named cases are run, measured and compared with their references.
//!
//! ```text
//! case file ─ case (checked) ─▶ runs of shipped scenes ─ measures ─▶ figures
//!     ─ verdict ─▶ console, pages, plots, report.json
//! ```
//!
//! - [`schema`]: notation of a case file
//! - [`case`]: cases, shipped or read from a file
//! - `check`: faults of a case
//! - `runner`: concurrent runs
//! - [`measures`]: figures computed from the results of runs
//! - [`exact`]: exact solutions
//! - [`verdict`]: bands and verdicts
//! - `evaluation`: measurement of the cases, pages and plots
//! - [`case_page`], [`case_report`], [`plot`], `picture`: files that a validation leaves
//!
//! To add a case, add `assets/validation/NAME.ron`. Its runs are scenes of `scenes/`; its
//! references are formulas, exact solutions, tables in the folder of the case or other runs. No
//! code is needed.

pub mod case;
pub mod case_page;
pub mod case_report;
mod check;
mod evaluation;
pub mod exact;
pub mod measures;
mod picture;
pub mod plot;
mod runner;
pub mod schema;
pub mod verdict;

use std::path::PathBuf;
use std::sync::{Mutex, PoisonError};

use miette::Diagnostic;

use case::{Case, CaseFaults, shipped_text};
use evaluation::Evaluator;
use runner::CaseRun;
use schema::Tier;

use sphecs_output::error::OutputError;
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::signals::Signal;
use sphecs_scene::faults::SceneErrors;

/// Options of a validation.
#[derive(Clone, Debug)]
pub struct ValidateOptions {
    /// Names or paths of the cases.
    pub cases: Vec<String>,
    /// Tier of the runs.
    pub tier: Tier,
    /// Folder for runs, pages and plots.
    pub folder: PathBuf,
    /// Reuse completed runs of the same scene and version in the folder, and resume incomplete
    /// ones.
    pub reuse: bool,
    /// Number of threads and of concurrent runs; None: one for each core.
    pub threads: Option<usize>,
    /// Amount of text on standard output.
    pub console: Console,
}

/// Conclusion of a validation.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Conclusion {
    /// Every required band was met.
    Met,
    /// A required band was missed, or a run failed.
    Missed,
    /// A signal stopped the validation.
    Stopped(Signal),
}

/// Error that stops a validation.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum ValidateError {
    /// A case has faults.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Case(#[from] CaseFaults),
    /// The scene of a run has faults.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// A run could not start.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
}

/// Runs and measures the cases and writes pages, plots and `report.json` into the folder.
///
/// # Errors
/// [`ValidateError`]: faults of any case before the first run, and files that cannot be written.
pub fn validate(options: &ValidateOptions) -> Result<Conclusion, ValidateError> {
    // The tests check the scenes of all shipped cases. Those of a case without a run in this tier
    // need not be filled again: a large one takes half a minute.
    let has_no_run = |case: &Case| case.file.runs.iter().all(|run| run.tier > options.tier);
    let loaded = |name: &String| match shipped_text(name) {
        Ok(case) if has_no_run(&case) => Ok(case),
        _ => Case::load(name),
    };
    let cases = options.cases.iter().map(loaded).collect::<Result<Vec<_>, _>>()?;
    let runs_of = |(index, case)| CaseRun::of_case(index, case, options.tier, &options.folder);
    let runs: Vec<CaseRun<'_>> = cases.iter().enumerate().flat_map(runs_of).collect();
    let mut evaluator = Evaluator::new(&cases, &runs, options);
    evaluator.evaluate_complete_cases()?;
    let evaluator = Mutex::new(evaluator);
    let stopped = runner::run_all(&cases, &runs, options, |index, finished| {
        evaluator.lock().unwrap_or_else(PoisonError::into_inner).add(index, finished)
    })?;
    if let Some(signal) = stopped {
        return Ok(Conclusion::Stopped(signal));
    }
    Ok(evaluator.into_inner().unwrap_or_else(PoisonError::into_inner).conclusion())
}
