//! Why a run ended before its end.

use miette::Diagnostic;

use sphecs_engine::simulation::{BuildError, Stop};
use sphecs_output::error::OutputError;
use sphecs_scene::faults::SceneErrors;

/// Why a run ended before its end.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum RunError {
    /// The flow cannot go on; everything written before is readable.
    #[error("{stop}")]
    #[diagnostic(help("{cure}{kept}"))]
    Flow {
        /// What happened, with step, time, particle, zone and position.
        stop: Stop,
        /// What a user can do about it.
        cure: String,
        /// What is left of the run, as a sentence after the cure.
        kept: String,
    },
    /// The simulation could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A file could not be written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scene of a run that is to be gone on with has faults, as by `--set`.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    #[diagnostic(help("give a smaller number by `--threads`"))]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The signal handlers could not be set.
    #[error("cannot listen to signals: {0}")]
    Signals(std::io::Error),
}
