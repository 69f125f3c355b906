//! The folder of a run: `particles.nc`, `monitor.nc`, `probes.nc` with their CSV twins, `scene.ron` (and `tables.json` with the
//! tables that it names), `summary.json`, `checkpoints/`, `journal/` while it runs, and `blow_up.nc` and `blow_up.png` of a flow that blew up.

use std::ffi::OsString;
use std::fs::{self, File};
use std::path::{Path, PathBuf};

use super::blow_up;
use super::checkpoint::store::Store;
use super::checkpoint::{Checkpoint, Facts, cut};
use super::disk;
use super::error::OutputError;
use super::forces::ForcesWriter;
use super::frame::Frame;
use super::header::Header;
use super::journal::{self, FrameWriter};
use super::lock::Lock;
use super::monitor::MonitorWriter;
use super::pack::{Packed, pack_locked, remove_folder};
use super::probes::ProbeSample;
use super::probes::ProbeSet;
use super::probes::writer::ProbeWriter;
use super::results::is_run;
use super::summary::Summary;
use super::table::TableWriter;
use sphecs_core::math::column::Columns;
use sphecs_core::math::lanes::InstructionSet;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::systems::body_forces::BodyForcesRow;
use sphecs_engine::systems::monitor::MonitorRow;

/// Name of the scene in the run folder.
pub const SCENE: &str = "scene.ron";

/// Name of the file of the scene's tables in the run folder.
pub const TABLES: &str = "tables.json";

/// The folder of a run that goes on.
#[derive(Debug)]
pub struct RunFolder {
    path: PathBuf,
    header: Header,
    frames: Option<FrameWriter>,
    monitor: MonitorWriter,
    probes: Option<ProbeWriter>,
    forces: Option<ForcesWriter>,
    /// Frames handed over.
    submitted: u64,
    _lock: Lock,
}

/// Whether a run may be written to a folder: to be asked before time is spent on the scene.
///
/// # Errors
/// [`OutputError::Exists`] when it holds an earlier run and `force` is not given, [`OutputError::Foreign`] when it
/// holds something else, [`OutputError::Busy`] when another process writes it.
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
    Lock::take(path).map(drop)
}

