//! What the loop of a run remembers from step to step: part of its checkpoints beside the state of the flow.

use serde::{Deserialize, Serialize};

use super::due::Due;
use sphecs_engine::systems::monitor::MonitorRow;

/// Name of the log among the columns of a checkpoint.
pub const NAME: &str = "run.log";

/// What the loop of a run remembers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Log {
    /// When the next frame is due.
    pub frames: Due,
    /// When the next row is due.
    pub rows: Due,
    /// Step of the last frame; None before the first.
    pub last_frame: Option<u64>,
    /// Frames handed over.
    pub frame_count: u64,
    /// The last row.
    pub last_row: MonitorRow,
    /// Step of the last row; None before the first.
    pub last_row_step: Option<u64>,
    /// Steps × particles so far, reservoir not counted.
    pub particle_steps: f64,
    /// Wall time of the processes before this one, s.
    pub wall_time: f64,
    /// Wall time spent on handing frames, rows and checkpoints over, s.
    pub output_time: f64,
    /// Wall time by stage of the processes before this one, s.
    pub stages: Vec<f64>,
}

impl Log {
    /// Nothing written yet, with these intervals in s.
    pub fn new(frames_every: f64, rows_every: f64) -> Self {
        Self {
            frames: Due::every(frames_every),
            rows: Due::every(rows_every),
            last_frame: None,
            frame_count: 0,
            last_row: MonitorRow::default(),
            last_row_step: None,
            particle_steps: 0.0,
            wall_time: 0.0,
            output_time: 0.0,
            stages: Vec::new(),
        }
    }

    /// Wall time of a stage (by its place in the table) in all processes, s, when this one has spent `seconds` on it.
    pub fn stage(&self, index: usize, seconds: f64) -> f64 {
        self.stages.get(index).copied().unwrap_or(0.0) + seconds
    }
}
