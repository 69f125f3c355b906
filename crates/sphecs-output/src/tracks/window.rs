//! Windows of some frames, in which the samples of all trajectories are collected.
//!
//! Trajectories are taken in blocks, and the samples of a block in a window are a chunk of each
//! variable. Blocks without samples in a window take no memory and are not written.

use std::collections::BTreeMap;

use super::TrackOptions;
use super::list::{Track, TrackList};
use crate::error::OutputError;
use crate::frame::{ABSENT, Frame};
use crate::results::Results;

/// Largest number of frames of a window: with more, chunks would be empty more seldom.
const MAX_FRAMES: usize = 64;

/// Values of a chunk, about; of less, the index of the chunks would be large.
const CHUNK_VALUES: usize = 1 << 14;

/// Smallest and largest number of trajectories of a block.
const BLOCK: [usize; 2] = [64, 4096];

/// Trajectories and frames of a chunk.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct WindowShape {
    /// Trajectories of a block.
    pub(crate) block: usize,
    /// Frames of a window.
    pub(crate) frames: usize,
}

impl WindowShape {
    /// Returns the shape with the most frames whose windows all fit into a memory, B.
    pub(super) fn fitting(list: &TrackList, frames: usize, dimensions: usize, budget: usize) -> Self {
        let halved = std::iter::successors(Some(MAX_FRAMES), |&count| (count > 1).then_some(count / 2));
        let shapes = halved.map(|count| Self {
            block: (CHUNK_VALUES / count).clamp(BLOCK[0], BLOCK[1]).min(list.tracks().len()),
            frames: count.min(frames),
        });
        let fits = |shape: &Self| {
            let tile = shape.block * shape.frames * bytes_of_sample(dimensions);
            shape.largest_window(list, frames).saturating_mul(tile) <= budget
        };
        let smallest = Self { block: BLOCK[0].min(list.tracks().len()), frames: 1 };
        shapes.into_iter().find(fits).unwrap_or(smallest)
    }

    /// Returns the largest number of blocks that have samples in a window.
    fn largest_window(&self, list: &TrackList, frames: usize) -> usize {
        let mut counts = vec![0; frames.div_ceil(self.frames)];
        for block in list.tracks().chunks(self.block) {
            let first = block.iter().map(|track| track.first as usize).min().unwrap_or(0);
            let last = block.iter().map(|track| track.last as usize).max().unwrap_or(0);
            counts[first / self.frames..=last / self.frames].iter_mut().for_each(|count| *count += 1);
        }
        counts.into_iter().max().unwrap_or(0)
    }
}

/// Bytes of a sample: position, velocity, density, pressure, tag and zone.
fn bytes_of_sample(dimensions: usize) -> usize {
    dimensions * 12 + 13
}

/// Samples of a block in a window, by trajectory and then by frame; NaN where it has none.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Tile {
    /// Position by axis, m.
    pub(crate) position: Vec<Vec<f64>>,
    /// Velocity by axis, m/s.
    pub(crate) velocity: Vec<Vec<f32>>,
    /// Density, kg/m³.
    pub(crate) density: Vec<f32>,
    /// Pressure, Pa.
    pub(crate) pressure: Vec<f32>,
    /// Passive scalar.
    pub(crate) tag: Vec<f32>,
    /// Zone, or [`ABSENT`].
    pub(crate) zone: Vec<u8>,
}

impl Tile {
    fn new(shape: WindowShape, dimensions: usize) -> Self {
        let values = shape.block * shape.frames;
        Self {
            position: vec![vec![f64::NAN; values]; dimensions],
            velocity: vec![vec![f32::NAN; values]; dimensions],
            density: vec![f32::NAN; values],
            pressure: vec![f32::NAN; values],
            tag: vec![f32::NAN; values],
            zone: vec![ABSENT; values],
        }
    }

    fn put(&mut self, at: usize, frame: &Frame, slot: usize) {
        for axis in 0..self.position.len() {
            self.position[axis][at] = frame.position[axis][slot];
            self.velocity[axis][at] = frame.velocity[axis][slot];
        }
        self.density[at] = frame.density[slot];
        self.pressure[at] = frame.pressure[slot];
        self.tag[at] = frame.tag[slot];
        self.zone[at] = frame.zone[slot];
    }
}

