//! The folder of a run's checkpoints, of which the last two are kept.

use std::fs;
use std::path::{Path, PathBuf};

use super::Checkpoint;
use super::container::{self, Unfit};
use crate::disk;
use crate::error::OutputError;

/// Name of the folder in the run folder.
pub const FOLDER: &str = "checkpoints";

/// Checkpoints kept: the last, and the one before it in case the last is damaged.
const KEPT: usize = 2;

/// The checkpoints of a run that is being written.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// A checkpoint that cannot be gone on from, and why.
#[derive(Clone, Debug)]
pub struct Refused {
    /// File.
    pub path: PathBuf,
    /// What is wrong with it.
    pub why: Unfit,
}

fn is_checkpoint(path: &Path) -> bool {
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    name.starts_with("step-") && name.ends_with(".checkpoint")
}

impl Store {
    /// The store of a run folder.
    pub fn of(run: &Path) -> Self {
        Self { folder: run.join(FOLDER) }
    }

    /// The files, the latest first.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the folder does not read.
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

    /// Writes a checkpoint whole or not at all, and removes those that are older than the last two.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses; earlier checkpoints are untouched.
    pub fn write(&self, checkpoint: &Checkpoint) -> Result<PathBuf, OutputError> {
        fs::create_dir_all(&self.folder).map_err(OutputError::io(&self.folder, "make the folder"))?;
        let path = self.folder.join(format!("step-{:012}.checkpoint", checkpoint.facts.step));
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

    /// The latest checkpoint that is whole and that `fits`, with its path; and those that were refused before it.
    ///
    /// # Errors
    /// [`OutputError`] when a file does not read, or one of another schema version is met: an older one would be of it too.
    pub fn latest(
        &self,
        fits: impl Fn(&Checkpoint) -> Result<(), String>,
    ) -> Result<(Option<(PathBuf, Checkpoint)>, Vec<Refused>), OutputError> {
        let mut refused = Vec::new();
        for path in self.files()? {
            let bytes = fs::read(&path).map_err(OutputError::io(&path, "read"))?;
            let why = match container::read(&bytes) {
                Ok(checkpoint) => match fits(&checkpoint) {
                    Ok(()) => return Ok((Some((path, checkpoint)), refused)),
                    Err(why) => Unfit::Foreign(why),
                },
                Err(why @ Unfit::Version { .. }) => {
                    return Err(OutputError::Request(format!("`{}`: {why}", path.display())));
                }
                Err(why) => why,
            };
            refused.push(Refused { path, why });
        }
        Ok((None, refused))
    }

    /// Removes what a kill or damage left: files without a whole name, and all checkpoints later than `last`.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
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
    fn the_last_two_are_kept_and_a_damaged_one_is_passed_over() {
        let run = tempfile::tempdir().expect("a folder");
        let store = Store::of(run.path());
        assert!(store.latest(|_| Ok(())).expect("read").0.is_none());
        for step in [5, 70, 900] {
            store.write(&checkpoint(step)).expect("written");
        }
        assert_eq!(steps(&store), [900, 70]);
        let files = store.files().expect("read");
        let sound = fs::read(&files[0]).expect("read");
        for damaged in [&sound[..sound.len() / 2], &[], b"something else"] {
            fs::write(&files[0], damaged).expect("written");
            let (found, refused) = store.latest(|_| Ok(())).expect("read");
            assert_eq!(found.expect("the one before").1, checkpoint(70));
            assert!(refused.len() == 1 && refused[0].path == files[0], "{refused:?}");
        }
        let (found, refused) = store.latest(|_| Err("of another scene".to_owned())).expect("read");
        assert!(found.is_none() && refused.len() == 2);
        fs::write(disk::partial_name(&files[0]), "cut off").expect("written");
        store.cut_back(Some(&files[1])).expect("cut back");
        assert_eq!(fs::read_dir(run.path().join(FOLDER)).expect("read").count(), 1);
    }
}
