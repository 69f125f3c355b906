//! Errors of input and output, each with its path and cause.

use std::io;
use std::path::{Path, PathBuf};

use sphecs_core::format::bytes;

/// Error of input or output.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// A system call failed.
    #[error("`{path}`: cannot {doing}: {cause}", path = path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// Action that failed, as a verb: "write", "rename".
        doing: &'static str,
        /// Error of the system.
        cause: io::Error,
    },
    /// The NetCDF library failed to read or write.
    #[error("`{path}`: {what}", path = path.display())]
    NetCdf {
        /// File.
        path: PathBuf,
        /// Message of the library, with the error of the system where one is found.
        what: String,
    },
    /// The folder holds an earlier run.
    #[error(
        "`{path}`: holds an earlier run; give `--force` to replace it or `--out` for another folder",
        path = path.display()
    )]
    Exists {
        /// Folder.
        path: PathBuf,
    },
    /// The folder holds something that is not a run, which no option replaces.
    #[error(
        "`{path}`: is not empty and not a run of sphecs, so it is never replaced; give another folder by `--out`",
        path = path.display()
    )]
    Foreign {
        /// Folder or file.
        path: PathBuf,
    },
    /// Another process is writing the run.
    #[error(
        "`{path}`: is being written by another process; wait for it to end or stop it first",
        path = path.display()
    )]
    Busy {
        /// Folder.
        path: PathBuf,
    },
    /// The folder is not a run.
    #[error(
        "`{path}`: is not a run, it has no `{missing}`; give the folder that `sphecs run` wrote",
        path = path.display()
    )]
    NotARun {
        /// Folder.
        path: PathBuf,
        /// File that every run has.
        missing: &'static str,
    },
    /// A file of the run cannot be read or is damaged.
    #[error("`{path}`: {what}", path = path.display())]
    Damaged {
        /// File.
        path: PathBuf,
        /// Damage found.
        what: String,
    },
    /// The free disk space is too small.
    #[error(
        "`{path}`: {what} needs about {}, {} are free; {cure}",
        bytes(*needed),
        bytes(*free),
        path = path.display()
    )]
    DiskFull {
        /// File or folder.
        path: PathBuf,
        /// Data to be written.
        what: String,
        /// Space needed, bytes.
        needed: u64,
        /// Free space, bytes.
        free: u64,
        /// Advice to the user.
        cure: String,
    },
    /// The request does not match the run.
    #[error("{0}")]
    Request(String),
}

impl OutputError {
    /// Returns a closure that adds path and action to a system error.
    pub fn io(path: &Path, doing: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |cause| Self::Io { path, doing, cause }
    }
}
