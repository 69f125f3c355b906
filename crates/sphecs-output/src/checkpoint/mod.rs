//! Checkpoints: the whole state of a run in one file, from which it goes on to the same bits.
//!
//! - [`container`]: the file, its checksums and what can be wrong with it
//! - [`store`]: the folder of a run's checkpoints, of which the last two are kept
//! - `cut`: output cut back to a checkpoint
//!
//! A checkpoint is written by the thread that writes the frames, behind every frame that it counts and with the tables made durable
//! before it: what it says of the output is on the disk when it has its name.

pub mod container;
pub mod cut;
pub mod store;

use serde::{Deserialize, Serialize};

use sphecs_core::math::column::Columns;

/// What a checkpoint says of itself and of the output at its step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// SHA-256 of the scene and its tables, hexadecimal.
    pub scene_sha256: String,
    /// Version of sphecs that wrote it.
    pub version: String,
    /// Name of the instruction set that the pair sums ran on: others give other bits.
    pub lanes: String,
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Frames written up to there.
    pub frames: u64,
    /// Bytes of `monitor.csv` up to there.
    pub monitor_bytes: u64,
    /// Bytes of `probes.csv` up to there; 0 without probes.
    pub probes_bytes: u64,
    /// Bytes of `forces.csv` up to there; 0 without bodies.
    #[serde(default)]
    pub forces_bytes: u64,
}

/// A state with its facts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// What it is of.
    pub facts: Facts,
    /// The state.
    pub state: Columns,
}
