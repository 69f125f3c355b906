//! The journal of a run: one whole NetCDF file per frame, written by a thread of its own.
//!
//! A NetCDF-4 file that grows is not crash-safe: a kill between two frames can cost all of them, and on a
//! full disk the loss shows at the close only. A file per frame that gets its name when it is complete and
//! durable cannot be lost by what comes after (test `tests/killed_run.rs`).

use std::fs::{self, File};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, sync_channel};
use std::thread::JoinHandle;

use super::checkpoint::Checkpoint;
use super::checkpoint::store::Store;
use super::error::OutputError;
use super::frame::Frame;
use super::header::Header;
use super::netcdf::particles;

/// Name of the journal's folder in the run folder.
pub const FOLDER: &str = "journal";

/// Frames that wait at most: one is written while the next is ready. More would only hide a slow disk.
const QUEUE: usize = 1;

/// Path of the walls in a journal.
pub fn walls_path(journal: &Path) -> PathBuf {
    journal.join("walls.nc")
}

/// Path of a frame in a journal.
fn frame_path(journal: &Path, index: u64) -> PathBuf {
    journal.join(format!("frame-{index:08}.nc"))
}

/// The whole frames of a journal in their order.
///
/// # Errors
/// [`OutputError::Io`] when the folder does not read.
pub fn frame_paths(journal: &Path) -> Result<Vec<PathBuf>, OutputError> {
    let mut paths = Vec::new();
    for entry in fs::read_dir(journal).map_err(OutputError::io(journal, "read"))? {
        let path = entry.map_err(OutputError::io(journal, "read"))?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with("frame-") && name.ends_with(".nc") {
            paths.push(path);
        }
    }
    paths.sort();
    Ok(paths)
}

/// Index of a frame by the name of its file.
pub fn frame_index(path: &Path) -> Option<u64> {
    let name = path.file_name()?.to_str()?;
    name.strip_prefix("frame-")?.strip_suffix(".nc")?.parse().ok()
}

/// Writes the walls and the frames of a run into the folder `journal`, from the first on.
///
/// # Errors
/// [`OutputError`] of a frame, or with path and cause.
pub fn write_all(
    journal: &Path,
    header: &Header,
    count: usize,
    mut frame: impl FnMut(usize) -> Result<Frame, OutputError>,
) -> Result<(), OutputError> {
    (0..count).try_for_each(|index| write_frame(journal, header, index as u64, &frame(index)?))
}

/// Something to be written.
enum Work {
    Frame(Box<Frame>),
    /// A checkpoint, and the tables that must be durable before it.
    Checkpoint(Box<Checkpoint>, Vec<File>),
}

/// No checkpoint yet.
const NONE: u64 = u64::MAX;

/// Hands frames and checkpoints to the thread that writes them, so that the flow goes on meanwhile.
#[derive(Debug)]
pub struct FrameWriter {
    sender: Option<SyncSender<Work>>,
    thread: Option<JoinHandle<Result<(), OutputError>>>,
    written: Arc<AtomicU64>,
    checkpoint: Arc<AtomicU64>,
}

/// What the thread writes into.
struct Desk {
    journal: PathBuf,
    header: Header,
    store: Store,
    written: Arc<AtomicU64>,
    checkpoint: Arc<AtomicU64>,
}

impl FrameWriter {
    /// Starts the thread that writes into the folder `journal`, which has so many frames, and the checkpoints beside it.
    ///
    /// # Errors
    /// [`OutputError::Io`] when no thread can be started.
    pub fn start(journal: &Path, header: &Header, frames: u64, store: Store) -> Result<Self, OutputError> {
        let (sender, work) = sync_channel(QUEUE);
        let (written, checkpoint) = (Arc::new(AtomicU64::new(frames)), Arc::new(AtomicU64::new(NONE)));
        let desk = Desk {
            journal: journal.to_path_buf(),
            header: header.clone(),
            store,
            written: Arc::clone(&written),
            checkpoint: Arc::clone(&checkpoint),
        };
        let thread = std::thread::Builder::new()
            .name("frames".to_owned())
            .spawn(move || desk.write(&work))
            .map_err(OutputError::io(journal, "start a thread to write"))?;
        Ok(Self { sender: Some(sender), thread: Some(thread), written, checkpoint })
    }

    /// Hands over a frame; waits only while an earlier one still queues.
    ///
    /// # Errors
    /// The error that stopped the writing of an earlier frame.
    pub fn submit(&mut self, frame: Frame) -> Result<(), OutputError> {
        self.send(Work::Frame(Box::new(frame)))
    }

    /// Hands over a checkpoint and the tables that must be durable before it.
    ///
    /// # Errors
    /// As [`Self::submit`].
    pub fn checkpoint(&mut self, checkpoint: Checkpoint, tables: Vec<File>) -> Result<(), OutputError> {
        self.send(Work::Checkpoint(Box::new(checkpoint), tables))
    }

    fn send(&mut self, work: Work) -> Result<(), OutputError> {
        let accepted = self.sender.as_ref().is_some_and(|sender| sender.send(work).is_ok());
        if accepted { Ok(()) } else { self.stop().and(Err(gone())) }
    }

    /// Frames that are whole and durable: what may be reported as written.
    pub fn written(&self) -> u64 {
        self.written.load(Ordering::Acquire)
    }

    /// Step of the last checkpoint that is whole and durable.
    pub fn last_checkpoint(&self) -> Option<u64> {
        Some(self.checkpoint.load(Ordering::Acquire)).filter(|&step| step != NONE)
    }

    /// Waits for the last frame; the number of frames written.
    ///
    /// # Errors
    /// The error that stopped the writing.
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
        // A frame handed over is written even when the run ends by an error elsewhere, which is the one to report.
        let _ = self.stop();
    }
}

fn gone() -> OutputError {
    OutputError::Request("frames are no longer written after an earlier error".to_owned())
}

impl Desk {
    fn write(self, work: &Receiver<Work>) -> Result<(), OutputError> {
        for work in work {
            match work {
                Work::Frame(frame) => {
                    let index = self.written.load(Ordering::Relaxed);
                    write_frame(&self.journal, &self.header, index, &frame)?;
                    self.written.store(index + 1, Ordering::Release);
                }
                Work::Checkpoint(checkpoint, tables) => {
                    for table in tables {
                        table
                            .sync_all()
                            .map_err(OutputError::io(&self.journal, "write the tables beside"))?;
                    }
                    self.store.write(&checkpoint)?;
                    self.checkpoint.store(checkpoint.facts.step, Ordering::Release);
                }
            }
        }
        Ok(())
    }
}

fn write_frame(journal: &Path, header: &Header, index: u64, frame: &Frame) -> Result<(), OutputError> {
    if index == 0 {
        particles::write_walls(&walls_path(journal), header, frame)?;
    }
    particles::write_frame(&frame_path(journal, index), header, frame)
}
