//! Wall-clock time by set.

use std::time::Instant;

use bevy_ecs::resource::Resource;

use super::schedule::TIMED;

/// Seconds spent in each timed set since the start.
#[derive(Resource, Clone, Debug)]
pub struct Stopwatch {
    last: Instant,
    seconds: [f64; TIMED.len()],
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self { last: Instant::now(), seconds: [0.0; TIMED.len()] }
    }
}

impl Stopwatch {
    /// Starts the next interval without charging the time since the last one to anybody.
    pub fn start(&mut self) {
        self.last = Instant::now();
    }

    /// Charges the time since the last call to the set with this index of [`TIMED`].
    pub fn lap(&mut self, index: usize) {
        let now = Instant::now();
        self.seconds[index] += (now - self.last).as_secs_f64();
        self.last = now;
    }

    /// Name and seconds of each set, in the order of a step.
    pub fn table(&self) -> Vec<(&'static str, f64)> {
        TIMED.into_iter().zip(self.seconds).collect()
    }
}
