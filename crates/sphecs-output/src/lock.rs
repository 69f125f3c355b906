//! Lock of a run folder: one process writes at a time, and no symbolic link leads out of the
//! folder.

use std::fs::{self, File, TryLockError};
use std::path::{Path, PathBuf};

use super::disk;
use super::error::OutputError;
use super::paths::{CHECKPOINTS, JOURNAL, LOCK, PACKED_JOURNAL, PROBES};

/// Lock file held while a run is written; the system releases it when the process ends.
#[derive(Debug)]
pub struct Lock {
    _file: File,
}

impl Lock {
    /// Acquires the lock of a run folder.
    ///
    /// # Errors
    /// [`OutputError::Busy`] when another process holds it; [`OutputError::Request`] when the lock
    /// file is a link, whose target would be emptied.
    pub fn acquire(folder: &Path) -> Result<Self, OutputError> {
        let path = folder.join(LOCK);
        if disk::is_link(&path) {
            return Err(OutputError::Request(format!(
                "`{}`: is a link, must be a file of the run folder: remove it",
                path.display()
            )));
        }
        let file = File::create(&path).map_err(OutputError::io(&path, "write"))?;
        match file.try_lock() {
            Ok(()) => Ok(Self { _file: file }),
            Err(TryLockError::WouldBlock) => Err(OutputError::Busy { path: folder.to_path_buf() }),
            // A file system without locks must not stop a run.
            Err(TryLockError::Error(_)) => Ok(Self { _file: file }),
        }
    }

    /// Acquires the lock of a run that is resumed or packed in place.
    ///
    /// # Errors
    /// As [`Lock::acquire`]. [`OutputError::Request`] when the folder has a link, since files would
    /// be cut back, removed and written outside it; [`OutputError::Io`] when a folder cannot be
    /// read.
    pub fn acquire_without_links(run: &Path) -> Result<Self, OutputError> {
        let lock = Self::acquire(run)?;
        let inner = [JOURNAL, PACKED_JOURNAL, CHECKPOINTS, PROBES].map(|name| run.join(name));
        for folder in
            std::iter::once(run).chain(inner.iter().map(PathBuf::as_path)).filter(|folder| folder.exists())
        {
            for entry in fs::read_dir(folder).map_err(OutputError::io(folder, "read"))? {
                let path = entry.map_err(OutputError::io(folder, "read"))?.path();
                if disk::is_link(&path) {
                    return Err(OutputError::Request(format!(
                        "`{}`: is a link, must be a file of the run folder: put the file itself there, or remove the link",
                        path.display()
                    )));
                }
            }
        }
        Ok(lock)
    }
}
