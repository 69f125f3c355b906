//! Why a command ends without its result, how it is said and with which code.

use std::io::{IsTerminal, Write};
use std::process::ExitCode;

use miette::{Diagnostic, MietteHandlerOpts, Report};

use sphecs_bench::BenchError;
use sphecs_output::error::OutputError;
use sphecs_run::error::RunError;
use sphecs_scene::faults::SceneErrors;
use sphecs_validate::ValidateError;

/// Done.
pub const DONE: u8 = 0;
/// A case missed a band that must be met.
pub const MISSED: u8 = 1;
/// The command line or the scene is wrong: nothing was written. clap ends with the same code.
pub const BAD_INPUT: u8 = 2;
/// The flow blew up, or an inlet ran out of particles.
pub const FLOW: u8 = 3;
/// A file could not be read or written.
pub const FILES: u8 = 4;

/// The run came to the wall time that the user gave: `sphecs resume` goes on. The custom of `sysexits.h` for "try again".
pub const OUT_OF_TIME: u8 = 75;

/// Width of messages where no terminal has one, characters: paths stay on one line.
const WIDTH: usize = 160;

/// Why a command ends without its result.
#[derive(Debug, thiserror::Error, Diagnostic)]
pub enum Failure {
    /// The scene has faults.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Scene(#[from] SceneErrors),
    /// The run ended early.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Run(#[from] RunError),
    /// Files of a run.
    #[error(transparent)]
    Output(#[from] OutputError),
    /// The bench ended early.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Bench(#[from] BenchError),
    /// The validation ended early.
    #[error(transparent)]
    #[diagnostic(transparent)]
    Validate(#[from] ValidateError),
}

impl Failure {
    /// The exit code.
    pub fn code(&self) -> u8 {
        match self {
            Failure::Scene(_)
            | Failure::Validate(ValidateError::Case(_))
            | Failure::Bench(BenchError::Scene(_) | BenchError::Threads(_)) => BAD_INPUT,
            Failure::Bench(BenchError::Flow { .. }) => FLOW,
            Failure::Run(error) | Failure::Validate(ValidateError::Run(error)) => code_of_run(error),
            Failure::Output(error) | Failure::Validate(ValidateError::Output(error)) => code_of_output(error),
        }
    }

    /// Prints the failure and gives the exit code.
    pub fn report(self) -> ExitCode {
        let code = self.code();
        // A reader of standard error that is gone is no reason to fail in another way.
        let _reader_gone = writeln!(std::io::stderr(), "{:?}", Report::new(self));
        ExitCode::from(code)
    }
}

fn code_of_run(error: &RunError) -> u8 {
    match error {
        RunError::Threads(_) | RunError::Scene(_) | RunError::Build(_) => BAD_INPUT,
        RunError::Flow { .. } => FLOW,
        RunError::Signals(_) => FILES,
        RunError::Output(error) => code_of_output(error),
    }
}

/// What the user can mend on the command line is bad input; what the system refuses is a matter of files.
fn code_of_output(error: &OutputError) -> u8 {
    match error {
        OutputError::Exists { .. }
        | OutputError::Foreign { .. }
        | OutputError::NotARun { .. }
        | OutputError::Request(_) => BAD_INPUT,
        OutputError::Io { .. }
        | OutputError::NetCdf { .. }
        | OutputError::Busy { .. }
        | OutputError::NoRoom { .. }
        | OutputError::Damaged { .. } => FILES,
    }
}

/// Makes messages as wide as the terminal, and keeps them on long lines elsewhere, where scripts read them.
pub fn prepare_messages() {
    let set = miette::set_hook(Box::new(|_| {
        let options = MietteHandlerOpts::new();
        let options = if std::io::stderr().is_terminal() { options } else { options.width(WIDTH) };
        Box::new(options.build())
    }));
    // The hook can be set once in a process: a second command in the same one finds it as it wants it.
    let _already_set = set;
    std::panic::set_hook(Box::new(|panic| {
        let place = panic.location().map_or_else(String::new, |place| format!(" at {place}"));
        let what = panic.payload_as_str().unwrap_or("no message");
        let _reader_gone = writeln!(
            std::io::stderr(),
            "sphecs has a fault of its own{place}: {what}\nplease report it with the scene and the command line"
        );
    }));
}
