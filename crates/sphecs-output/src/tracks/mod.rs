//! Particles as trajectories in `tracks.nc`, one for each piece of fluid.
//!
//! A particle number alone is no identity: a particle that left waits in the reservoir, or its
//! number is free, until another piece of fluid enters with it. `passage` counts these entries. So
//! the pair of number and passage names a piece of fluid for the whole run, whatever frames are
//! exported. The file has it as one whole number:
//!
//! ```text
//! trajectory = passage · 10¹⁰ + particle_id
//! ```
//!
//! # Layout
//! CF knows trajectories as (trajectory, time), as (trajectory, obs) and as a contiguous ragged
//! array. This is (trajectory, time), with NaN where a piece of fluid is not in the flow: all
//! frames have common times, so that `sel` takes a trajectory, a time or both, and TrajAn and the
//! IOOS compliance checker read it as it is. Chunks without any value are not stored. With 4466
//! trajectories over 401 frames of the quickstart, each of which lasts a quarter of the run, the
//! layouts compare as follows:
//!
//! | layout | file, MB | read one, s | TrajAn 0.12 |
//! |---|---|---|---|
//! | (trajectory, time) | 13.2 | 0.06 | at once, `Orthogonal` |
//! | (trajectory, obs) | 13.0 | 0.08 | at once, `Ragged` |
//! | contiguous ragged | 11.7 | 0.05 | after 28 s, without x, as CF has x as a coordinate |
//!
//! # Memory
//! Frames are sorted by time and trajectories are not, so a contiguous ragged array needs the whole
//! run in memory, or several passes. Here a first pass finds the trajectories, and a second one
//! fills windows of some frames, which are written as chunks. The number of frames of a window is
//! the largest one that fits into 512 MiB.

mod list;
mod window;

pub(crate) use self::list::Track;
pub(crate) use self::window::{Tile, WindowShape};

use std::ops::RangeInclusive;
use std::path::Path;

use self::list::TrackList;
use self::window::Windows;
use crate::error::OutputError;
use crate::netcdf::trajectories::{self, TracksContent};
use crate::results::Results;
use sphecs_core::particles::zone::Zone;

/// Largest memory of a window, B.
const BUDGET: usize = 512 << 20;

/// Factor of the passage in the number of a trajectory, above every particle number.
const PASSAGE: u64 = 10_000_000_000;

/// Options of an export of trajectories.
#[derive(Clone, Debug, PartialEq)]
pub struct TrackOptions {
    /// Every which frame is written; 1 for all.
    pub every: usize,
    /// Zones whose particles are written.
    pub zones: Vec<Zone>,
    /// Particle numbers; empty for all.
    pub ids: Vec<RangeInclusive<u32>>,
    /// Lower and upper corner of a box, m, that a trajectory must pass in one of the frames.
    pub within: Option<[[f64; 3]; 2]>,
}

impl Default for TrackOptions {
    fn default() -> Self {
        Self { every: 1, zones: vec![Zone::Fluid], ids: Vec::new(), within: None }
    }
}

impl TrackOptions {
    fn has_id(&self, id: u32) -> bool {
        self.ids.is_empty() || self.ids.iter().any(|range| range.contains(&id))
    }

    fn has_zone(&self, number: u8) -> bool {
        Zone::from_number(number).is_some_and(|zone| self.zones.contains(&zone))
    }
}

/// Numbers of an export of trajectories.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrackExport {
    /// Trajectories.
    pub trajectories: usize,
    /// Frames.
    pub frames: usize,
}

/// Writes the trajectories of a run. Calls `done` with the number of frames written and of all.
///
/// # Errors
/// [`OutputError`] when the run has no frames, no particle is selected, or a file cannot be read or
/// written.
pub fn export_tracks(
    results: &Results,
    target: &Path,
    options: &TrackOptions,
    mut done: impl FnMut(usize, usize),
) -> Result<TrackExport, OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    results.refuse_own_file(target)?;
    let frames: Vec<usize> = (0..results.len()).step_by(options.every.max(1)).collect();
    let list = TrackList::of(results, &frames, options)?;
    if list.is_empty() {
        return Err(OutputError::Request(format!(
            "`{}`: has no such particle in {} of its {} frames; give other particles, zones or frames",
            results.folder.display(),
            frames.len(),
            results.len()
        )));
    }
    let shape = WindowShape::fitting(&list, frames.len(), results.header.dimensions, BUDGET);
    let times = frames.iter().map(|&index| results.frame_time(index)).collect::<Result<Vec<_>, _>>()?;
    let content = TracksContent {
        times: &times,
        tracks: list.tracks(),
        zones: &options.zones,
        shape: &shape,
        every: options.every.max(1),
    };
    let mut windows = Windows::new(results, &frames, &list, options, shape);
    trajectories::write(target, &results.header, &content, |window| {
        windows.next(window, |written| done(written, frames.len()))
    })?;
    Ok(TrackExport { trajectories: list.tracks().len(), frames: frames.len() })
}
