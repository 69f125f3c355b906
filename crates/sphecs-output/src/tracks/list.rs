//! Trajectories of a run: which pieces of fluid there are, and from which frame to which.

use super::{PASSAGE, TrackOptions};
use crate::error::OutputError;
use crate::frame::Frame;
use crate::results::Results;

/// Piece of fluid.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Track {
    /// Number of the trajectory.
    pub(crate) number: u64,
    /// First of the exported frames with a sample.
    pub(super) first: u32,
    /// Last of them.
    pub(super) last: u32,
}

impl Track {
    /// Returns the number of the trajectory of a particle.
    pub(super) fn number(id: u32, passage: u32) -> u64 {
        u64::from(passage) * PASSAGE + u64::from(id)
    }

    /// Returns the number of the particle.
    pub(crate) fn particle_id(&self) -> u32 {
        (self.number % PASSAGE) as u32
    }

    /// Returns the passage.
    pub(crate) fn passage(&self) -> u32 {
        (self.number / PASSAGE) as u32
    }
}

/// All trajectories, ascending by their numbers.
///
/// This order keeps pieces of fluid together that entered at about the same time, so that few
/// chunks have both values and none.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct TrackList(Vec<Track>);

impl TrackList {
    /// Finds the trajectories of some frames.
    ///
    /// # Errors
    /// [`OutputError`] when a frame cannot be read.
    pub(super) fn of(
        results: &Results,
        frames: &[usize],
        options: &TrackOptions,
    ) -> Result<Self, OutputError> {
        let mut found = Found::default();
        for (order, &index) in frames.iter().enumerate() {
            found.add(&results.occupancy(index, options.within.is_some())?, order as u32, options);
        }
        Ok(found.selected())
    }

    /// Returns a list of trajectories, which are sorted.
    pub(super) fn new(mut tracks: Vec<Track>) -> Self {
        tracks.sort_unstable_by_key(|track| track.number);
        Self(tracks)
    }

    /// Returns the trajectories.
    pub(super) fn tracks(&self) -> &[Track] {
        &self.0
    }

    /// Returns true without trajectories.
    pub(super) fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// Returns the row of a trajectory; None if it is not exported.
    pub(super) fn row(&self, number: u64) -> Option<usize> {
        self.0.binary_search_by_key(&number, |track| track.number).ok()
    }
}

/// Trajectories while the frames are read.
#[derive(Debug, Default)]
struct Found {
    tracks: Vec<(Track, bool)>,
    /// Index of the last trajectory of each slot.
    latest: Vec<Option<u32>>,
}

impl Found {
    fn add(&mut self, frame: &Frame, order: u32, options: &TrackOptions) {
        self.latest.resize(self.latest.len().max(frame.len()), None);
        for slot in 0..frame.len() {
            if !options.has_zone(frame.zone[slot]) || !options.has_id(slot as u32) {
                continue;
            }
            let number = Track::number(slot as u32, frame.passage[slot]);
            let known = self.latest[slot].filter(|&at| self.tracks[at as usize].0.number == number);
            let at = known.unwrap_or(self.tracks.len() as u32) as usize;
            if known.is_none() {
                self.latest[slot] = Some(at as u32);
                self.tracks.push((Track { number, first: order, last: order }, options.within.is_none()));
            }
            let (track, selected) = &mut self.tracks[at];
            track.last = order;
            *selected |= options.within.is_some_and(|corners| is_within(frame, slot, corners));
        }
    }

    fn selected(self) -> TrackList {
        let selected = self.tracks.into_iter().filter_map(|(track, selected)| selected.then_some(track));
        TrackList::new(selected.collect())
    }
}

fn is_within(frame: &Frame, slot: usize, [low, high]: [[f64; 3]; 2]) -> bool {
    (0..3).all(|axis| (low[axis]..=high[axis]).contains(&frame.position[axis][slot]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a frame of fluid particles with these passages along x; None is absent.
    fn frame(passages: &[Option<u32>]) -> Frame {
        let mut frame = Frame::absent(passages.len());
        for (slot, passage) in passages.iter().enumerate() {
            let Some(passage) = passage else { continue };
            frame.zone[slot] = 0;
            frame.passage[slot] = *passage;
            frame.position = [0, 1, 2].map(|axis| {
                let mut column = frame.position[axis].clone();
                column[slot] = if axis == 0 { slot as f64 } else { 0.0 };
                column
            });
        }
        frame
    }

    fn list(options: &TrackOptions) -> TrackList {
        let frames = [
            frame(&[Some(0), Some(0), None]),
            // Particle 1 left and entered again between the frames, 2 is new.
            frame(&[Some(0), Some(1), Some(1)]),
            frame(&[None, Some(1), Some(1)]),
            // Particle 0 is back in the same slot.
            frame(&[Some(3), Some(1), Some(1)]),
        ];
        let mut found = Found::default();
        for (order, frame) in frames.iter().enumerate() {
            found.add(frame, order as u32, options);
        }
        found.selected()
    }

    #[test]
    fn a_slot_is_one_trajectory_for_each_piece_of_fluid() {
        let list = list(&TrackOptions::default());
        let found: Vec<_> = list
            .tracks()
            .iter()
            .map(|track| (track.particle_id(), track.passage(), track.first, track.last))
            .collect();
        assert_eq!(found, [(0, 0, 0, 1), (1, 0, 0, 0), (1, 1, 1, 3), (2, 1, 1, 3), (0, 3, 3, 3)]);
        assert_eq!(list.row(30_000_000_000), Some(4));
        assert_eq!(list.row(Track::number(2, 0)), None);
    }

    #[test]
    fn numbers_and_a_box_select_whole_trajectories() {
        let numbers = |options: &TrackOptions| -> Vec<u32> {
            list(options).tracks().iter().map(Track::particle_id).collect()
        };
        assert_eq!(numbers(&TrackOptions { ids: vec![0..=0, 2..=7], ..TrackOptions::default() }), [0, 2, 0]);
        let within = Some([[0.5, -1.0, -1.0], [1.5, 1.0, 1.0]]);
        assert_eq!(numbers(&TrackOptions { within, ..TrackOptions::default() }), [1, 1]);
    }

    #[test]
    fn largest_particle_number_is_read_back() {
        let track = Track { number: Track::number(u32::MAX, 7), first: 0, last: 0 };
        assert_eq!((track.particle_id(), track.passage()), (u32::MAX, 7));
    }
}
