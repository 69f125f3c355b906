//! State of the run loop that a checkpoint saves in addition to the state of the flow.

use serde::{Deserialize, Serialize};

use super::output_schedule::OutputInterval;
use sphecs_engine::systems::monitor::MonitorRow;

/// Column of a checkpoint that holds this state.
pub const COLUMN: &str = "run.log";

/// Counters and schedules of the run loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunState {
    /// Schedule of the frames.
    pub frames: OutputInterval,
    /// Schedule of the monitor rows.
    pub rows: OutputInterval,
    /// Step of the last frame; None before the first.
    pub last_frame: Option<u64>,
    /// Number of frames submitted.
    pub frame_count: u64,
    /// Last monitor row.
    pub last_row: MonitorRow,
    /// Step of the last row; None before the first.
    pub last_row_step: Option<u64>,
    /// Steps × particles so far, reservoir not counted.
    pub particle_steps: f64,
    /// Wall time of the processes before this one, s.
    pub wall_time: f64,
    /// Wall time spent on submitting frames, rows and checkpoints, s.
    pub output_time: f64,
    /// Wall time by stage of the processes before this one, s.
    pub stages: Vec<f64>,
}

impl RunState {
    /// Returns the state before the first output, with the intervals of frames and rows in s.
    pub fn new(frames_every: f64, rows_every: f64) -> Self {
        Self {
            frames: OutputInterval::every(frames_every),
            rows: OutputInterval::every(rows_every),
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

    /// Returns the wall time of a stage in all processes, s, with `seconds` spent in this one.
    pub fn stage(&self, index: usize, seconds: f64) -> f64 {
        self.stages.get(index).copied().unwrap_or(0.0) + seconds
    }
}
