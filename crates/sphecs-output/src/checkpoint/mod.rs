//! Checkpoints: the whole state of a run in one file, from which the run resumes bitwise
//! identically.
//!
//! - [`container`]: file format, checksums and reasons to reject a file
//! - [`store`]: folder of the checkpoints of a run, of which the last two are kept
//!
//! The writer thread of the frames writes a checkpoint after every frame that it counts, and makes
//! the tables durable before it. The output that a checkpoint counts is on the disk once the
//! checkpoint has its name.

pub mod container;
pub mod store;

use serde::{Deserialize, Serialize};

use sphecs_core::math::column::Columns;

/// Origin of a checkpoint and the output written up to its step.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Facts {
    /// SHA-256 of the scene and its tables, hexadecimal.
    pub scene_sha256: String,
    /// Version of sphecs that wrote it.
    pub version: String,
    /// Name of the instruction set of the pair sums; others give results that differ bitwise.
    pub lanes: String,
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Frames written up to the step.
    pub frames: u64,
    /// Times of the gridded fields up to the step.
    #[serde(default)]
    pub fields: u64,
    /// Times of the quantities at the walls up to the step.
    #[serde(default)]
    pub walls: u64,
    /// Bytes of `monitor.csv` up to the step.
    pub monitor_bytes: u64,
    /// Bytes of the CSV file of each probe up to the step, in the order of the scene.
    pub probes_bytes: Vec<u64>,
    /// Bytes of `forces.csv` up to the step; 0 without bodies.
    #[serde(default)]
    pub forces_bytes: u64,
}

/// State of a simulation with its facts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Checkpoint {
    /// Origin of the state.
    pub facts: Facts,
    /// Columns of the state.
    pub state: Columns,
}
