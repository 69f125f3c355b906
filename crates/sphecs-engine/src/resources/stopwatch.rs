//! Wall-clock time by set.

use std::time::Instant;

use bevy_ecs::resource::Resource;

use crate::schedule::TIMED_SETS;

/// Seconds spent in each timed set since the start.
#[derive(Resource, Clone, Debug)]
pub struct Stopwatch {
    last: Instant,
    seconds: [f64; TIMED_SETS],
}

impl Default for Stopwatch {
    fn default() -> Self {
        Self { last: Instant::now(), seconds: [0.0; TIMED_SETS] }
    }
}

impl Stopwatch {
    /// Starts the next interval; the time since the last one is attributed to no set.
    pub fn start(&mut self) {
        self.last = Instant::now();
    }

    /// Adds the time since the last call to the set with this index in the order of a step.
    pub(crate) fn lap(&mut self, index: usize) {
        let now = Instant::now();
        self.seconds[index] += (now - self.last).as_secs_f64();
        self.last = now;
    }

    /// Returns name and seconds of each set, in the order of a step.
    pub fn table(&self) -> Vec<(&'static str, f64)> {
        crate::schedule::timed_names().zip(self.seconds).collect()
    }
}
