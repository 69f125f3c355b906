//! Run folder that a run writes into; [`paths`](super::paths) has the names of its files.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::checkpoint::store::Store;
use super::checkpoint::{Checkpoint, Facts};
use super::cut_back::cut_back;
use super::disk::{self, remove_folder};
use super::divergence;
use super::error::OutputError;
use super::forces::ForcesWriter;
use super::frame::Frame;
use super::header::Header;
use super::journal::FrameWriter;
use super::lock::Lock;
use super::monitor::MonitorWriter;
use super::pack::{Packed, pack_locked};
use super::paths::{JOURNAL, SCENE, TABLES};
use super::probes::ProbeSample;
use super::probes::ProbeSet;
use super::probes::writer::ProbeWriter;
use super::results::is_run;
use super::summary::Summary;
use sphecs_core::math::column::Columns;
use sphecs_core::math::lanes::InstructionSet;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::systems::body_forces::BodyForcesRow;
use sphecs_engine::systems::monitor::MonitorRow;

/// Run folder while the run is under way.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    header: Header,
    frames: Option<FrameWriter>,
    monitor: MonitorWriter,
    probes: Option<ProbeWriter>,
    forces: Option<ForcesWriter>,
    /// Number of frames submitted.
    submitted: u64,
    _lock: Lock,
}

/// Checks that a run may be written to a folder, before time is spent on the scene.
///
/// # Errors
/// [`OutputError::Exists`] when it holds an earlier run and `force` is not given,
/// [`OutputError::Foreign`] when it holds other files, [`OutputError::Busy`] when another process
/// writes it.
pub fn check_free(path: &Path, force: bool) -> Result<(), OutputError> {
    if !path.exists() {
        return Ok(());
    }
    let foreign = || OutputError::Foreign { path: path.to_path_buf() };
    if !path.is_dir() {
        return Err(foreign());
    }
    let mut entries = fs::read_dir(path).map_err(OutputError::io(path, "read"))?;
    if entries.next().is_none() {
        return Ok(());
    }
    if !is_run(path) {
        return Err(foreign());
    }
    if !force {
        return Err(OutputError::Exists { path: path.to_path_buf() });
    }
    Lock::acquire(path).map(drop)
}

impl RunFolder {
    /// Makes the folder of a run.
    ///
    /// With `force` an earlier run is replaced once the new folder is complete, so call this after
    /// the scene is built and before the first step.
    ///
    /// # Errors
    /// As [`check_free`], or [`OutputError::Io`]; an earlier run is then untouched.
    pub fn create(path: &Path, force: bool, header: &Header, probes: &ProbeSet) -> Result<Self, OutputError> {
        check_free(path, force)?;
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(OutputError::io(parent, "make the folder"))?;
        // Processes that make the same folder wait for each other, so the second finds the run of
        // the first.
        let parent_lock = File::open(parent).map_err(OutputError::io(parent, "read"))?;
        // A file system without locks must not stop a run.
        let _parent_lock = parent_lock.lock().is_ok().then_some(parent_lock);
        check_free(path, force)?;
        let _replaced = if path.join(SCENE).exists() { Some(Lock::acquire(path)?) } else { None };
        let new = sibling(path, "new");
        let old = sibling(path, "old");
        remove_folder(&new)?;
        remove_folder(&old)?;
        let made = write_initial_files(&new, header).and_then(|()| {
            // The lock is renamed with its folder.
            let lock = Lock::acquire(&new)?;
            if path.exists() {
                fs::rename(path, &old).map_err(OutputError::io(path, "replace"))?;
            }
            fs::rename(&new, path).map_err(OutputError::io(path, "make the folder"))?;
            disk::sync_folder(parent)?;
            Ok(lock)
        });
        let lock = match made {
            Ok(lock) => lock,
            Err(error) => {
                if !path.exists() && old.exists() {
                    fs::rename(&old, path).map_err(OutputError::io(path, "restore"))?;
                }
                remove_folder(&new)?;
                return Err(error);
            }
        };
        remove_folder(&old)?;
        Self::open(path, header, probes, &Facts::default(), lock)
    }

