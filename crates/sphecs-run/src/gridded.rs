//! Gridded fields of a run: their times, the samples of their means, and both in a checkpoint.

use serde::{Deserialize, Serialize};

use super::output_schedule::OutputInterval;
use super::run_state::RunState;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_engine::simulation::Simulation;
use sphecs_output::error::OutputError;
use sphecs_output::fields::FieldNodes;
use sphecs_output::fields::averages::FieldAverages;
use sphecs_output::folder::RunFolder;
use sphecs_scene::model::Scene;

/// Times of the gridded fields and of the samples of their means.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FieldSchedule {
    /// Times that are written.
    times: OutputInterval,
    /// Step of the last time written; None before the first.
    last: Option<u64>,
    /// Samples of the means.
    samples: OutputInterval,
    /// Time up to which samples stand for the flow, s; from the beginning of the means on.
    sampled: f64,
}

impl FieldSchedule {
    /// Returns the schedule before the first output; None without gridded fields.
    pub fn new(scene: &Scene) -> Option<Self> {
        let output = scene.output.fields.as_ref()?;
        Some(Self {
            times: OutputInterval::every(output.every),
            last: None,
            samples: OutputInterval::every(scene.mean_interval()),
            sampled: output.mean.map_or(0.0, |(from, _)| from),
        })
    }

    /// Returns the schedule of a run resumed at `time`, s, with an interval that may be new.
    #[must_use]
    pub fn resumed(self, scene: &Scene, time: f64) -> Self {
        match &scene.output.fields {
            Some(output) => Self { times: self.times.resumed(output.every, time), ..self },
            None => self,
        }
    }

    /// Returns the duration, s, for which a sample of the means at `time`, s, stands; None if none
    /// is due. The last one of the interval is due at its end, and one is `wanted` at the end of
    /// the run.
    fn sample(&mut self, mean: (f64, f64), time: f64, wanted: bool) -> Option<f64> {
        let until = time.min(mean.1);
        if until <= self.sampled || !(self.samples.advance(time) || time >= mean.1 || wanted) {
            return None;
        }
        let duration = until - self.sampled;
        self.sampled = until;
        Some(duration)
    }
}

/// Nodes of the grids and sums of the means; empty without gridded fields.
#[derive(Debug, Default)]
pub struct GriddedFields {
    nodes: FieldNodes,
    mean: Option<(f64, f64)>,
    averages: FieldAverages,
    /// True if the means have changed since they were written.
    has_new_means: bool,
}

impl GriddedFields {
    /// Returns the grids of a scene, without samples.
    pub fn new(scene: &Scene) -> Self {
        let mean = scene.output.fields.as_ref().and_then(|fields| fields.mean);
        let nodes = FieldNodes::new(scene);
        let averages = mean.map_or_else(FieldAverages::default, |_| FieldAverages::new(&nodes));
        Self { nodes, mean, averages, has_new_means: false }
    }

    /// Returns the grids of a scene with the sums of a checkpoint.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when the sums are not those of the scene.
    pub fn restore(scene: &Scene, from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let mut fields = Self::new(scene);
        if fields.mean.is_some() {
            fields.averages = FieldAverages::restore(&fields.nodes, from)?;
            fields.has_new_means = fields.averages.duration() > 0.0;
        }
        Ok(fields)
    }

    /// Saves the sums as columns of a checkpoint.
    pub fn save(&self, to: &mut Columns) {
        if self.mean.is_some() {
            self.averages.save(to);
        }
    }

    /// Samples and submits what is due at the present time; at the end of a run, `is_last`, all
    /// that is missing.
    ///
    /// # Errors
    /// The error that stopped the writer thread.
    pub fn write(
        &mut self,
        simulation: &mut Simulation,
        (folder, state): (&mut RunFolder, &mut RunState),
        is_last: bool,
    ) -> Result<(), OutputError> {
        let Some(schedule) = &mut state.fields else { return Ok(()) };
        let clock = simulation.clock();
        let sample = self.mean.and_then(|mean| schedule.sample(mean, clock.time, is_last));
        let is_due = schedule.times.advance(clock.time) || (is_last && schedule.last != Some(clock.step));
        if sample.is_some() || is_due {
            self.nodes.update(simulation.scene(), clock.time);
        }
        if let Some(duration) = sample {
            self.averages.add(&self.nodes, duration, &mut |rows, sinks| {
                simulation.sample_rows(rows, sinks, false);
            });
            self.has_new_means = true;
        }
        if is_due {
            schedule.last = Some(clock.step);
            let tagged = self.nodes.tagged();
            let snapshot = self.nodes.snapshot(clock.time, clock.step, &mut |rows, sinks| {
                simulation.sample_rows(rows, sinks, tagged);
            });
            folder.submit_fields(snapshot)?;
        }
        if let Some((from, _)) = self.mean.filter(|_| self.has_new_means && (is_due || is_last)) {
            folder.submit_field_means(self.averages.means((from, schedule.sampled)))?;
            self.has_new_means = false;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn schedule(every: f64, from: f64) -> FieldSchedule {
        FieldSchedule {
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
