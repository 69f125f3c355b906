//! Command line of the program.
//!
//! - [`arguments`]: commands and their arguments
//! - [`run_arguments`]: arguments of `run` and `resume`
//! - [`check_arguments`]: arguments of `bench` and `validate`
//! - [`export_arguments`]: arguments of `export`
//! - [`picture_arguments`]: arguments of `render` and `plot`
//! - [`help_arguments`]: arguments of `explain`, `new`, `completions` and `man`
//! - [`commands`]: one function for each command
//! - [`export`]: the command `export`
//! - [`picture_commands`]: `render` and `plot`
//! - [`watch`]: the command `watch` with its arguments
//! - [`sweep`]: the command `sweep` with its arguments
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
pub mod export;
pub mod export_arguments;
pub mod failure;
pub mod help_arguments;
pub mod new_scene;
pub mod picture_arguments;
pub mod picture_commands;
pub mod run_arguments;
pub mod shell;
pub mod sweep;
mod values;
pub mod watch;

use std::ffi::OsString;
use std::process::ExitCode;

use arguments::{Arguments, Command};
use failure::Failure;
use sphecs_run::environment;
use sphecs_run::ranks::launcher;

/// Runs the command line of the process and returns the exit code.
pub fn main() -> ExitCode {
    ExitCode::from(run(std::env::args_os()))
}

/// Runs a command line, the name of the program included, and returns the exit code.
///
/// 0 done, 1 a required band was missed, 2 bad input, 3 the flow diverged, 4 input or output
/// failed, 75 wall-time limit reached, 129 terminal closed, 130 interrupted, 143 terminated,
/// 152 processor time used up.
pub fn run(words: impl IntoIterator<Item = OsString>) -> u8 {
    failure::prepare_messages();
    let arguments = match Arguments::read(words) {
        Ok(arguments) => arguments,
        Err(error) => {
            let _reader_gone = error.print();
            return error.exit_code() as u8;
        }
    };
    if let Err(error) = environment::check() {
        return Failure::from(error).report();
    }
    let is_shared = matches!(arguments.command, Command::Run(_) | Command::Resume(_));
    if let Err(error) = launcher::check(is_shared) {
        return Failure::from(error).report();
    }
    let result = match arguments.command {
        Command::Run(run) => commands::run(&run),
        Command::Resume(resume) => commands::resume(&resume),
        Command::Sweep(arguments) => sweep::sweep(&arguments),
        Command::Watch(arguments) => watch::watch(&arguments),
        Command::Check(check) => commands::check(&check),
        Command::Render(render) => picture_commands::render(&render),
        Command::Plot(plot) => picture_commands::plot(&plot),
        Command::Info(info) => commands::info(&info),
        Command::Export(export) => export::export(&export),
        Command::Pack(pack) => commands::pack(&pack),
        Command::Bench(bench) => commands::bench(&bench),
        Command::Validate(validate) => commands::validate(&validate),
        Command::New(new) => new_scene::new(&new),
        Command::Explain(path) => explain::explain(&path),
        Command::Schema => explain::schema(),
        Command::Completions(completions) => shell::completions(&completions),
        Command::Man(man) => shell::man(&man),
    };
    result.unwrap_or_else(Failure::report)
}
