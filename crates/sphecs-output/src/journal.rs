//! Journal of a run: one complete NetCDF file per frame, written by the writer thread.
//!
//! A growing NetCDF-4 file is not crash-safe: a kill between two frames can lose all of them, and a
//! full disk is noticed only when the file is closed. A file per frame, named when it is complete
//! and durable, cannot be lost by later writes (test `tests/killed_run.rs`).

use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::checkpoint::Checkpoint;
use super::checkpoint::store::Store;
use super::error::OutputError;
use super::fields::averages::FieldMeans;
use super::fields::packing;
use super::fields::snapshot::FieldSnapshot;
use super::frame::Frame;
use super::header::Header;
use super::netcdf::particles;
use super::numbered_files::numbered_files;
use super::paths;
use super::walls::at_time::WallSnapshot;
use super::walls::files;
use super::walls::over_time::WallMeans;

/// Largest number of waiting frames, so that one is ready while another is written. More would only
/// hide a slow disk.
const QUEUE: usize = 1;

/// Returns the complete frames of a journal in order of time.
///
/// # Errors
/// [`OutputError::Io`] when the folder cannot be read.
pub fn frame_paths(journal: &Path) -> Result<Vec<PathBuf>, OutputError> {
    numbered_files(journal, paths::frame_index)
}

/// Item for the writer thread.
enum Item {
    Frame(Box<Frame>),
    /// Gridded fields and the index of their time.
    Fields(Box<FieldSnapshot>, u64),
    /// Means of the gridded fields.
    FieldMeans(Box<FieldMeans>),
    /// Quantities at the walls and the index of their time.
    Walls(Box<WallSnapshot>, u64),
    /// Means at the walls.
    WallMeans(Box<WallMeans>),
    /// A checkpoint and the tables that must be durable before it.
    Checkpoint(Box<Checkpoint>, Vec<PathBuf>),
}

/// Step number that means no checkpoint.
const NO_STEP: u64 = u64::MAX;

/// Submits frames and checkpoints to the writer thread, so that the flow advances meanwhile.
#[derive(Debug)]
pub struct FrameWriter {
    sender: Option<SyncSender<Item>>,
    thread: Option<JoinHandle<Result<(), OutputError>>>,
    written: Arc<AtomicU64>,
    checkpoint: Arc<AtomicU64>,
}

/// State of the writer thread.
struct WriterThread {
    journal: PathBuf,
    header: Header,
    /// Number of threads that compress a frame.
    threads: usize,
    store: Store,
    written: Arc<AtomicU64>,
    checkpoint: Arc<AtomicU64>,
}

impl FrameWriter {
    /// Starts the writer thread for the folder `journal`, which already has `frames` frames, and
    /// for the checkpoints.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the thread cannot be started.
    pub fn start(journal: &Path, header: &Header, frames: u64, store: Store) -> Result<Self, OutputError> {
        let (sender, items) = sync_channel(QUEUE);
        let (written, checkpoint) = (Arc::new(AtomicU64::new(frames)), Arc::new(AtomicU64::new(NO_STEP)));
        let writer = WriterThread {
            journal: journal.to_path_buf(),
            header: header.clone(),
            threads: rayon::current_num_threads(),
            store,
            written: Arc::clone(&written),
            checkpoint: Arc::clone(&checkpoint),
        };
        let thread = std::thread::Builder::new()
            .name("frames".to_owned())
            .spawn(move || writer.write(&items))
            .map_err(OutputError::io(journal, "start the writer thread"))?;
        Ok(Self { sender: Some(sender), thread: Some(thread), written, checkpoint })
    }

    /// Submits a frame; waits only while an earlier one is queued.
    ///
    /// # Errors
    /// The error of an earlier frame that stopped the writer thread.
    pub fn submit(&mut self, frame: Frame) -> Result<(), OutputError> {
        self.send(Item::Frame(Box::new(frame)))
    }

