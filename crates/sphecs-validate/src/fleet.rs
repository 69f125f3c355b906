//! The runs of a validation, side by side.
//!
//! Every thread of one pool takes a run after the other. While there are as many runs as threads, each has a thread of its own,
//! which loses nothing to small steps; a thread that finds no run left helps those still under way. What flows has the same
//! bits either way.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicUsize, Ordering};

use super::case::Case;
use super::report::RunLine;
use super::schema::{RunFile, Tier};
use super::value::RunResults;
use super::{ValidateError, ValidateOptions};
use sphecs_output::error::OutputError;
use sphecs_output::summary::{Status, Summary, this_build};
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::resume::{self, ResumeOptions};
use sphecs_run::signals::{Signal, Signals};
use sphecs_run::threads::on_threads;
use sphecs_run::{Ending, RunOptions};
use sphecs_scene::model::Scene;

/// A run to be made: a member of one of a case's.
#[derive(Clone, Debug)]
pub struct Passage<'a> {
    /// Place of its case among all.
    pub case_index: usize,
    /// The run.
    pub run: &'a RunFile,
    name: String,
    set: Vec<(String, String)>,
    folder: PathBuf,
}

impl<'a> Passage<'a> {
    /// Returns the runs of a case in a tier, all their members.
    pub fn of_case(case_index: usize, case: &'a Case, tier: Tier, folder: &Path) -> Vec<Self> {
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

/// A run that was made.
#[derive(Debug)]
pub struct Landed {
    /// What the page says of it.
    pub line: RunLine,
    /// What it left, unless it failed.
    pub results: Option<RunResults>,
}

/// Makes all runs; `land` has each as it ends, with its place in the list, from the thread that made it. Returns the signal that stopped them.
///
/// # Errors
/// The first error of any run or of `land`; the runs beside it end as by a signal.
pub fn sail_all(
    cases: &[Case],
    passages: &[Passage<'_>],
    options: &ValidateOptions,
    land: impl Fn(usize, Landed) -> Result<(), ValidateError> + Sync,
) -> Result<Option<Signal>, ValidateError> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    let next = AtomicUsize::new(0);
    let take = || {
        let _guard = StopOthers(&signals);
        while signals.received().is_none() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some(passage) = passages.get(index) else { break };
            if let Some(landed) = sail(&cases[passage.case_index], passage, options, &signals)? {
                land(index, landed)?;
            }
        }
        Ok(())
    };
    // Of a broadcast each thread has one share, which no other takes while it waits for parts of a step.
    let endings = on_threads(options.threads, || {
        rayon::broadcast(|_| take().inspect_err(|_: &ValidateError| signals.raise(Signal::Terminate)))
    });
    endings.map_err(RunError::from)?.into_iter().collect::<Result<(), _>>()?;
    Ok(signals.received())
}

/// Stops the runs beside one that panics: the panic is handed on only when all threads are done.
struct StopOthers<'a>(&'a Signals);

impl Drop for StopOthers<'_> {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.raise(Signal::Terminate);
        }
    }
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
        let to_its_end = run.until.is_none() && run.max_steps.is_none();
        if run.version != env!("CARGO_PKG_VERSION") || !to_its_end || !same_text() {
            return Earlier::Nothing;
        }
        match summary.status {
            Status::Completed => Earlier::Whole,
            Status::Running | Status::Interrupted | Status::Terminated | Status::OutOfTime => Earlier::Begun,
            Status::Diverged | Status::Failed => Earlier::Nothing,
        }
    }
}

/// Sails one run, goes on with one that was begun, or takes an earlier one; None when a signal stopped it.
fn sail(
    case: &Case,
    passage: &Passage<'_>,
    options: &ValidateOptions,
    signals: &Signals,
) -> Result<Option<Landed>, ValidateError> {
    let folder = &passage.folder;
    let scene = case.member_scene(passage.run, &passage.set)?;
    let earlier = if options.reuse { Earlier::of(&scene, folder) } else { Earlier::Nothing };
    let ending = match earlier {
        Earlier::Whole => Ok(Ending::Completed),
        Earlier::Begun => go_on(scene, folder, signals),
        Earlier::Nothing => sphecs_run::run_on_current_pool(scene, &run_options(folder), beside(signals)?),
    };
    let failure = match ending {
        Ok(Ending::Completed | Ending::OutOfTime) => None,
        Ok(Ending::Stopped(_)) => return Ok(None),
        Err(RunError::Flow { stop, .. }) => Some(stop.to_string()),
        Err(error) => return Err(error.into()),
    };
    let results = RunResults::read(folder)?;
    let line = run_line(passage, &results.summary, failure);
    let results = line.failure.is_none().then_some(results);
    Ok(Some(Landed { line, results }))
}

fn beside(signals: &Signals) -> Result<Signals, RunError> {
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

fn go_on(scene: Scene, folder: &Path, signals: &Signals) -> Result<Ending, RunError> {
    let run = run_options(folder);
    let options = ResumeOptions { run, sets: Vec::new(), allow_other_isa: false };
    match resume::resume_on_current_pool(&options, beside(signals)?) {
        // Nothing to go on from: its checkpoints are damaged, of another layout or of another machine. What else may
        // fail, a full disk say, would fail again, and leaves what was begun.
        Err(RunError::Output(OutputError::Request(_) | OutputError::Damaged { .. })) => {
            sphecs_run::run_on_current_pool(scene, &options.run, beside(signals)?)
        }
        ending => ending,
    }
}

fn run_line(passage: &Passage<'_>, summary: &Summary, failure: Option<String>) -> RunLine {
    let ledger = &summary.ledger;
    RunLine {
        name: passage.name.clone(),
        scene: passage.run.scene.value.clone(),
        set: passage.set.clone(),
        particles: ledger.fluid + ledger.wall + ledger.inflow + ledger.outflow,
        steps: summary.steps,
        wall_time: summary.wall_time,
        threads: summary.threads,
        lanes: summary.lanes.clone(),
        notes: summary.notes.clone(),
        of_another_build: summary.build != this_build(),
        failure,
        may_fail: passage.run.may_fail,
    }
}
