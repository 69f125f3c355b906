//! Several runs at once, each in a folder of its own; complete ones are used again, stopped ones
//! resumed.
//!
//! Each thread of one pool takes one run after another. While there are at least as many runs as
//! threads, each run has one thread, which avoids the overhead of parallel loops in small steps. A
//! thread without a run helps the remaining ones. The results are bitwise identical either way.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::console::Console;
use super::error::RunError;
use super::ranks::RankSource;
use super::resume::{self, ResumeOptions};
use super::signals::{Signal, Signals};
use super::threads::on_threads;
use super::{Ending, RunOptions, run_on_current_pool};
use sphecs_output::error::OutputError;
use sphecs_output::paths::SCENE;
use sphecs_output::summary::{Status, Summary};
use sphecs_scene::model::Scene;
use sphecs_scene::notation::same_content::same_content;

/// Does `count` pieces of work, each on one thread, until all are done, one fails or a signal
/// arrives.
///
/// Returns the signal that stopped the work.
///
/// # Errors
/// The first error of any piece; the concurrent runs end as by a signal.
pub fn on_all_threads<E: From<RunError> + Send>(
    count: usize,
    threads: Option<usize>,
    work: impl Fn(usize, &Signals) -> Result<(), E> + Sync,
) -> Result<Option<Signal>, E> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    let next = AtomicUsize::new(0);
    let take = || {
        let _guard = StopOnPanic(&signals);
        while signals.received().is_none() {
            let index = next.fetch_add(1, Ordering::Relaxed);
            if index >= count {
                break;
            }
            work(index, &signals)?;
        }
        Ok(())
    };
    // A broadcast gives each thread one task, which no other thread takes while it waits for parts
    // of a step.
    let endings = on_threads(threads, || {
        rayon::broadcast(|_| take().inspect_err(|_: &E| signals.raise(Signal::Terminate)))
    });
    endings.map_err(RunError::from)?.into_iter().collect::<Result<(), E>>()?;
    Ok(signals.received())
}

/// Makes, resumes or uses again the run of a scene in a folder; without `reuse` it is made.
///
/// # Errors
/// [`RunError`] as of a run.
pub fn make_run(scene: Scene, folder: &Path, reuse: bool, signals: &Signals) -> Result<Ending, RunError> {
    let earlier = if reuse { EarlierRun::find(&scene, folder) } else { EarlierRun::None };
    match earlier {
        EarlierRun::Complete => Ok(Ending::Completed),
        EarlierRun::Incomplete => resume_or_restart(scene, folder, signals),
        EarlierRun::None => run_on_current_pool(scene, &run_options(folder), concurrent(signals)?),
    }
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
        let is_same =
            || std::fs::read_to_string(folder.join(SCENE)).is_ok_and(|text| same_content(&text, &scene.text));
        let to_its_end = run.until.is_none() && run.max_steps.is_none();
        if run.version != env!("CARGO_PKG_VERSION") || !to_its_end || !is_same() {
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

fn concurrent(signals: &Signals) -> Result<Signals, RunError> {
    signals.for_concurrent_run().map_err(RunError::Signals)
}

fn run_options(folder: &Path) -> RunOptions {
    RunOptions {
        folder: folder.to_path_buf(),
        force: true,
        threads: None,
        ranks: RankSource::default(),
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
            run_on_current_pool(scene, &options.run, concurrent(signals)?)
        }
        ending => ending,
    }
}
