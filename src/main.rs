//! The program `sphecs`: see [`sphecs::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    sphecs::cli::main()
}