impl RunFolder {
    /// Makes the folder of a run. With `force` an earlier run there is replaced, in the moment that the new folder
    /// stands; so call this when the scene is built and the first step is next.
    ///
    /// # Errors
    /// As [`check_free`], or [`OutputError::Io`]; what was there is then untouched.
    pub fn create(path: &Path, force: bool, header: &Header, probes: &ProbeSet) -> Result<Self, OutputError> {
        check_free(path, force)?;
        let parent = path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new("."));
        fs::create_dir_all(parent).map_err(OutputError::io(parent, "make the folder"))?;
        // Two processes that make the same folder take turns: the second finds the run of the first.
        let turn = File::open(parent).map_err(OutputError::io(parent, "read"))?;
        // A file system without locks must not stop a run.
        let _turn = turn.lock().is_ok().then_some(turn);
        check_free(path, force)?;
        let _replaced = if path.join(SCENE).exists() { Some(Lock::take(path)?) } else { None };
        let fresh = sibling(path, "new");
        let stale = sibling(path, "old");
        remove_folder(&fresh)?;
        remove_folder(&stale)?;
        let made = furnish(&fresh, header).and_then(|()| {
            // The lock comes along with its folder.
            let lock = Lock::take(&fresh)?;
            if path.exists() {
                fs::rename(path, &stale).map_err(OutputError::io(path, "replace"))?;
            }
            fs::rename(&fresh, path).map_err(OutputError::io(path, "make the folder"))?;
            disk::sync_folder(parent)?;
            Ok(lock)
        });
        let lock = match made {
            Ok(lock) => lock,
            Err(error) => {
                if !path.exists() && stale.exists() {
                    fs::rename(&stale, path).map_err(OutputError::io(path, "restore"))?;
                }
                remove_folder(&fresh)?;
                return Err(error);
            }
        };
        remove_folder(&stale)?;
        Self::begin(path, header, probes, &Facts::default(), lock)
    }

    /// Goes on in the folder of a run whose lock is held: cuts its output back to what a checkpoint counts.
    ///
    /// # Errors
    /// [`OutputError`] with path and cause; the folder can be gone on from again.
    pub fn go_on(
        path: &Path,
        header: &Header,
        probes: &ProbeSet,
        facts: &Facts,
        lock: Lock,
    ) -> Result<Self, OutputError> {
        Summary { run: header.clone(), ..Summary::default() }.write(path)?;
        cut::cut_back(path, header, facts)?;
        blow_up::remove(path)?;
        Self::begin(path, header, probes, facts, lock)
    }

    fn begin(
        path: &Path,
        header: &Header,
        probes: &ProbeSet,
        facts: &Facts,
        lock: Lock,
    ) -> Result<Self, OutputError> {
        let journal = path.join(journal::FOLDER);
        let probes = match probes.is_empty() {
            true => None,
            false => Some(ProbeWriter::go_on(path, header, probes, facts.probes_bytes)?),
        };
        let forces = match header.bodies.is_empty() {
            true => None,
            false => Some(ForcesWriter::go_on(path, header, facts.forces_bytes)?),
        };
        Ok(Self {
            frames: Some(FrameWriter::start(&journal, header, facts.frames, Store::of(path))?),
            monitor: MonitorWriter::go_on(path, header, facts.monitor_bytes)?,
            probes,
            forces,
            submitted: facts.frames,
            path: path.to_path_buf(),
            header: header.clone(),
            _lock: lock,
        })
    }

    /// Where it is.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Facts of the run.
    pub fn header(&self) -> &Header {
        &self.header
    }

    /// Hands a frame to the thread that writes frames.
    ///
    /// # Errors
    /// The error that stopped the writing of an earlier frame.
    pub fn submit(&mut self, frame: Frame) -> Result<(), OutputError> {
        self.submitted += 1;
        match &mut self.frames {
            Some(frames) => frames.submit(frame),
            None => Ok(()),
        }
    }

    /// Hands a state to the thread that writes frames, behind the frames before it; the output that there is by now belongs to it.
    ///
    /// # Errors
    /// The error that stopped the writing of an earlier frame, or [`OutputError::Io`].
    pub fn checkpoint(&mut self, clock: &Clock, state: Columns) -> Result<(), OutputError> {
        let Some(frames) = &mut self.frames else { return Ok(()) };
        let tables = || {
            let written =
                std::iter::once(self.monitor.table()).chain(self.probes.iter().map(ProbeWriter::table));
            written.chain(self.forces.iter().map(ForcesWriter::table))
        };
        let facts = Facts {
            scene_sha256: self.header.fingerprint(),
            version: self.header.version.clone(),
            lanes: InstructionSet::best().name().to_owned(),
            time: clock.time,
            step: clock.step,
            frames: self.submitted,
            monitor_bytes: self.monitor.table().length(),
            probes_bytes: self.probes.as_ref().map_or(0, |probes| probes.table().length()),
            forces_bytes: self.forces.as_ref().map_or(0, |forces| forces.table().length()),
        };
        let handles = tables().map(TableWriter::handle).collect::<Result<Vec<_>, OutputError>>()?;
        frames.checkpoint(Checkpoint { facts, state }, handles)
    }

    /// Step of the last checkpoint that is whole and durable.
    pub fn last_checkpoint(&self) -> Option<u64> {
        self.frames.as_ref().and_then(FrameWriter::last_checkpoint)
    }

    /// Frames that are whole and durable.
    pub fn frames_written(&self) -> u64 {
        self.frames.as_ref().map_or(0, FrameWriter::written)
    }

    /// Appends a row to `monitor.csv`.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn monitor(&mut self, row: &MonitorRow) -> Result<(), OutputError> {
        self.monitor.append(row)
    }

    /// Appends a row to `forces.csv`, in a run that has bodies.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn forces(&mut self, row: &BodyForcesRow) -> Result<(), OutputError> {
        match &mut self.forces {
            Some(forces) => forces.append(row),
            None => Ok(()),
        }
    }

    /// Appends to `probes.csv`.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn probe(&mut self, sample: &ProbeSample) -> Result<(), OutputError> {
        match &mut self.probes {
            Some(probes) => probes.append(sample),
            None => Ok(()),
        }
    }

    /// Ends the run: waits for the frames, writes `summary.json` (its frames and facts are put in here) and packs.
    ///
    /// # Errors
    /// The first error; every frame written and the journal stay readable, and `sphecs pack` can be tried again.
    pub fn finish(mut self, mut summary: Summary) -> Result<Packed, OutputError> {
        let frames = self.frames.take();
        let written = frames.as_ref().map(FrameWriter::written);
        let ended = frames.map_or(Ok(0), FrameWriter::finish);
        summary.frames = *ended.as_ref().unwrap_or(&written.unwrap_or(0));
        summary.run = self.header.clone();
        // The summary first: it says how the run ended even when there is no room to pack.
        summary.write(&self.path)?;
        ended?;
        pack_locked(&self.path, &self.header)
    }
}

/// What a run folder has before the first frame.
fn furnish(folder: &Path, header: &Header) -> Result<(), OutputError> {
    let journal = folder.join(journal::FOLDER);
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
    fn earlier_run_is_replaced_by_force_only() {
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
        assert_eq!(siblings, 1, "nothing of the replacement is left over");
    }

    #[test]
    fn folder_of_another_kind_is_never_replaced() {
        let parent = tempfile::tempdir().expect("a folder");
        fs::write(parent.path().join("thesis.tex"), "years").expect("written");
        for force in [false, true] {
            let error = start(parent.path(), force, "scene").expect_err("refused");
            assert!(matches!(error, OutputError::Foreign { .. }), "{error}");
        }
        assert!(parent.path().join("thesis.tex").exists());
    }

    #[test]
    fn empty_folder_is_taken() {
        let parent = tempfile::tempdir().expect("a folder");
        start(parent.path(), false, "scene").expect("created");
        assert!(parent.path().join(SCENE).exists());
    }
}
