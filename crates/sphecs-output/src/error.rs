//! What can go wrong with files, said with the path and the cause.

use std::io;
use std::path::{Path, PathBuf};

use super::disk::bytes;

/// A fault of input or output.
#[derive(Debug, thiserror::Error)]
pub enum OutputError {
    /// The system refused to read or write.
    #[error("`{path}`: cannot {doing}: {cause}", path = path.display())]
    Io {
        /// File or folder.
        path: PathBuf,
        /// What was tried, as a verb: "write", "rename".
        doing: &'static str,
        /// The system's answer.
        cause: io::Error,
    },
    /// The NetCDF library refused to read or write.
    #[error("`{path}`: {what}", path = path.display())]
    NetCdf {
        /// File.
        path: PathBuf,
        /// The library's message, with the system's where one is found.
        what: String,
    },
    /// The folder holds an earlier run.
    #[error(
        "`{path}`: holds an earlier run, which is kept; give `--force` to replace it or `--out` for another folder",
        path = path.display()
    )]
    Exists {
        /// Folder.
        path: PathBuf,
    },
    /// The folder holds something that is not a run, which no option replaces.
    #[error(
        "`{path}`: is not empty and not a run of sphecs, so that it is not replaced; give another folder by `--out`",
        path = path.display()
    )]
    Foreign {
        /// Folder or file.
        path: PathBuf,
    },
    /// Another process writes the run.
    #[error(
        "`{path}`: is being written by another process; wait for its end or stop it first",
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
        /// The file that every run has.
        missing: &'static str,
    },
    /// A file of the run does not read as it should.
    #[error("`{path}`: {what}", path = path.display())]
    Damaged {
        /// File.
        path: PathBuf,
        /// What was found.
        what: String,
    },
    /// What is to be written is larger than what is free.
    #[error(
        "`{path}`: {what} needs about {}, {} are free there; {cure}",
        bytes(*needed),
        bytes(*free),
        path = path.display()
    )]
    NoRoom {
        /// File or folder.
        path: PathBuf,
        /// What is to be written.
        what: String,
        /// Bytes needed.
        needed: u64,
        /// Bytes free.
        free: u64,
        /// What a user can do about it.
        cure: String,
    },
    /// The request does not fit the run.
    #[error("{0}")]
    Request(String),
}

impl OutputError {
    /// A system fault while doing something with a path.
    pub fn io(path: &Path, doing: &'static str) -> impl FnOnce(io::Error) -> Self {
        let path = path.to_path_buf();
        move |cause| Self::Io { path, doing, cause }
    }
}
