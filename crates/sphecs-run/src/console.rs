//! Text output of a run on the terminal.

use std::io::{self, Write};

/// Amount of text on standard output.
///
/// `println!` panics when the reader is gone (`sphecs info runs/a | head -1`). A run must outlive
/// its reader, so a failed write is ignored here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Console {
    /// Nothing; errors go to standard error.
    Quiet,
    /// Start, progress, notes and end.
    Normal,
    /// As [`Console::Normal`], with a line per frame and per checkpoint.
    Verbose,
}

impl Console {
    /// Prints a block of text and a line end and flushes, so that a log is complete up to its last
    /// line.
    pub fn print(self, text: &str) {
        if self != Console::Quiet {
            let mut out = io::stdout().lock();
            let _reader_gone = writeln!(out, "{text}").and_then(|()| out.flush());
        }
    }

    /// Prints a line on standard error, also when quiet.
    pub fn warn(self, text: &str) {
        let _reader_gone = writeln!(io::stderr(), "{text}");
    }
}