    /// Opens the folder of a run whose lock is held and cuts its output back to a checkpoint.
    ///
    /// # Errors
    /// [`OutputError`] with path and cause; resuming can be tried again.
    pub fn resume(
        path: &Path,
        header: &Header,
        probes: &ProbeSet,
        facts: &Facts,
        lock: Lock,
    ) -> Result<Self, OutputError> {
        Summary { run: header.clone(), ..Summary::default() }.write(path)?;
        cut_back(path, header, facts)?;
        divergence::remove(path)?;
        Self::open(path, header, probes, facts, lock)
    }

    fn open(
        path: &Path,
        header: &Header,
        probes: &ProbeSet,
        facts: &Facts,
        lock: Lock,
    ) -> Result<Self, OutputError> {
        let journal = path.join(JOURNAL);
        let probes = match probes.is_empty() {
            true => None,
            false => Some(ProbeWriter::resume(path, header, probes, &facts.probes_bytes)?),
        };
        let forces = match header.bodies.is_empty() {
            true => None,
            false => Some(ForcesWriter::resume(path, header, facts.forces_bytes)?),
        };
        Ok(Self {
            frames: Some(FrameWriter::start(&journal, header, facts.frames, Store::of(path))?),
            monitor: MonitorWriter::resume(path, header, facts.monitor_bytes)?,
            probes,
            forces,
            submitted: facts.frames,
            path: path.to_path_buf(),
            header: header.clone(),
            _lock: lock,
        })
    }

    /// Returns the path of the folder.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Returns the header of the run.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Submits a frame to the writer thread.
    ///
    /// # Errors
    /// The error of an earlier frame that stopped the writer thread.
    pub fn submit(&mut self, frame: Frame) -> Result<(), OutputError> {
        self.submitted += 1;
        match &mut self.frames {
            Some(frames) => frames.submit(frame),
            None => Ok(()),
        }
    }

    /// Submits a checkpoint of the state and of the output written so far to the writer thread.
    ///
    /// # Errors
    /// The error that stopped the writing of an earlier frame, or [`OutputError::Io`].
    pub fn checkpoint(&mut self, clock: &Clock, state: Columns) -> Result<(), OutputError> {
        let Some(frames) = &mut self.frames else { return Ok(()) };
        let facts = Facts {
            scene_sha256: self.header.fingerprint(),
            version: self.header.version.clone(),
            lanes: InstructionSet::best().name().to_owned(),
            time: clock.time,
            step: clock.step,
            frames: self.submitted,
            monitor_bytes: self.monitor.table().length(),
            probes_bytes: self.probes.as_ref().map_or_else(Vec::new, ProbeWriter::lengths),
            forces_bytes: self.forces.as_ref().map_or(0, |forces| forces.table().length()),
        };
        let tables = std::iter::once(self.monitor.table()).chain(self.forces.iter().map(ForcesWriter::table));
        let probes = self.probes.iter().flat_map(ProbeWriter::paths);
        let written = tables.map(|table| table.path().to_path_buf()).chain(probes).collect();
        frames.checkpoint(Checkpoint { facts, state }, written)
    }

    /// Returns the step of the last checkpoint that is complete and durable.
    pub fn last_checkpoint(&self) -> Option<u64> {
        self.frames.as_ref().and_then(FrameWriter::last_checkpoint)
    }

    /// Returns the number of frames that are complete and durable.
    pub fn frames_written(&self) -> u64 {
        self.frames.as_ref().map_or(0, FrameWriter::written)
    }

