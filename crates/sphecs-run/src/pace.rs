//! How fast a run goes and how long it will take.

use std::collections::VecDeque;

use sphecs_engine::resources::clock::Clock;

/// Seconds of wall time over which the pace is taken: long enough to smooth the frames, short enough to
/// follow a time step that shrinks as the flow starts.
const WINDOW: f64 = 60.0;

/// Least wall time between two samples, s: with a step of microseconds the window would hold millions.
const SAMPLING: f64 = 0.25;

/// How far a run has come.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Wall time since the first step of this process, s.
    pub elapsed: f64,
    /// Part of the run that is done, 0 to 1.
    pub fraction: f64,
    /// Steps × particles so far, reservoir not counted.
    pub particle_steps: f64,
}

/// Part of a run that is done, 0 to 1.
pub fn fraction(clock: &Clock, until: f64, most_steps: u64) -> f64 {
    (clock.time / until).max(clock.step as f64 / most_steps as f64).min(1.0)
}

/// The pace of the last minute.
#[derive(Clone, Debug)]
pub struct Pace {
    samples: VecDeque<Progress>,
    last: Progress,
}

impl Default for Pace {
    fn default() -> Self {
        Self::from(Progress::default())
    }
}

impl From<Progress> for Pace {
    /// The pace from where a run, or its part in this process, begins.
    fn from(begun: Progress) -> Self {
        Self { samples: VecDeque::from([begun]), last: begun }
    }
}

impl Pace {
    /// Takes note of the progress made.
    pub fn record(&mut self, progress: Progress) {
        self.last = progress;
        if self.samples.back().is_none_or(|back| progress.elapsed - back.elapsed >= SAMPLING) {
            self.samples.push_back(progress);
        }
        // One sample older than the window stays, so that the window is always covered.
        while self.samples.get(1).is_some_and(|second| progress.elapsed - second.elapsed > WINDOW) {
            self.samples.pop_front();
        }
    }

    /// Particle-steps per second of wall time, 1/s.
    pub fn particle_steps_per_second(&self) -> f64 {
        self.slope(|progress| progress.particle_steps)
    }

    /// Wall time left, s; None before the first measure.
    pub fn seconds_left(&self) -> Option<f64> {
        let rate = self.slope(|progress| progress.fraction);
        (rate > 0.0).then(|| (1.0 - self.last.fraction).max(0.0) / rate)
    }

    fn slope(&self, figure: impl Fn(&Progress) -> f64) -> f64 {
        let first = self.samples.front().copied().unwrap_or_default();
        let seconds = self.last.elapsed - first.elapsed;
        if seconds > 0.0 { (figure(&self.last) - figure(&first)) / seconds } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_pace_is_returned() {
        let mut pace = Pace::default();
        for tenth in 1..=3000 {
            let elapsed = f64::from(tenth) * 0.1;
            pace.record(Progress { elapsed, fraction: elapsed / 600.0, particle_steps: 2e6 * elapsed });
        }
        assert!((pace.particle_steps_per_second() - 2e6).abs() < 1.0);
        assert!((pace.seconds_left().expect("measured") - 300.0).abs() < 1e-6);
        assert!(pace.samples.len() < 250, "{} samples kept", pace.samples.len());
    }

    #[test]
    fn slower_pace_is_followed_within_the_window() {
        let mut pace = Pace::default();
        for second in 1..=200 {
            let elapsed = f64::from(second);
            let fraction = if second < 100 { elapsed * 1e-3 } else { 0.1 + (elapsed - 100.0) * 1e-4 };
            pace.record(Progress { elapsed, fraction, particle_steps: 0.0 });
        }
        let left = pace.seconds_left().expect("measured");
        assert!((left - 0.89 / 1e-4).abs() < 1.0, "{left} s left");
    }

    #[test]
    fn what_was_done_before_a_restart_is_no_pace() {
        let mut pace = Pace::from(Progress { elapsed: 0.0, fraction: 0.5, particle_steps: 1e9 });
        pace.record(Progress { elapsed: 10.0, fraction: 0.6, particle_steps: 1e9 + 50.0 });
        assert!((pace.particle_steps_per_second() - 5.0).abs() < 1e-6);
        assert!((pace.seconds_left().expect("measured") - 40.0).abs() < 1e-6);
    }

    #[test]
    fn nothing_is_foretold_before_the_first_measure() {
        assert_eq!(Pace::default().seconds_left(), None);
    }
}
