//! Particles that the slots of a NetCDF file belong to.

use crate::frame::Frame;
use sphecs_core::particles::zone::Zone;

/// Particle numbers of the slots of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Slots {
    /// Numbers of all other particles, ascending.
    pub(crate) particles: Vec<u32>,
    /// Numbers of the wall particles that do not move, ascending.
    pub(crate) walls: Vec<u32>,
    /// Wall part of each of `particles`, [`NO_PART`] if it is no wall; empty if no walls move.
    pub(crate) moving_parts: Vec<u16>,
}

/// Wall part of a particle that is no wall.
pub(crate) const NO_PART: u16 = u16::MAX;

impl Slots {
    /// Returns the slots of a frame. Walls stay walls during a run.
    pub(crate) fn of(frame: &Frame) -> Self {
        let moving = &frame.moving_walls;
        let is_fixed = |slot: &u32| frame.zone[*slot as usize] == Zone::Wall as u8 && !moving.contains(slot);
        let (walls, particles): (Vec<u32>, Vec<u32>) = (0..frame.len() as u32).partition(is_fixed);
        let part = |slot: &u32| if moving.contains(slot) { frame.patch[*slot as usize] } else { NO_PART };
        let moving_parts = if moving.is_empty() { Vec::new() } else { particles.iter().map(part).collect() };
        Self { particles, walls, moving_parts }
    }

    /// Returns the number of slots of a frame that has all these particles.
    pub(super) fn dense_len(&self) -> usize {
        let last = |numbers: &[u32]| numbers.last().map_or(0, |&last| last as usize + 1);
        last(&self.particles).max(last(&self.walls))
    }
}

/// Returns the values of some slots.
pub(super) fn pick<T: Copy>(column: &[T], slots: &[u32]) -> Vec<T> {
    slots.iter().map(|&slot| column[slot as usize]).collect()
}
