//! Errors that stop a run.

use miette::Diagnostic;

use sphecs_engine::simulation::{BuildError, Stop};
use sphecs_output::error::OutputError;
use sphecs_scene::faults::SceneErrors;

/// Error that stops a run.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum RunError {
    /// The flow cannot be advanced further; everything written before is readable.
    #[error("{stop}")]
    #[diagnostic(help("{cure}{report}"))]
    Flow {
        /// Reason, with step, time, particle, zone and position.
        stop: Stop,
        /// Advice to the user.
        cure: String,
        /// Particle that diverged and the results kept, printed after the advice.
        report: String,
    },
    /// The simulation could not be built.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The scene of a run to be resumed has faults, for example a value given by `--set`.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// The threads could not be started.
    #[error("cannot start the threads: {0}")]
    #[diagnostic(help("give a smaller number by `--threads`"))]
    Threads(#[from] rayon::ThreadPoolBuildError),
    /// The ranks cannot share the run.
    #[error("{0}")]
    Ranks(String),
    /// The signal handlers could not be set.
    #[error("cannot set the signal handlers: {0}")]
    Signals(std::io::Error),
}
