//! The lock of a run folder: one process at a time, and nothing in the folder that leads out of it.

use std::fs::{self, File, TryLockError};
use std::path::Path;

use super::checkpoint::store;
use super::error::OutputError;
use super::pack::PACKED_JOURNAL;
use super::{disk, journal};

/// Says to other processes that a run is being written; freed by the system whatever ends the process.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Takes the lock of a run folder.
    ///
    /// # Errors
    /// [`OutputError::Busy`] when another process has it, [`OutputError::Request`] when it is a link: what that leads to would be emptied.
    pub fn take(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(".lock");
        if disk::is_link(&path) {
            return Err(OutputError::Request(format!("`{}`: is a link: remove it", path.display())));
        }
        let file = File::create(&path).map_err(OutputError::io(&path, "write"))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(OutputError::Busy { path: folder.to_path_buf() }),
            // A file system without locks must not stop a run.
            Err(TryLockError::Error(_)) => Ok(Self { _file: file }),
        }
    }

    /// Takes the lock of a run that is gone on with or packed where it stands.
    ///
    /// # Errors
    /// As [`Lock::take`]; [`OutputError::Request`] with a link in it, as what is cut back, removed and written there would be elsewhere;
    /// [`OutputError::Io`] when a folder does not read.
    pub fn take_plain(run: &Path) -> Result<Self, OutputError> {
        let lock = Self::take(run)?;
        let folders =
            [run.to_path_buf(), run.join(journal::FOLDER), run.join(PACKED_JOURNAL), run.join(store::FOLDER)];
        for folder in folders.iter().filter(|folder| folder.exists()) {
            for entry in fs::read_dir(folder).map_err(OutputError::io(folder, "read"))? {
                let path = entry.map_err(OutputError::io(folder, "read"))?.path();
                if disk::is_link(&path) {
                    return Err(OutputError::Request(format!(
                        "`{}`: is a link, and a run is not gone on with in another place: put the file itself there, or remove the link",
                        path.display()
                    )));
                }
            }
        }
        Ok(lock)
    }
}
