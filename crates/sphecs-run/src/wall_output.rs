//! Quantities at the walls of a run: their times, the samples of their means, and both in a
//! checkpoint.

use super::run_state::RunState;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::pass::surface_flow::SurfacePoint;
use sphecs_engine::simulation::Simulation;
use sphecs_output::error::OutputError;
use sphecs_output::folder::RunFolder;
use sphecs_output::walls::WallSites;
use sphecs_output::walls::over_time::WallSums;
use sphecs_scene::model::Scene;

/// Points of the walls and sums of the means; empty without quantities at the walls.
#[derive(Debug, Default)]
pub struct WallQuantities {
    sites: WallSites,
    mean: Option<(f64, f64)>,
    sums: WallSums,
    /// True if the means have changed since they were written.
    has_new_means: bool,
}

impl WallQuantities {
    /// Returns the points of a scene, without samples.
    pub fn new(scene: &Scene) -> Self {
        let mean = scene.output.walls.as_ref().and_then(|walls| walls.mean);
        let sites = WallSites::new(scene);
        let sums = WallSums::new(&sites);
        Self { sites, mean, sums, has_new_means: false }
    }

    /// Returns the points of a scene with the sums of a checkpoint.
    ///
    /// # Errors
    /// [`ColumnMismatch`] when the sums are not those of the scene.
    pub fn restore(scene: &Scene, from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let mut walls = Self::new(scene);
        if walls.mean.is_some() {
            walls.sums = WallSums::restore(&walls.sites, from)?;
            walls.has_new_means = walls.sums.duration() > 0.0;
        }
        Ok(walls)
    }

    /// Saves the sums as columns of a checkpoint.
    pub fn save(&self, to: &mut Columns) {
        if self.mean.is_some() {
            self.sums.save(to);
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
        let Some(schedule) = &mut state.walls else { return Ok(()) };
        let clock = simulation.clock();
        let duration = self.mean.and_then(|mean| schedule.sample(mean, clock.time, is_last));
        let is_due = schedule.is_due((clock.time, clock.step), is_last);
        let scene = simulation.shared_scene();
        let mut sample = |points: &[SurfacePoint]| simulation.sample_surface(points);
        if let Some(duration) = duration {
            self.sums.add(&self.sites, &scene, (clock.time, duration), &mut sample);
            self.has_new_means = true;
        }
        if is_due {
            folder.submit_walls(self.sites.snapshot(&scene, (clock.time, clock.step), &mut sample))?;
        }
        if let Some((from, _)) = self.mean.filter(|_| self.has_new_means && (is_due || is_last)) {
            folder.submit_wall_means(self.sums.means(&self.sites, (from, schedule.sampled())))?;
            self.has_new_means = false;
        }
        Ok(())
    }
}