/// Reader of a run by windows.
pub(super) struct Windows<'a> {
    results: &'a Results,
    frames: &'a [usize],
    list: &'a TrackList,
    options: &'a TrackOptions,
    shape: WindowShape,
    /// Number and row of the last trajectory of each slot.
    latest: Vec<(u64, Option<usize>)>,
}

impl<'a> Windows<'a> {
    pub(super) fn new(
        results: &'a Results,
        frames: &'a [usize],
        list: &'a TrackList,
        options: &'a TrackOptions,
        shape: WindowShape,
    ) -> Self {
        Self { results, frames, list, options, shape, latest: Vec::new() }
    }

    /// Returns the blocks with samples of a window by their numbers. Calls `done` with the number
    /// of frames read so far.
    ///
    /// # Errors
    /// [`OutputError`] when a frame cannot be read.
    pub(super) fn next(
        &mut self,
        window: usize,
        mut done: impl FnMut(usize),
    ) -> Result<BTreeMap<usize, Tile>, OutputError> {
        let mut tiles = BTreeMap::new();
        let start = window * self.shape.frames;
        let end = (start + self.shape.frames).min(self.frames.len());
        for (column, &index) in self.frames[start..end].iter().enumerate() {
            let frame = self.results.frame(index)?;
            self.add(&frame, column, &mut tiles);
            done(start + column + 1);
        }
        Ok(tiles)
    }

    fn add(&mut self, frame: &Frame, column: usize, tiles: &mut BTreeMap<usize, Tile>) {
        let WindowShape { block, frames } = self.shape;
        self.latest.resize(self.latest.len().max(frame.len()), (u64::MAX, None));
        for slot in 0..frame.len() {
            if !self.options.has_zone(frame.zone[slot]) {
                continue;
            }
            let number = Track::number(slot as u32, frame.passage[slot]);
            if self.latest[slot].0 != number {
                self.latest[slot] = (number, self.list.row(number));
            }
            let Some(row) = self.latest[slot].1 else { continue };
            let dimensions = self.results.header.dimensions;
            let tile = tiles.entry(row / block).or_insert_with(|| Tile::new(self.shape, dimensions));
            tile.put(row % block * frames + column, frame, slot);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns 1000 trajectories, each of which lasts a tenth of 1000 frames.
    fn list() -> TrackList {
        let track =
            |row: u32| Track { number: u64::from(row), first: row * 9 / 10, last: row * 9 / 10 + 100 };
        TrackList::new((0..1000).map(track).collect())
    }

    #[test]
    fn windows_fit_into_the_memory() {
        let list = list();
        let bytes = |shape: WindowShape| {
            shape.largest_window(&list, 1000) * shape.block * shape.frames * bytes_of_sample(2)
        };
        for budget in [300_000, 1_000_000, 100_000_000] {
            let shape = WindowShape::fitting(&list, 1000, 2, budget);
            assert!(bytes(shape) <= budget, "{shape:?} takes {} B of {budget}", bytes(shape));
        }
        assert_eq!(WindowShape::fitting(&list, 1000, 2, usize::MAX), WindowShape { block: 256, frames: 64 });
        let one = TrackList::new(vec![Track { number: 3, first: 0, last: 6 }]);
        assert_eq!(WindowShape::fitting(&one, 7, 2, usize::MAX), WindowShape { block: 1, frames: 7 });
        assert_eq!(WindowShape::fitting(&list, 1000, 2, 0).frames, 1, "the smallest there is");
    }

    #[test]
    fn window_takes_the_blocks_with_samples_in_it_only() {
        let shape = WindowShape { block: 100, frames: 50 };
        // A block begins over 90 frames and ends 100 frames later: it touches at most five windows
        // of 50 frames, and a window at most three blocks.
        assert_eq!(shape.largest_window(&list(), 1001), 3);
    }
}
