//! Builder and checker of the manual of sphecs.
//!
//! - [`builder`]: a run of mdBook on a copy of the sources
//! - [`sources`]: pages of the book, among them generated ones, and their places in the repository
//! - [`equations`]: LaTeX as MathML
//! - [`includes`]: files that pages include
//! - [`summary`], [`links`], [`anchors`], [`html`], [`readability`]: checks of the pages
//! - [`fault`], [`paths`], [`markdown`]: faults with their places, paths of links, the parser

pub mod anchors;
pub mod builder;
pub mod equations;
pub mod fault;
pub mod html;
pub mod includes;
pub mod links;
pub mod markdown;
pub mod paths;
pub mod readability;
pub mod sources;
pub mod summary;

use std::io;
use std::path::PathBuf;

/// Error that keeps the book from being built.
#[derive(Debug, thiserror::Error)]
pub enum ManualError {
    /// A file or folder cannot be read.
    #[error("cannot read {}: {source}", path.display())]
    Read {
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// A file or folder cannot be written.
    #[error("cannot write {}: {source}", path.display())]
    Write {
        /// File or folder.
        path: PathBuf,
        /// Cause.
        source: io::Error,
    },
    /// mdBook failed.
    #[error("mdBook: {0}")]
    Mdbook(String),
}
