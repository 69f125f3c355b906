//! Compiled part of the Python package `sphecs`: the module `sphecs._sphecs`.
//!
//! - `scene_input`: scenes given by a path or a text, with changed values
//! - `scene_check`: faults and notes of a scene
//! - `scene_run`: run of a scene to its end, as the command line runs it
//! - `stepping`: simulation that a program advances step by step
//! - `snapshot`: arrays of the particles
//! - `body_motion`: forces on the bodies and their motions
//! - `callable`: forces that a Python function computes
//! - `run_files`: summary of a run, and the frames of one that is under way
//! - `exceptions`: errors of the engine as Python exceptions
//! - `guard`: panics as exceptions
//!
//! What a user sees is in `python/src/sphecs/`, which adds defaults, documentation and everything
//! that needs no speed. Nothing here computes a flow.

mod body_motion;
mod callable;
mod exceptions;
mod guard;
mod run_files;
mod scene_check;
mod scene_input;
mod scene_run;
mod snapshot;
mod stepping;

use pyo3::pymodule;

/// The module `sphecs._sphecs`.
#[pymodule]
mod _sphecs {
    #[pymodule_export]
    use super::run_files::{journal_frames, pack, run_summary};
    #[pymodule_export]
    use super::scene_check::check;
    #[pymodule_export]
    use super::scene_run::{command_line, run};
    #[pymodule_export]
    use super::stepping::Simulation;

    /// Version of the engine.
    #[pymodule_export]
    const VERSION: &str = env!("CARGO_PKG_VERSION");
}
