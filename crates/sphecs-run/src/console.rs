//! Where the words of a run go.

use std::io::{self, Write};

/// Standard output, unless the user wants silence.
///
/// `println!` panics when the reader is gone (`sphecs info runs/a | head -1`); a run must outlive
/// its reader, so that a failed write is passed over here.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Console {
    /// Nothing is printed; errors go to standard error by another way.
    Quiet,
    /// What a user wants to know.
    Normal,
    /// A line per frame as well.
    Verbose,
}

impl Console {
    /// Prints a block of text and a line end, at once: a log is complete up to the last line whatever happens next.
    pub fn say(self, text: &str) {
        if self != Console::Quiet {
            let mut out = io::stdout().lock();
            let _reader_gone = writeln!(out, "{text}").and_then(|()| out.flush());
        }
    }

    /// Prints a line on standard error, which a quiet user sees too: what was found wrong and passed over.
    pub fn warn(self, text: &str) {
        let _reader_gone = writeln!(io::stderr(), "{text}");
    }
}