    /// Submits gridded fields as the time `index`.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_fields(&mut self, fields: FieldSnapshot, index: u64) -> Result<(), OutputError> {
        self.send(Item::Fields(Box::new(fields), index))
    }

    /// Submits the means of the gridded fields, which replace those submitted before.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_field_means(&mut self, means: FieldMeans) -> Result<(), OutputError> {
        self.send(Item::FieldMeans(Box::new(means)))
    }

    /// Submits quantities at the walls as the time `index`.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_walls(&mut self, walls: WallSnapshot, index: u64) -> Result<(), OutputError> {
        self.send(Item::Walls(Box::new(walls), index))
    }

    /// Submits the means at the walls, which replace those submitted before.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn submit_wall_means(&mut self, means: WallMeans) -> Result<(), OutputError> {
        self.send(Item::WallMeans(Box::new(means)))
    }

    /// Submits a checkpoint and the tables that must be durable before it.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn checkpoint(&mut self, checkpoint: Checkpoint, tables: Vec<PathBuf>) -> Result<(), OutputError> {
        self.send(Item::Checkpoint(Box::new(checkpoint), tables))
    }

    fn send(&mut self, item: Item) -> Result<(), OutputError> {
        let accepted = self.sender.as_ref().is_some_and(|sender| sender.send(item).is_ok());
        if accepted { Ok(()) } else { self.stop().and(Err(gone())) }
    }

    /// Returns the number of frames that are complete and durable.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Acquire)
    }

    /// Returns the step of the last checkpoint that is complete and durable.
    pub fn last_checkpoint(&self) -> Option<u64> {
        Some(self.checkpoint.load(Ordering::Acquire)).filter(|&step| step != NO_STEP)
    }

    /// Waits for the last frame and returns the number of frames written.
    ///
    /// # Errors
    /// The error that stopped the writer thread.
    pub fn finish(mut self) -> Result<u64, OutputError> {
        self.stop()?;
        Ok(self.written())
    }

    fn stop(&mut self) -> Result<(), OutputError> {
        self.sender = None;
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(result)) => result,
            Some(Err(_)) => Err(gone()),
            None => Ok(()),
        }
    }
}

impl Drop for FrameWriter {
    fn drop(&mut self) {
        // Submitted frames are written even when the run ends by another error, which is the one to
        // report.
        let _ = self.stop();
    }
}

fn gone() -> OutputError {
    OutputError::Request("no frames are written after an earlier error".to_owned())
}

impl WriterThread {
    fn write(self, items: &Receiver<Item>) -> Result<(), OutputError> {
        for item in items {
            match item {
                Item::Frame(frame) => {
                    let index = self.written.load(Ordering::Relaxed);
                    if index == 0 {
                        particles::write_walls(&paths::walls(&self.journal), &self.header, &frame)?;
                    }
                    let path = paths::frame(&self.journal, index);
                    particles::write_frame(&path, &self.header, &frame, self.threads)?;
                    self.written.store(index + 1, Ordering::Release);
                }
                Item::Fields(fields, index) => {
                    packing::write_time(&paths::fields(&self.journal, index), &self.header, *fields)?;
                }
                Item::FieldMeans(means) => {
                    packing::write_means(&paths::fields_means(&self.journal), &self.header, &means)?;
                }
                Item::Walls(walls, index) => {
                    files::write_time(&paths::surface(&self.journal, index), &self.header, *walls)?;
                }
                Item::WallMeans(means) => {
                    files::write_means(&paths::surface_means(&self.journal), &self.header, &means)?;
                }
                Item::Checkpoint(checkpoint, tables) => {
                    for table in tables {
                        let synced = File::open(&table).and_then(|file| file.sync_all());
                        synced.map_err(OutputError::io(&table, "write"))?;
                    }
                    self.store.write(&checkpoint)?;
                    self.checkpoint.store(checkpoint.facts.step, Ordering::Release);
                }
            }
        }
        Ok(())
    }
}
