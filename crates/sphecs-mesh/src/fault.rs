//! Fault of a mesh file, with its place, or of the surface that files form together.

use std::fmt;

use thiserror::Error;

/// Place of a fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file or the surface as a whole.
    Whole,
    /// Offset in a binary file, bytes from 0.
    Byte(u64),
    /// Position in a text file.
    Text {
        /// Line, from 1.
        line: u64,
        /// Byte of the line, from 1.
        column: u64,
    },
    /// Number of a facet in the file, from 1.
    Facet(u64),
    /// Number of a vertex in the file, from 1.
    Vertex(u64),
}

/// Fault of a mesh: file, place, and a sentence of what is, what must be and what to do.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
#[error("{file}{place}: {message}")]
pub struct Fault {
    /// Name of the file, or of the files of a surface.
    pub file: String,
    /// Place in the file.
    pub place: Place,
    /// Value found, value allowed and advice, in one line.
    pub message: String,
}

impl Fault {
    /// Returns a fault at a place of a file.
    pub(crate) fn new(file: &str, place: Place, message: impl Into<String>) -> Self {
        Self { file: file.to_owned(), place, message: message.into() }
    }
}

/// Writes the place as it follows the name of the file.
impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Byte(byte) => write!(f, ": byte {byte}"),
            Self::Text { line, column } => write!(f, ":{line}:{column}"),
            Self::Facet(number) => write!(f, ": facet {number}"),
            Self::Vertex(number) => write!(f, ": vertex {number}"),
        }
    }
}
