//! Failures of a command, with their messages and exit codes.

use std::io::{IsTerminal, Write};

use miette::{Diagnostic, MietteHandlerOpts, Report};

use sphecs_bench::BenchError;
use sphecs_output::error::OutputError;
use sphecs_run::error::RunError;
use sphecs_run::sweep::SweepError;
use sphecs_scene::faults::SceneErrors;
use sphecs_scene::manual::UnknownPath;
use sphecs_validate::ValidateError;

/// Exit code of a completed command.
pub const DONE: u8 = 0;
/// Exit code of a validation that missed a required band, and of a strict check with notes.
pub const MISSED: u8 = 1;
/// Exit code of a faulty command line or scene, before anything is written; also that of clap.
pub const BAD_INPUT: u8 = 2;
/// Exit code of a flow that diverged or an inlet that ran out of particles.
pub const FLOW: u8 = 3;
/// Exit code of a file that could not be read or written.
pub const FILES: u8 = 4;

/// Exit code of a run at its wall-time limit, which `sphecs resume` continues; "try again" in
/// `sysexits.h`.
pub const OUT_OF_TIME: u8 = 75;

/// Width of messages without a terminal, characters: paths stay on one line.
const WIDTH: usize = 160;

/// Failure of a command.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum Failure {
    /// The scene has faults.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// A path is not one of the scene file.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Path(#[from] UnknownPath),
    /// A run was stopped by an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// A sweep was stopped by an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Sweep(#[from] SweepError),
    /// A file could not be read or written.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// A bench was stopped by an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Bench(#[from] BenchError),
    /// A validation was stopped by an error.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Validate(#[from] ValidateError),
}

impl Failure {
    /// Returns the exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Scene(_)
            | Failure::Path(_)
            | Failure::Sweep(SweepError::Scene { .. })
            | Failure::Validate(ValidateError::Case(_) | ValidateError::Scene(_))
            | Failure::Bench(BenchError::Scene(_) | BenchError::Threads(_)) => BAD_INPUT,
            Failure::Bench(BenchError::Flow { .. }) => FLOW,
            Failure::Run(error)
            | Failure::Validate(ValidateError::Run(error))
            | Failure::Sweep(SweepError::Run(error)) => code_of_run(error),
            Failure::Output(error)
            | Failure::Validate(ValidateError::Output(error))
            | Failure::Sweep(SweepError::Output(error)) => code_of_output(error),
        }
    }

    /// Prints the failure and returns the exit code.
    pub fn report(self) -> u8 {
        let code = self.code();
        // A closed standard error must not cause another failure.
        let _reader_gone = writeln!(std::io::stderr(), "{:?}", Report::new(self));
        code
    }
}

fn code_of_run(error: &RunError) -> u8 {
    match error {
        RunError::Threads(_) | RunError::Ranks(_) | RunError::Scene(_) | RunError::Build(_) => BAD_INPUT,
        RunError::Flow { .. } => FLOW,
        RunError::Signals(_) => FILES,
        RunError::Output(error) => code_of_output(error),
    }
}

/// Returns the exit code of an error: bad input if the user can correct the command line, else a
/// file error.
fn code_of_output(error: &OutputError) -> u8 {
    match error {
        OutputError::Exists { .. }
        | OutputError::Foreign { .. }
        | OutputError::NotARun { .. }
        | OutputError::Request(_) => BAD_INPUT,
        OutputError::Io { .. }
        | OutputError::NetCdf { .. }
        | OutputError::Busy { .. }
        | OutputError::DiskFull { .. }
        | OutputError::Damaged { .. } => FILES,
    }
}

/// Sets the width of messages to that of the terminal, or to long lines for scripts, and the
/// message of a panic.
pub fn prepare_messages() {
    let set = miette::set_hook(Box::new(|_| {
        let options = MietteHandlerOpts::new();
        let options = if std::io::stderr().is_terminal() { options } else { options.width(WIDTH) };
        Box::new(options.build())
    }));
    // The hook can be set once in a process; a second command finds it set as needed.
    let _already_set = set;
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map_or_else(String::new, |place| format!(" at {place}"));
        let what = panic.payload_as_str().unwrap_or("no message");
        let _reader_gone = writeln!(
            std::io::stderr(),
            "internal error in sphecs{place}: {what}\nplease report it with the scene and the command line"
        );
    }));
}
