//! Runs of a validation, several at once.

use std::path::{Path, PathBuf};

use super::case::Case;
use super::case_report::RunLine;
use super::measures::RunResults;
use super::schema::{RunFile, Tier};
use super::{ValidateError, ValidateOptions};
use sphecs_output::summary::{Summary, this_build};
use sphecs_run::Ending;
use sphecs_run::concurrent::{self, on_all_threads};
use sphecs_run::error::RunError;
use sphecs_run::signals::{Signal, Signals};

/// Run to be made: one member of the ensemble of a run of a case.
#[derive(Clone, Debug)]
pub(crate) struct CaseRun<'a> {
    /// Index of the case among all.
    pub case_index: usize,
    /// Run in the case file.
    pub run: &'a RunFile,
    name: String,
    set: Vec<(String, String)>,
    folder: PathBuf,
}

impl<'a> CaseRun<'a> {
    /// Returns the runs of a case in a tier with all their members.
    pub(crate) fn of_case(case_index: usize, case: &'a Case, tier: Tier, folder: &Path) -> Vec<Self> {
        let wanted = case.file.runs.iter().filter(|run| run.tier <= tier);
        let members =
            wanted.flat_map(|run| run.members(tier).into_iter().enumerate().map(move |member| (run, member)));
        members
            .map(|(run, (member, set))| {
                let name = run.member_name(member);
                let folder = folder.join(&case.name).join(&name);
                Self { case_index, run, name, set, folder }
            })
            .collect()
    }
}

/// Run that has ended.
#[derive(Debug)]
pub(crate) struct FinishedRun {
    /// Line of the page.
    pub line: RunLine,
    /// Results; None after a failure.
    pub results: Option<RunResults>,
}

/// Makes all runs and calls `finished` with the index and the result of each, on the thread that
/// made it.
///
/// Returns the signal that stopped the runs.
///
/// # Errors
/// The first error of any run or of `finished`; the concurrent runs end as by a signal.
pub(crate) fn run_all(
    cases: &[Case],
    runs: &[CaseRun<'_>],
    options: &ValidateOptions,
    finished: impl Fn(usize, FinishedRun) -> Result<(), ValidateError> + Sync,
) -> Result<Option<Signal>, ValidateError> {
    on_all_threads(runs.len(), options.threads, |index, signals| {
        let run = &runs[index];
        match make_run(&cases[run.case_index], run, options, signals)? {
            Some(result) => finished(index, result),
            None => Ok(()),
        }
    })
}

/// Makes, resumes or reuses one run; None when a signal stopped it.
fn make_run(
    case: &Case,
    run: &CaseRun<'_>,
    options: &ValidateOptions,
    signals: &Signals,
) -> Result<Option<FinishedRun>, ValidateError> {
    let folder = &run.folder;
    let scene = case.member_scene(run.run, &run.set)?;
    let ending = concurrent::make_run(scene, folder, options.reuse, signals);
    let failure = match ending {
        Ok(Ending::Completed | Ending::OutOfTime) => None,
        Ok(Ending::Stopped(_)) => return Ok(None),
        Err(RunError::Flow { stop, .. }) => Some(stop.to_string()),
        Err(error) => return Err(error.into()),
    };
    let results = RunResults::read(folder)?;
    let line = run_line(run, &results.summary, failure);
    let results = line.failure.is_none().then_some(results);
    Ok(Some(FinishedRun { line, results }))
}

fn run_line(run: &CaseRun<'_>, summary: &Summary, failure: Option<String>) -> RunLine {
    let ledger = &summary.ledger;
    RunLine {
        name: run.name.clone(),
        scene: run.run.scene.value.clone(),
        set: run.set.clone(),
        particles: ledger.fluid + ledger.wall + ledger.inflow + ledger.outflow,
        steps: summary.steps,
        wall_time: summary.wall_time,
        threads: summary.threads,
        lanes: summary.lanes.clone(),
        notes: summary.notes.clone(),
        of_another_build: summary.build != this_build(),
        failure,
        may_fail: run.run.may_fail,
    }
}
