//! Speed of a run, the wall time left, and their display.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::console::Console;
use super::progress_bar::Bar;
use sphecs_engine::resources::clock::Clock;

/// Wall time over which the speed is averaged, s: long enough to smooth the frames, short enough to
/// follow a time step that shrinks as the flow starts.
const WINDOW: f64 = 60.0;

/// Shortest wall time between two samples, s. With steps of microseconds the window would otherwise
/// hold millions.
const SAMPLING: f64 = 0.25;

/// Wall time between two lines of a log, rare enough for a run of days and frequent enough to show
/// progress.
const LINE_INTERVAL: Duration = Duration::from_secs(30);

/// Wall time between two drawings of the bar.
const BAR_INTERVAL: Duration = Duration::from_millis(100);

/// Progress of a run at one moment.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Progress {
    /// Wall time since the first step of this process, s.
    pub elapsed: f64,
    /// Part of the run that is done, 0 to 1.
    pub fraction: f64,
    /// Steps × particles so far, reservoir not counted.
    pub particle_steps: f64,
}

/// Returns the part of a run that is done, 0 to 1.
pub fn fraction(clock: &Clock, until: f64, max_steps: u64) -> f64 {
    (clock.time / until).max(clock.step as f64 / max_steps as f64).min(1.0)
}

/// Speed over the last minute.
#[derive(Clone, Debug)]
pub struct SpeedEstimate {
    samples: VecDeque<Progress>,
    last: Progress,
}

impl Default for SpeedEstimate {
    fn default() -> Self {
        Self::from(Progress::default())
    }
}

impl From<Progress> for SpeedEstimate {
    /// Returns the estimate at the start of a run, or of its part in this process.
    fn from(start: Progress) -> Self {
        Self { samples: VecDeque::from([start]), last: start }
    }
}

impl SpeedEstimate {
    /// Adds a sample.
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

    /// Returns the particle-steps per second of wall time, 1/s.
    pub fn particle_steps_per_second(&self) -> f64 {
        self.slope(|progress| progress.particle_steps)
    }

    /// Returns the wall time left, s; None before the first sample.
    pub fn seconds_left(&self) -> Option<f64> {
        let rate = self.slope(|progress| progress.fraction);
        (rate > 0.0).then(|| (1.0 - self.last.fraction).max(0.0) / rate)
    }

    fn slope(&self, quantity: impl Fn(&Progress) -> f64) -> f64 {
        let first = self.samples.front().copied().unwrap_or_default();
        let seconds = self.last.elapsed - first.elapsed;
        if seconds > 0.0 { (quantity(&self.last) - quantity(&first)) / seconds } else { 0.0 }
    }
}

/// Progress bar on a terminal, lines of text elsewhere.
#[derive(Debug)]
pub struct ProgressDisplay {
    console: Console,
    bar: Option<Bar>,
    last: Instant,
    /// True once lines were printed after the start summary.
    has_printed: bool,
}

impl ProgressDisplay {
    /// Returns a bar if standard error is a terminal, lines on standard output otherwise, and
    /// nothing when quiet.
    pub fn new(console: Console) -> Self {
        let bar = if console == Console::Quiet { None } else { Bar::on_terminal() };
        Self { console, bar, last: Instant::now(), has_printed: false }
    }

    /// Shows the part done, 0 to 1, and a text, if the last update is old enough; `text` is called
    /// only then.
    pub fn update(&mut self, fraction: f64, text: impl FnOnce() -> String) {
        let interval = if self.bar.is_some() { BAR_INTERVAL } else { LINE_INTERVAL };
        if self.console == Console::Quiet || self.last.elapsed() < interval {
            return;
        }
        self.last = Instant::now();
        match &self.bar {
            Some(bar) => bar.show(fraction, text()),
            None => self.print(&format!("{:5.1} %  {}", 100.0 * fraction, text())),
        }
    }

    /// Prints a line above the progress bar.
    pub fn print(&mut self, text: &str) {
        self.has_printed = true;
        match &self.bar {
            Some(bar) => bar.suspend(|| self.console.print(text)),
            None => self.console.print(text),
        }
    }

    /// Removes the bar and ends the printed lines with an empty one.
    pub fn clear(&mut self) {
        if let Some(bar) = self.bar.take() {
            bar.clear();
        }
        if self.has_printed {
            self.console.print("");
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steady_speed_is_returned() {
        let mut speed = SpeedEstimate::default();
        for tenth in 1..=3000 {
            let elapsed = f64::from(tenth) * 0.1;
            speed.record(Progress { elapsed, fraction: elapsed / 600.0, particle_steps: 2e6 * elapsed });
        }
        assert!((speed.particle_steps_per_second() - 2e6).abs() < 1.0);
        assert!((speed.seconds_left().expect("measured") - 300.0).abs() < 1e-6);
        assert!(speed.samples.len() < 250, "{} samples stored", speed.samples.len());
    }

    #[test]
    fn slower_speed_is_followed_within_the_window() {
        let mut speed = SpeedEstimate::default();
        for second in 1..=200 {
            let elapsed = f64::from(second);
            let fraction = if second < 100 { elapsed * 1e-3 } else { 0.1 + (elapsed - 100.0) * 1e-4 };
            speed.record(Progress { elapsed, fraction, particle_steps: 0.0 });
        }
        let left = speed.seconds_left().expect("measured");
        assert!((left - 0.89 / 1e-4).abs() < 1.0, "{left} s left");
    }

    #[test]
    fn progress_before_a_restart_does_not_count() {
        let mut speed = SpeedEstimate::from(Progress { elapsed: 0.0, fraction: 0.5, particle_steps: 1e9 });
        speed.record(Progress { elapsed: 10.0, fraction: 0.6, particle_steps: 1e9 + 50.0 });
        assert!((speed.particle_steps_per_second() - 5.0).abs() < 1e-6);
        assert!((speed.seconds_left().expect("measured") - 40.0).abs() < 1e-6);
    }

    #[test]
    fn time_left_is_unknown_before_the_first_sample() {
        assert_eq!(SpeedEstimate::default().seconds_left(), None);
    }
}
