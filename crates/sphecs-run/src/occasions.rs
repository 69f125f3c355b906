//! When a checkpoint is due, and when the wall time is up.

use std::time::{Duration, Instant};

/// Wall time that a run keeps to.
#[derive(Clone, Copy, Debug)]
pub struct Occasions {
    every: Duration,
    next: Instant,
    end: Option<Instant>,
}

/// A wall time in s; what no clock can hold is for ever.
fn duration(seconds: f64) -> Duration {
    Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX)
}

/// Far enough away never to come: a century.
const NEVER: Duration = Duration::from_secs(100 * 365 * 86_400);

impl Occasions {
    /// A checkpoint every so many seconds of wall time from `now` on, > 0, and the end after `most`, s.
    pub fn new(now: Instant, every: f64, most: Option<f64>) -> Self {
        let every = duration(every).min(NEVER);
        Self { every, next: now + every, end: most.map(|most| now + duration(most).min(NEVER)) }
    }

    /// Whether a checkpoint is due by the clock.
    pub fn is_checkpoint_due(&self, now: Instant) -> bool {
        now >= self.next
    }

    /// Takes note that a checkpoint has been handed over.
    pub fn checkpoint_taken(&mut self, now: Instant) {
        self.next = now + self.every;
    }

    /// Whether the wall time is up.
    pub fn is_time_up(&self, now: Instant) -> bool {
        self.end.is_some_and(|end| now >= end)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn intervals_begin_with_the_last_checkpoint() {
        let start = Instant::now();
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        let mut occasions = Occasions::new(start, 60.0, Some(100.0));
        assert!(!occasions.is_checkpoint_due(at(59.0)) && occasions.is_checkpoint_due(at(60.0)));
        occasions.checkpoint_taken(at(70.0));
        assert!(!occasions.is_checkpoint_due(at(120.0)) && occasions.is_checkpoint_due(at(130.0)));
        assert!(!occasions.is_time_up(at(99.0)) && occasions.is_time_up(at(100.0)));
        let endless = Occasions::new(start, f64::MAX, None);
        assert!(!endless.is_checkpoint_due(at(1e6)) && !endless.is_time_up(at(1e6)));
    }
}
