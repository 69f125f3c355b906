//! Gridded fields of a run: their times, the samples of their means, and both in a checkpoint.

use super::run_state::RunState;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_engine::simulation::Simulation;
use sphecs_output::error::OutputError;
use sphecs_output::fields::FieldNodes;
use sphecs_output::fields::averages::FieldAverages;
use sphecs_output::folder::RunFolder;
use sphecs_scene::model::Scene;

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
        let is_due = schedule.is_due((clock.time, clock.step), is_last);
        if sample.is_some() || is_due {
            self.nodes.update(simulation.scene(), clock.time);
        }
        let tagged = self.nodes.tagged();
        if let Some(duration) = sample {
            self.averages.add(&self.nodes, duration, &mut |rows, sinks| {
                simulation.sample_rows(rows, sinks, tagged);
            });
            self.has_new_means = true;
        }
        if is_due {
            let snapshot = self.nodes.snapshot(clock.time, clock.step, &mut |rows, sinks| {
                simulation.sample_rows(rows, sinks, tagged);
            });
            folder.submit_fields(snapshot)?;
        }
        if let Some((from, _)) = self.mean.filter(|_| self.has_new_means && (is_due || is_last)) {
            folder.submit_field_means(self.averages.means((from, schedule.sampled())))?;
            self.has_new_means = false;
        }
        Ok(())
    }
}
