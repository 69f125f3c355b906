//! Times of gridded fields and quantities at the walls, and of the samples of their means.

use serde::{Deserialize, Serialize};

use super::output_schedule::OutputInterval;

/// Times of an output and of the samples of its means.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SampleSchedule {
    /// Times that are written.
    times: OutputInterval,
    /// Step of the last time written; None before the first.
    last: Option<u64>,
    /// Samples of the means.
    samples: OutputInterval,
    /// Time up to which samples stand for the flow, s; from the beginning of the means on.
    sampled: f64,
}

impl SampleSchedule {
    /// Returns the schedule before the first output: its interval, s, the interval of the means, s,
    /// and that between their samples, s.
    pub fn new(every: f64, mean: Option<(f64, f64)>, mean_every: f64) -> Self {
        Self {
            times: OutputInterval::every(every),
            last: None,
            samples: OutputInterval::every(mean_every),
            sampled: mean.map_or(0.0, |(from, _)| from),
        }
    }

    /// Returns the schedule of a run resumed at `time`, s, with an interval, s, that may be new.
    #[must_use]
    pub fn resumed(self, every: f64, time: f64) -> Self {
        Self { times: self.times.resumed(every, time), ..self }
    }

    /// Returns true if the output is due at a time, s, and a step, and records it; at the end of a
    /// run it `is_last`.
    pub fn is_due(&mut self, (time, step): (f64, u64), is_last: bool) -> bool {
        let is_due = self.times.advance(time) || (is_last && self.last != Some(step));
        if is_due {
            self.last = Some(step);
        }
        is_due
    }

    /// Returns the time up to which samples stand for the flow, s.
    pub fn sampled(&self) -> f64 {
        self.sampled
    }

    /// Returns the duration, s, for which a sample of the means at `time`, s, stands; None if none
    /// is due. The last one of the interval is due at its end, and one is `wanted` at the end of
    /// the run.
    pub fn sample(&mut self, mean: (f64, f64), time: f64, wanted: bool) -> Option<f64> {
        let until = time.min(mean.1);
        if until <= self.sampled || !(self.samples.advance(time) || time >= mean.1 || wanted) {
            return None;
        }
        let duration = until - self.sampled;
        self.sampled = until;
        Some(duration)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(every: f64, from: f64) -> SampleSchedule {
        SampleSchedule {
            times: OutputInterval::every(1.0),
            last: None,
            samples: OutputInterval::every(every),
            sampled: from,
        }
    }

    #[test]
    fn samples_stand_for_the_whole_interval_of_the_mean() {
        let mean = (1.0, 2.0);
        let mut schedule = schedule(0.25, mean.0);
        let mut samples = Vec::new();
        for step in 0..30 {
            let time = 0.11 * f64::from(step);
            samples.extend(schedule.sample(mean, time, false).map(|duration| (time, duration)));
        }
        let total: f64 = samples.iter().map(|(_, duration)| duration).sum();
        assert!((total - 1.0).abs() < 1e-12, "{samples:?}");
        assert_eq!(samples.len(), 5, "{samples:?}");
        assert!((samples[0].1 - 0.1).abs() < 1e-12 && samples[4].0 > 2.0, "{samples:?}");
    }

    #[test]
    fn the_end_of_a_run_is_sampled() {
        let mut schedule = schedule(10.0, 1.0);
        assert_eq!(schedule.sample((1.0, 9.0), 1.5, false), Some(0.5));
        assert_eq!(schedule.sample((1.0, 9.0), 3.0, false), None);
        assert_eq!(schedule.sample((1.0, 9.0), 3.0, true), Some(1.5));
        assert_eq!(schedule.sample((1.0, 9.0), 3.0, true), None);
    }
}
