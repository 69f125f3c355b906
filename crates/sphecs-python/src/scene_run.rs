//! Run of a scene to its end into a run folder, and the command line of the engine.
//!
//! The run is that of `sphecs run`, on a thread of its own. The thread of the caller looks for
//! Ctrl-C meanwhile: the handlers of signals belong to Python, and it calls them on its main thread
//! alone.

use std::ffi::OsString;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::Duration;

use pyo3::{FromPyObject, Py, PyAny, PyErr, PyResult, Python, pyfunction};

use crate::callable::{CallableForces, Failure, Functions};
use crate::exceptions::{error_of_run, output_error, run_error};
use crate::guard::internal_error;
use crate::scene_input::SceneInput;
use sphecs::{Plugin, Scene};
use sphecs_run::console::Console;
use sphecs_run::error::RunError;
use sphecs_run::ranks::RankSource;
use sphecs_run::signals::{Signal, Signals};
use sphecs_run::threads::on_threads;
use sphecs_run::{Ending, RunOptions, default_folder, environment, memory, run_with_plugins};

/// Time between two looks for Ctrl-C.
const LOOK: Duration = Duration::from_millis(50);

/// Options of a run, named as those of the command line.
#[derive(Clone, Debug, FromPyObject)]
pub(crate) struct Options {
    #[pyo3(item)]
    out: Option<PathBuf>,
    #[pyo3(item)]
    force: bool,
    #[pyo3(item)]
    threads: Option<usize>,
    #[pyo3(item)]
    ranks: Option<usize>,
    #[pyo3(item)]
    until: Option<f64>,
    #[pyo3(item)]
    steps: Option<u64>,
    #[pyo3(item)]
    checkpoint_every: Option<f64>,
    #[pyo3(item)]
    max_walltime: Option<f64>,
    #[pyo3(item)]
    allow_oversize: bool,
    #[pyo3(item)]
    verbosity: String,
}

impl Options {
    fn console(&self) -> Console {
        match self.verbosity.as_str() {
            "normal" => Console::Normal,
            "verbose" => Console::Verbose,
            _ => Console::Quiet,
        }
    }
}

/// Runs a scene to its end, with forces of the caller, and returns its folder.
#[pyfunction]
pub(crate) fn run(
    py: Python<'_>,
    scene: SceneInput,
    forces: Vec<Py<PyAny>>,
    options: Options,
) -> PyResult<PathBuf> {
    environment::check().map_err(|error| output_error(py, &error))?;
    let memory = memory::available().filter(|_| !options.allow_oversize);
    let shown = scene.shown();
    let scene = scene.load(py, memory)?;
    let folder = match &options.out {
        Some(folder) => folder.clone(),
        None => default_folder(&scene.name).map_err(|error| output_error(py, &error))?,
    };
    let options = RunOptions {
        folder: folder.clone(),
        force: options.force,
        threads: options.threads,
        ranks: RankSource::InProcess(options.ranks.unwrap_or(1)),
        until: options.until,
        max_steps: options.steps,
        checkpoint_every: options.checkpoint_every,
        max_wall_time: options.max_walltime,
        allow_oversize: options.allow_oversize,
        console: options.console(),
    };
    let ended = run_watched(py, scene, forces, options)?;
    ended.map(|_ending| folder).map_err(|error| error_of_run(py, &shown, error))
}

/// Runs a scene on another thread and asks the run to stop when Python has a signal to handle; the
/// exception of its handler, or that of a force, is raised when the files of the run are closed.
fn run_watched(
    py: Python<'_>,
    scene: Scene,
    forces: Vec<Py<PyAny>>,
    options: RunOptions,
) -> PyResult<Result<Ending, RunError>> {
    let signals = Signals::without_handlers();
    let obeyed = signals.shared();
    let failure = Failure::default();
    let mut plugins: Vec<Box<dyn Plugin + Send>> = Vec::new();
    if !forces.is_empty() {
        plugins.push(Box::new(CallableForces {
            functions: Functions::new(forces),
            dimensions: scene.dimensions,
            failure: failure.clone(),
        }));
    }
    let (ended, mut end) = channel::<()>();
    let work = move || {
        // Dropped when the run ends, also by a panic.
        let _ended = ended;
        on_threads(options.ranks.threads(options.threads), || {
            run_with_plugins(scene, plugins, &options, obeyed)
        })?
    };
    let run = thread::Builder::new()
        .name("run".to_owned())
        .spawn(work)
        .map_err(|error| run_error(py, "threads", format!("cannot start the thread of the run: {error}")))?;
    let mut interrupt: Option<PyErr> = None;
    let mut look = || {
        let end = &mut end;
        py.detach(move || end.recv_timeout(LOOK)) == Err(RecvTimeoutError::Timeout)
    };
    while look() {
        if let Err(error) = py.check_signals() {
            signals.raise(Signal::Interrupt);
            interrupt.get_or_insert(error);
        }
    }
    let ended = py.detach(|| run.join());
    let interrupt = interrupt.or_else(|| failure.take());
    match (interrupt, ended) {
        (Some(interrupt), _) => Err(interrupt),
        (None, Ok(ended)) => Ok(ended),
        (None, Err(panic)) => Err(internal_error(py, panic.as_ref())),
    }
}

/// Runs the command line of the engine, the name of the program included, and returns its exit
/// code. For a process of its own: it sets handlers of signals, which stay.
#[pyfunction]
pub(crate) fn command_line(py: Python<'_>, words: Vec<OsString>) -> u8 {
    py.detach(|| sphecs::cli::run(words))
}
