//! Run folder that a run writes into; [`paths`](super::paths) has the names of its files.

use std::path::{Path, PathBuf};

use super::checkpoint::store::Store;
use super::checkpoint::{Checkpoint, Facts};
use super::cut_back::cut_back;
use super::disk::remove_folder;
use super::divergence;
use super::error::OutputError;
use super::fields::averages::FieldMeans;
use super::fields::snapshot::FieldSnapshot;
use super::forces::ForcesWriter;
use super::frame::Frame;
use super::header::Header;
use super::journal::FrameWriter;
use super::lock::Lock;
use super::monitor::MonitorWriter;
use super::pack::{Packed, pack_locked};
use super::paths::{JOURNAL, REPLACED};
use super::probes::ProbeSample;
use super::probes::ProbeSet;
use super::probes::writer::ProbeWriter;
use super::start::start;
use super::summary::Summary;
use super::walls::at_time::WallSnapshot;
use super::walls::over_time::WallMeans;
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
    /// Number of times of the gridded fields submitted.
    fields: u64,
    /// Number of times of the quantities at the walls submitted.
    walls: u64,
    _lock: Lock,
}

impl RunFolder {
    /// Makes the folder of a run, or uses the one that exists, whose place and permissions stay.
    ///
    /// With `force` an earlier run is replaced once the initial files are complete, so call this
    /// after the scene is built and before the first step.
    ///
    /// # Errors
    /// As [`check_free`](super::start::check_free), or [`OutputError::Io`]; an earlier run is then
    /// untouched.
    pub fn create(path: &Path, force: bool, header: &Header, probes: &ProbeSet) -> Result<Self, OutputError> {
        let lock = start(path, force, header)?;
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
        // A start that was cut off while it removed an earlier run has left the rest of it.
        remove_folder(&path.join(REPLACED))?;
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
            fields: facts.fields,
            walls: facts.walls,
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
            fields: self.fields,
            walls: self.walls,
            monitor_bytes: self.monitor.table().length(),
            probes_bytes: self.probes.as_ref().map_or_else(Vec::new, ProbeWriter::lengths),
            forces_bytes: self.forces.as_ref().map_or(0, |forces| forces.table().length()),
        };
        let tables = std::iter::once(self.monitor.table()).chain(self.forces.iter().map(ForcesWriter::table));
        let probes = self.probes.iter().flat_map(ProbeWriter::paths);
        let written = tables.map(|table| table.path().to_path_buf()).chain(probes).collect();
        frames.checkpoint(Checkpoint { facts, state }, written)
    }

    /// Submits gridded fields to the writer thread.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_fields(&mut self, fields: FieldSnapshot) -> Result<(), OutputError> {
        let index = self.fields;
        self.fields += 1;
        self.frames.as_mut().map_or(Ok(()), |frames| frames.submit_fields(fields, index))
    }

    /// Submits the means of the gridded fields to the writer thread.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_field_means(&mut self, means: FieldMeans) -> Result<(), OutputError> {
        self.frames.as_mut().map_or(Ok(()), |frames| frames.submit_field_means(means))
    }

    /// Submits quantities at the walls to the writer thread.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_walls(&mut self, walls: WallSnapshot) -> Result<(), OutputError> {
        let index = self.walls;
        self.walls += 1;
        self.frames.as_mut().map_or(Ok(()), |frames| frames.submit_walls(walls, index))
    }

    /// Submits the means at the walls to the writer thread.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_wall_means(&mut self, means: WallMeans) -> Result<(), OutputError> {
        self.frames.as_mut().map_or(Ok(()), |frames| frames.submit_wall_means(means))
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
