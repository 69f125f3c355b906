//! Times at which frames, rows and checkpoints are due, and the wall-time limit of a run.

use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

/// Simulated times 0, `every`, 2 `every`, …, each of which is served by the first step at or past
/// it.
///
/// Steps are never shortened to hit an output time, so that output does not change the flow. Where
/// one step passes several output times, one output serves all of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutputInterval {
    every: f64,
    next: u64,
}

impl OutputInterval {
    /// Returns the times from 0 on at an interval in s, > 0.
    pub fn every(every: f64) -> Self {
        Self { every, next: 0 }
    }

    /// Returns the schedule for a run resumed at `time`, s, with an interval that may be new.
    ///
    /// With a new interval the first multiple past `time` is due next.
    #[must_use]
    pub fn resumed(self, every: f64, time: f64) -> Self {
        if every.to_bits() == self.every.to_bits() {
            return self;
        }
        let mut interval = Self::every(every);
        interval.advance(time);
        interval
    }

    /// Returns true if an output is due at `time`, s, and moves the next output past `time`.
    pub fn advance(&mut self, time: f64) -> bool {
        if time < self.time() {
            return false;
        }
        // The time is a multiple of the interval; a running sum would accumulate rounding errors
        // over a million rows.
        self.next = (time / self.every).floor() as u64 + 1;
        if self.time() <= time {
            self.next += 1;
        }
        true
    }

    /// Returns the time of the next output, s.
    pub fn time(&self) -> f64 {
        self.next as f64 * self.every
    }
}

/// Longest wait in the schedule, a century, s; longer ones are never reached.
const NEVER: Duration = Duration::from_secs(100 * 365 * 86_400);

/// Returns a wall time given in s; values that `Duration` cannot hold become its maximum.
fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// Wall-clock times of the next checkpoint and of the end of the run.
#[derive(Clone, Copy, Debug)]
pub struct WallClock {
    every: Duration,
    next: Instant,
    end: Option<Instant>,
}

impl WallClock {
    /// Schedules checkpoints at an interval in s of wall time, > 0, and the end after `limit`, s.
    pub fn new(now: Instant, every: f64, limit: Option<f64>) -> Self {
        let every = duration(every).min(NEVER);
        Self { every, next: now + every, end: limit.map(|limit| now + duration(limit).min(NEVER)) }
    }

    /// Returns true if the checkpoint interval has passed.
    pub fn is_checkpoint_due(&self, now: Instant) -> bool {
        now >= self.next
    }

    /// Restarts the checkpoint interval.
    pub fn checkpoint_written(&mut self, now: Instant) {
        self.next = now + self.every;
    }

    /// Returns true if the wall-time limit is reached.
    pub fn is_time_up(&self, now: Instant) -> bool {
        self.end.is_some_and(|end| now >= end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_time_is_served_once_by_the_first_step_at_or_past_it() {
        let mut interval = OutputInterval::every(0.05);
        // No multiple of this step is a multiple of 0.05, so rounding has no effect.
        let step = 0.0071;
        let served: Vec<u64> = (0..100).filter(|&k| interval.advance(k as f64 * step)).collect();
        let expected: Vec<u64> = (0..15).map(|n| (n as f64 * 0.05 / step).ceil() as u64).collect();
        assert_eq!(served, expected);
    }

    #[test]
    fn long_step_passes_several_times_with_one_output() {
        let mut interval = OutputInterval::every(0.1);
        assert!(interval.advance(0.0));
        assert!(interval.advance(0.35));
        assert!(!interval.advance(0.39));
        assert!(interval.advance(0.41));
    }

    #[test]
    fn new_interval_starts_after_the_time_reached() {
        let mut interval = OutputInterval::every(0.1);
        assert!(interval.advance(0.31));
        assert_eq!(interval.resumed(0.1, 0.35), interval);
        let mut longer = interval.resumed(0.25, 0.35);
        assert!(!longer.advance(0.49) && longer.advance(0.5) && !longer.advance(0.74));
    }

    #[test]
    fn multiple_of_the_interval_is_served_once() {
        let mut interval = OutputInterval::every(0.1);
        for n in 0..1000 {
            let time = n as f64 * 0.1;
            assert!(interval.advance(time), "multiple {n} missed");
            assert!(!interval.advance(time), "multiple {n} served twice");
        }
    }

    #[test]
    fn checkpoint_interval_starts_at_the_last_checkpoint() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let mut clock = WallClock::new(start, 60.0, Some(100.0));
        assert!(!clock.is_checkpoint_due(at(59.0)) && clock.is_checkpoint_due(at(60.0)));
        clock.checkpoint_written(at(70.0));
        assert!(!clock.is_checkpoint_due(at(120.0)) && clock.is_checkpoint_due(at(130.0)));
        assert!(!clock.is_time_up(at(99.0)) && clock.is_time_up(at(100.0)));
        let endless = WallClock::new(start, f64::MAX, None);
        assert!(!endless.is_checkpoint_due(at(1e6)) && !endless.is_time_up(at(1e6)));
    }
}
