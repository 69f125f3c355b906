//! The run loop: from a scene to a folder of results, with a word to the user on the way.
//!
//! Rooms: `voyage` (the loop), `opening` and `report` (what is said at the start and at the end), `display`
//! (progress), `log` (what the loop remembers across a restart), `occasions` (when a checkpoint is due and when time is up), `resume`
//! (a run gone on with), `threads` (what a run computes on), `pace` (speed and time left), `due` (when a frame or row is due),
//! `signals` (Ctrl-C, SIGTERM and SIGUSR1), `console` (where words go), `words` (numbers as people read them), `room` (whether the results find room), `error` (why a run
//! ended early), `wreck` (what is said and kept of a flow that cannot go on).

pub mod console;
pub mod display;
pub mod due;
pub mod error;
pub mod log;
pub mod memory;
pub mod occasions;
pub mod opening;
pub mod pace;
pub mod report;
pub mod resume;
pub mod room;
pub mod signals;
pub mod threads;
pub mod voyage;
pub mod words;
pub mod wreck;

use std::path::PathBuf;

use console::Console;
use error::RunError;
use signals::{Signal, Signals};
use threads::on_threads;
use voyage::Voyage;

use sphecs_output::folder::check_free;
use sphecs_scene::model::Scene;

/// What the user asks of a run beside the scene.
#[derive(Clone, Debug)]
pub struct RunOptions {
    /// Folder for the results.
    pub folder: PathBuf,
    /// Replace an earlier run in the folder.
    pub force: bool,
    /// Threads; None: as many as the machine has cores.
    pub threads: Option<usize>,
    /// End, s, in place of the scene's.
    pub until: Option<f64>,
    /// Most steps.
    pub steps: Option<u64>,
    /// Wall time between checkpoints, s, in place of the scene's.
    pub checkpoint_every: Option<f64>,
    /// Wall time after which the run ends, s.
    pub most_wall_time: Option<f64>,
    /// Begin although the disk has not the room for all results.
    pub allow_oversize: bool,
    /// How much is said.
    pub console: Console,
}

/// How a run ended that was not stopped by an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ending {
    /// At its end, by time or by steps.
    Completed,
    /// A signal stopped it; what was written is whole, and `sphecs resume` goes on.
    Stopped(Signal),
    /// At the wall time that the user gave; `sphecs resume` goes on.
    OutOfTime,
}

/// Runs a scene and leaves its results in a folder.
///
/// # Errors
/// [`RunError`]: before the first step nothing is written; later, what was written stays readable.
pub fn run(scene: Scene, options: &RunOptions) -> Result<Ending, RunError> {
    let signals = Signals::listen().map_err(RunError::Signals)?;
    on_threads(options.threads, || run_here(scene, options, signals))?
}

/// The same on the pool of the thread that calls, whatever threads the options ask for, until these signals stop it.
///
/// # Errors
/// As those of [`run`].
pub fn run_here(scene: Scene, options: &RunOptions, signals: Signals) -> Result<Ending, RunError> {
    // Asked before time is spent on the fill, and again by the folder itself.
    check_free(&options.folder, options.force)?;
    if !options.allow_oversize {
        room::check(&scene, options)?;
    }
    Voyage::begin(scene, options, signals)?.sail()
}
