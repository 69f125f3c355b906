//! The command line: what the user asks for, and how it is answered.
//!
//! Rooms: `arguments` (what may stand on the command line), `runs` (the same of `run` and `resume`), `trials` (of `bench` and `validate`), `commands` (one
//! function for each), `failure` (messages and exit codes).

pub mod arguments;
pub mod commands;
pub mod failure;
pub mod runs;
pub mod trials;

use std::process::ExitCode;

use arguments::{Arguments, Command};

/// Reads the command line, does what it says and gives the exit code: 0 done, 1 a case missed its band, 2 bad input, 3 the flow blew up,
/// 4 input or output failed, 75 out of wall time, 130 interrupted, 143 terminated.
pub fn main() -> ExitCode {
    failure::prepare_messages();
    let arguments = match Arguments::read(std::env::args_os()) {
        Ok(arguments) => arguments,
        Err(error) => {
            let _reader_gone = error.print();
            return ExitCode::from(error.exit_code() as u8);
        }
    };
    let answer = match arguments.command {
        Command::Run(run) => commands::run(&run),
        Command::Resume(resume) => commands::resume(&resume),
        Command::Check(check) => commands::check(&check),
        Command::Render(render) => commands::render(&render),
        Command::Info(info) => commands::info(&info),
        Command::Export(export) => commands::export(&export),
        Command::Pack(pack) => commands::pack(&pack),
        Command::Bench(bench) => commands::bench(&bench),
        Command::Validate(validate) => commands::validate(&validate),
    };
    answer.map_or_else(failure::Failure::report, ExitCode::from)
}
