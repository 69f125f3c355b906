//! Concurrent runs of a validation.
//!
//! Each thread of one pool takes one run after another. While there are at least as many runs as
//! threads, each run has one thread, which avoids the overhead of parallel loops in small steps. A
//! thread without a run helps the remaining ones. The results are bitwise identical either way.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::case::Case;
use super::case_report::RunLine;
use super::measures::RunResults;
use super::schema::{RunFile, Tier};
use super::{ValidateError, ValidateOptions};
use sphecs_output::error::OutputError;
use sphecs_output::paths::SCENE;
use sphecs_output::summary::{Status, Summary, this_build};
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::resume::{self, ResumeOptions};
use sphecs_run::signals::{Signal, Signals};
use sphecs_run::threads::on_threads;
use sphecs_run::{Ending, RunOptions};
use sphecs_scene::model::Scene;

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
    let signals = Signals::listen().map_err(RunError::Signals)?;
    let next = AtomicUsize::new(0);
    let work = || {
        let _guard = StopOnPanic(&signals);
        while signals.received().is_none() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(run) = runs.get(index) else { break };
            if let Some(result) = make_run(&cases[run.case_index], run, options, &signals)? {
                finished(index, result)?;
            }
        }
        Ok(())
    };
    // A broadcast gives each thread one task, which no other thread takes while it waits for parts
    // of a step.
    let endings = on_threads(options.threads, || {
        rayon::broadcast(|_| work().inspect_err(|_: &ValidateError| signals.raise(Signal::Terminate)))
    });
    endings.map_err(RunError::from)?.into_iter().collect::<Result<(), _>>()?;
    Ok(signals.received())
}

/// Guard that stops the concurrent runs on a panic, which is passed on only when all threads are
/// done.
struct StopOnPanic<'a>(&'a Signals);

impl Drop for StopOnPanic<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.raise(Signal::Terminate);
        }
    }
}

/// Earlier run of the same scene in a folder.
enum EarlierRun {
    None,
    /// Stopped or killed.
    Incomplete,
    Complete,
}

impl EarlierRun {
    /// Returns the state of the run in a folder; runs of other scenes, ends or versions do not
    /// count.
    fn find(scene: &Scene, folder: &Path) -> Self {
        let Ok(summary) = Summary::read(folder) else { return EarlierRun::None };
        let run = &summary.run;
        let same_text = || std::fs::read_to_string(folder.join(SCENE)).is_ok_and(|text| text == scene.text);
        let to_its_end = run.until.is_none() && run.max_steps.is_none();
        if run.version != env!("CARGO_PKG_VERSION") || !to_its_end || !same_text() {
            return EarlierRun::None;
        }
        match summary.status {
            Status::Completed => EarlierRun::Complete,
            Status::Running | Status::Interrupted | Status::Terminated | Status::OutOfTime => {
                EarlierRun::Incomplete
            }
            Status::Diverged | Status::Failed => EarlierRun::None,
        }
    }
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
    let earlier = if options.reuse { EarlierRun::find(&scene, folder) } else { EarlierRun::None };
    let ending = match earlier {
        EarlierRun::Complete => Ok(Ending::Completed),
        EarlierRun::Incomplete => resume_or_restart(scene, folder, signals),
        EarlierRun::None => {
            sphecs_run::run_on_current_pool(scene, &run_options(folder), concurrent(signals)?)
        }
    };
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

fn concurrent(signals: &Signals) -> Result<Signals, RunError> {
    signals.for_concurrent_run().map_err(RunError::Signals)
}

fn run_options(folder: &Path) -> RunOptions {
    RunOptions {
        folder: folder.to_path_buf(),
        force: true,
        threads: None,
        until: None,
        max_steps: None,
        checkpoint_every: None,
        max_wall_time: None,
        allow_oversize: false,
        console: Console::Quiet,
    }
}

fn resume_or_restart(scene: Scene, folder: &Path, signals: &Signals) -> Result<Ending, RunError> {
    let run = run_options(folder);
    let options = ResumeOptions { run, sets: Vec::new(), allow_other_isa: false };
    match resume::resume_on_current_pool(&options, concurrent(signals)?) {
        // The checkpoints are damaged, or of another format or machine, so the run starts again.
        // Other errors, such as a full disk, would occur again and leave the incomplete run as it
        // is.
        Err(RunError::Output(OutputError::Request(_) | OutputError::Damaged { .. })) => {
            sphecs_run::run_on_current_pool(scene, &options.run, concurrent(signals)?)
        }
        ending => ending,
    }
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
