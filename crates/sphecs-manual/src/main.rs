//! The program `sphecs-manual`: builds the book in `docs/book` of the current folder.
//!
//! ```sh
//! sphecs-manual [FOLDER]     # the folder of the built book, `target/book` by default
//! ```
//!
//! Faults of pages are printed with file, line and column. Exit code: 0 without faults, 1 with
//! faults, 2 if the book cannot be built.

use std::io::{self, Write};
use std::path::PathBuf;
use std::process::ExitCode;

use sphecs_manual::builder::build;

fn main() -> ExitCode {
    let built = std::env::args_os().nth(1).map_or_else(|| PathBuf::from("target/book"), PathBuf::from);
    // mdBook takes a relative folder as one inside the sources.
    let folders = std::env::current_dir().and_then(|root| Ok((root, std::path::absolute(built)?)));
    let (text, code) = match folders.map(|(root, built)| (build(&root, &built), built)) {
        Ok((Ok(faults), built)) if faults.is_empty() => {
            (built.join("index.html").display().to_string(), ExitCode::SUCCESS)
        }
        Ok((Ok(faults), built)) => {
            let lines: Vec<String> = faults.iter().map(ToString::to_string).collect();
            let end = format!(
                "{} faults; the book with them is {}",
                lines.len(),
                built.join("index.html").display()
            );
            (format!("{}\n{end}", lines.join("\n")), ExitCode::FAILURE)
        }
        Ok((Err(error), _)) => (error.to_string(), ExitCode::from(2)),
        Err(error) => (format!("cannot find the folder of the book: {error}"), ExitCode::from(2)),
    };
    let _reader_gone = writeln!(io::stdout(), "{text}");
    code
}
