//! When the next frame or row is due.

use serde::{Deserialize, Serialize};

/// Times 0, `every`, 2 `every`, … of which each is met at the first step at or past it.
///
/// The steps are never cut to meet a due time, so that what is written does not change the flow. Where
/// a step passes several due times at once, one frame stands for all of them.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Due {
    every: f64,
    next: u64,
}

impl Due {
    /// Due from t = 0 on, every so many seconds, > 0.
    pub fn every(every: f64) -> Self {
        Self { every, next: 0 }
    }

    /// The same from `time` (s) on with an interval that may be another: of a new one, the first multiple past `time` is due next.
    #[must_use]
    pub fn going_on(self, every: f64, time: f64) -> Self {
        if every.to_bits() == self.every.to_bits() {
            return self;
        }
        let mut due = Self::every(every);
        due.take(time);
        due
    }

    /// Whether something is due at `time`, s; if so, the next due time lies past `time`.
    pub fn take(&mut self, time: f64) -> bool {
        if time < self.time() {
            return false;
        }
        // Multiples, not a running sum: after a million rows the sum would be off by many roundings.
        self.next = (time / self.every).floor() as u64 + 1;
        if self.time() <= time {
            self.next += 1;
        }
        true
    }

    /// The next due time, s.
    pub fn time(&self) -> f64 {
        self.next as f64 * self.every
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn first_step_at_or_past_each_time_is_taken_once() {
        let mut due = Due::every(0.05);
        // No multiple of this step is a multiple of 0.05, so that rounding decides nothing.
        let step = 0.0071;
        let taken: Vec<u64> = (0..100).filter(|&k| due.take(k as f64 * step)).collect();
        let expected: Vec<u64> = (0..15).map(|n| (n as f64 * 0.05 / step).ceil() as u64).collect();
        assert_eq!(taken, expected);
    }

    #[test]
    fn long_step_passes_several_times_with_one_frame() {
        let mut due = Due::every(0.1);
        assert!(due.take(0.0));
        assert!(due.take(0.35));
        assert!(!due.take(0.39));
        assert!(due.take(0.41));
    }

    #[test]
    fn a_new_interval_begins_behind_the_time_reached() {
        let mut due = Due::every(0.1);
        assert!(due.take(0.31));
        assert_eq!(due.going_on(0.1, 0.35), due);
        let mut rare = due.going_on(0.25, 0.35);
        assert!(!rare.take(0.49) && rare.take(0.5) && !rare.take(0.74));
    }

    #[test]
    fn a_time_on_the_mark_is_not_taken_twice() {
        let mut due = Due::every(0.1);
        for n in 0..1000 {
            let time = n as f64 * 0.1;
            assert!(due.take(time), "mark {n} missed");
            assert!(!due.take(time), "mark {n} taken twice");
        }
    }
}
