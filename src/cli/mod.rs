//! Command line of the program.
//!
//! - [`arguments`]: commands and their arguments
//! - [`run_arguments`]: arguments of `run` and `resume`
//! - [`check_arguments`]: arguments of `bench` and `validate`
//! - [`help_arguments`]: arguments of `explain`, `new`, `completions` and `man`
//! - [`commands`]: one function for each command
//! - [`explain`], [`new_scene`], [`shell`]: commands that help to write scenes and command lines
//! - `command_line_page`: page of the manual
//! - `values`: values of arguments
//! - [`failure`]: messages and exit codes

pub mod arguments;
pub mod check_arguments;
#[cfg(test)]
mod command_line_page;
pub mod commands;
pub mod explain;
pub mod failure;
pub mod help_arguments;
pub mod new_scene;
pub mod run_arguments;
pub mod shell;
mod values;

use std::process::ExitCode;

use arguments::{Arguments, Command};
use failure::Failure;
use sphecs_core::math::lanes::InstructionSet;
use sphecs_output::error::OutputError;

/// Reads the command line, runs the command and returns the exit code.
///
/// 0 done, 1 a required band was missed, 2 bad input, 3 the flow diverged, 4 input or output
/// failed, 75 wall-time limit reached, 129 terminal closed, 130 interrupted, 143 terminated,
/// 152 processor time used up.
pub fn main() -> ExitCode {
    failure::prepare_messages();
    let arguments = match Arguments::read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(error) => {
            let _reader_gone = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    if let Err(failure) = check_environment() {
        return failure.report();
    }
    let result = match arguments.command {
        Command::Run(run) => commands::run(&run),
        Command::Resume(resume) => commands::resume(&resume),
        Command::Check(check) => commands::check(&check),
        Command::Render(render) => commands::render(&render),
        Command::Info(info) => commands::info(&info),
        Command::Export(export) => commands::export(&export),
        Command::Pack(pack) => commands::pack(&pack),
        Command::Bench(bench) => commands::bench(&bench),
        Command::Validate(validate) => commands::validate(&validate),
        Command::New(new) => new_scene::new(&new),
        Command::Explain(path) => explain::explain(&path),
        Command::Schema => explain::schema(),
        Command::Completions(completions) => shell::completions(&completions),
        Command::Man(man) => shell::man(&man),
    };
    result.map_or_else(Failure::report, ExitCode::from)
}

/// Checks the environment variables that change a run, which libraries ignore if they are misspelt.
fn check_environment() -> Result<(), Failure> {
    let value = |name| std::env::var_os(name).unwrap_or_default().to_string_lossy().into_owned();
    let refused = |name: &str, what: String| {
        OutputError::Request(format!("environment variable `{name}`: {what}; or unset it"))
    };
    let (lanes, threads) = ("SPHECS_LANES", "RAYON_NUM_THREADS");
    InstructionSet::named(&value(lanes)).map_err(|what| refused(lanes, what))?;
    let number = value(threads);
    if !number.is_empty() && number.parse::<usize>().is_err() {
        return Err(refused(threads, format!("is `{number}`, must be a whole number")).into());
    }
    Ok(())
}
