//! Particles that the slots of a NetCDF file belong to.

use crate::frame::Frame;
use sphecs_core::particles::zone::Zone;

/// Particle numbers of the slots of a file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Slots {
    /// Numbers of the particles that are not walls, ascending.
    pub(crate) particles: Vec<u32>,
    /// Numbers of the wall particles, ascending.
    pub(crate) walls: Vec<u32>,
}

impl Slots {
    /// Returns the slots of a frame. Walls stay walls during a run.
    pub(crate) fn of(frame: &Frame) -> Self {
        let (walls, particles) =
            (0..frame.len() as u32).partition(|&slot| frame.zone[slot as usize] == Zone::Wall as u8);
        Self { particles, walls }
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