    /// Appends a row to `monitor.csv`.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn monitor(&mut self, row: &MonitorRow) -> Result<(), OutputError> {
        self.monitor.append(row)
    }

    /// Appends a row to `forces.csv`, in a run that has bodies.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn forces(&mut self, row: &BodyForcesRow) -> Result<(), OutputError> {
        match &mut self.forces {
            Some(forces) => forces.append(row),
            None => Ok(()),
        }
    }

    /// Appends to the files of the probes.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn probe(&mut self, sample: &ProbeSample) -> Result<(), OutputError> {
        match &mut self.probes {
            Some(probes) => probes.append(sample),
            None => Ok(()),
        }
    }

    /// Waits for the frames, writes `summary.json` with its frame count and header set, and packs
    /// the run.
    ///
    /// # Errors
    /// The first error; the journal stays readable, and `sphecs pack` can be tried again.
    pub fn finish(mut self, mut summary: Summary) -> Result<Packed, OutputError> {
        let frames = self.frames.take();
        let written = frames.as_ref().map(FrameWriter::written);
        let ended = frames.map_or(Ok(0), FrameWriter::finish);
        summary.frames = *ended.as_ref().unwrap_or(&written.unwrap_or(0));
        summary.run = self.header.clone();
        // The summary is written first, so that it has the reason of the end even if the disk is
        // too full to pack.
        summary.write(&self.path)?;
        ended?;
        pack_locked(&self.path, &self.header)
    }
}

/// Writes the files that a run folder has before the first frame.
fn write_initial_files(folder: &Path, header: &Header) -> Result<(), OutputError> {
    let journal = folder.join(JOURNAL);
    fs::create_dir_all(&journal).map_err(OutputError::io(&journal, "make the folder"))?;
    disk::write_whole(&folder.join(SCENE), header.text.as_bytes())?;
    if !header.tables.is_empty() {
        let path = folder.join(TABLES);
        let tables = serde_json::to_vec_pretty(&header.tables)
            .map_err(|error| OutputError::Damaged { path: path.clone(), what: error.to_string() })?;
        disk::write_whole(&path, &tables)?;
    }
    Summary { run: header.clone(), ..Summary::default() }.write(folder)
}

fn sibling(path: &Path, role: &str) -> PathBuf {
    let mut name = OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{role}"));
    path.with_file_name(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn header(text: &str) -> Header {
        Header { text: text.to_owned(), dimensions: 2, ..Header::default() }
    }

    fn start(path: &Path, force: bool, text: &str) -> Result<RunFolder, OutputError> {
        RunFolder::create(path, force, &header(text), &ProbeSet::default())
    }

    #[test]
    fn earlier_run_is_replaced_only_by_force() {
        let parent = tempfile::tempdir().expect("a folder");
        let path = parent.path().join("deep/run");
        let run = start(&path, false, "first").expect("created");
        run.finish(Summary::default()).expect("ended");
        fs::write(path.join("particles.nc"), "results").expect("written");

        let error = start(&path, false, "second").expect_err("refused").to_string();
        assert!(error.contains("--force") && error.contains("--out"), "{error}");
        assert_eq!(fs::read(path.join("particles.nc")).expect("read"), b"results");

        let run = start(&path, true, "second").expect("replaced");
        assert_eq!(fs::read(run.path().join(SCENE)).expect("read"), b"second");
        assert!(!path.join("particles.nc").exists());
        let siblings = fs::read_dir(parent.path().join("deep")).expect("read").count();
        assert_eq!(siblings, 1, "the replacement leaves no other folder");
    }

    #[test]
    fn folder_without_a_run_is_never_replaced() {
        let parent = tempfile::tempdir().expect("a folder");
        fs::write(parent.path().join("thesis.tex"), "years").expect("written");
        for force in [false, true] {
            let error = start(parent.path(), force, "scene").expect_err("refused");
            assert!(matches!(error, OutputError::Foreign { .. }), "{error}");
        }
        assert!(parent.path().join("thesis.tex").exists());
    }

    #[test]
    fn empty_folder_is_used() {
        let parent = tempfile::tempdir().expect("a folder");
        start(parent.path(), false, "scene").expect("created");
        assert!(parent.path().join(SCENE).exists());
    }
}
