//! Folder of the checkpoints of a run, of which the last two are kept.

use std::fs;
use std::path::{Path, PathBuf};

use super::Checkpoint;
use super::container::{self, Rejection};
use crate::disk;
use crate::error::OutputError;
use crate::paths::{self, CHECKPOINTS, is_checkpoint};

/// Number of checkpoints kept: the last, and the one before it in case the last is damaged.
const KEPT: usize = 2;

/// Checkpoints of a run.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// Checkpoint that the run cannot resume from, and the reason.
#[derive(Clone, Debug)]
pub struct Rejected {
    /// File.
    pub path: PathBuf,
    /// Reason.
    pub reason: Rejection,
}

impl Store {
    /// Returns the store of a run folder.
    pub fn of(run: &Path) -> Self {
        Self { folder: run.join(CHECKPOINTS) }
    }

    /// Returns the paths of the checkpoints, latest first.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the folder cannot be read.
    pub fn files(&self) -> Result<Vec<PathBuf>, OutputError> {
        let mut files = Vec::new();
        if !self.folder.exists() {
            return Ok(files);
        }
        for entry in fs::read_dir(&self.folder).map_err(OutputError::io(&self.folder, "read"))? {
            let path = entry.map_err(OutputError::io(&self.folder, "read"))?.path();
            files.extend(is_checkpoint(&path).then_some(path));
        }
        files.sort();
        files.reverse();
        Ok(files)
    }

    /// Writes a checkpoint completely or not at all and removes all but the last two.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails; earlier checkpoints are untouched.
    pub fn write(&self, checkpoint: &Checkpoint) -> Result<PathBuf, OutputError> {
        fs::create_dir_all(&self.folder).map_err(OutputError::io(&self.folder, "make the folder"))?;
        let path = self.folder.join(paths::checkpoint(checkpoint.facts.step));
        container::write_file(checkpoint, &disk::fresh_partial(&path)).map_err(|cause| {
            disk::discard(&path);
            OutputError::io(&path, "write")(cause)
        })?;
        disk::commit(&path)?;
        for old in self.files()?.into_iter().skip(KEPT) {
            fs::remove_file(&old).map_err(OutputError::io(&old, "remove"))?;
        }
        Ok(path)
    }

    /// Returns the latest complete checkpoint that `is_usable` accepts, with its path, and the
    /// later ones rejected.
    ///
    /// # Errors
    /// [`OutputError`] when a file cannot be read or has another schema version, as older ones
    /// would have too.
    pub fn latest(
        &self,
        is_usable: impl Fn(&Checkpoint) -> Result<(), String>,
    ) -> Result<(Option<(PathBuf, Checkpoint)>, Vec<Rejected>), OutputError> {
        let mut rejected = Vec::new();
        for path in self.files()? {
            let bytes = fs::read(&path).map_err(OutputError::io(&path, "read"))?;
            let reason = match container::read(&bytes) {
                Ok(checkpoint) => match is_usable(&checkpoint) {
                    Ok(()) => return Ok((Some((path, checkpoint)), rejected)),
                    Err(reason) => Rejection::Foreign(reason),
                },
                Err(reason @ Rejection::Version { .. }) => {
                    return Err(OutputError::Request(format!("`{}`: {reason}", path.display())));
                }
                Err(reason) => reason,
            };
            rejected.push(Rejected { path, reason });
        }
        Ok((None, rejected))
    }

    /// Removes incomplete files and all checkpoints later than `last`.
    ///
    /// # Errors
    /// [`OutputError::Io`] when a file cannot be removed.
    pub fn cut_back(&self, last: Option<&Path>) -> Result<(), OutputError> {
        if !self.folder.exists() {
            return Ok(());
        }
        for entry in fs::read_dir(&self.folder).map_err(OutputError::io(&self.folder, "read"))? {
            let path = entry.map_err(OutputError::io(&self.folder, "read"))?.path();
            let stray = path.extension().is_some_and(|extension| extension == "partial");
            let later = is_checkpoint(&path) && last.is_none_or(|last| path.as_path() > last);
            if stray || later {
                fs::remove_file(&path).map_err(OutputError::io(&path, "remove"))?;
            }
        }
        disk::sync_folder(&self.folder)
    }
}

#[cfg(test)]
mod tests {
    use super::super::Facts;
    use super::*;

    fn checkpoint(step: u64) -> Checkpoint {
        let mut checkpoint =
            Checkpoint { facts: Facts { step, ..Facts::default() }, ..Checkpoint::default() };
        checkpoint.state.put("x", vec![step as f64]);
        checkpoint
    }

    fn steps(store: &Store) -> Vec<u64> {
        let any = |_: &Checkpoint| Ok(());
        let files = store.files().expect("read");
        let read =
            |path: &PathBuf| container::read(&fs::read(path).expect("read")).map(|found| found.facts.step);
        assert_eq!(store.latest(any).is_ok(), files.iter().all(|path| read(path).is_ok()));
        files.iter().filter_map(|path| read(path).ok()).collect()
    }

    #[test]
    fn last_two_are_kept_and_a_damaged_one_is_skipped() {
        let run = tempfile::tempdir().expect("a folder");
        let store = Store::of(run.path());
        assert!(store.latest(|_| Ok(())).expect("read").0.is_none());
        for step in [5, 70, 900] {
            store.write(&checkpoint(step)).expect("written");
        }
        assert_eq!(steps(&store), [900, 70]);
        let files = store.files().expect("read");
        let intact = fs::read(&files[0]).expect("read");
        for damaged in [&intact[..intact.len() / 2], &[], b"something else"] {
            fs::write(&files[0], damaged).expect("written");
            let (found, rejected) = store.latest(|_| Ok(())).expect("read");
            assert_eq!(found.expect("the one before").1, checkpoint(70));
            assert!(rejected.len() == 1 && rejected[0].path == files[0], "{rejected:?}");
        }
        let (found, rejected) = store.latest(|_| Err("belongs to another scene".to_owned())).expect("read");
        assert!(found.is_none() && rejected.len() == 2);
        fs::write(disk::partial_name(&files[0]), "cut off").expect("written");
        store.cut_back(Some(&files[1])).expect("cut back");
        assert_eq!(fs::read_dir(run.path().join(CHECKPOINTS)).expect("read").count(), 1);
    }
}
