//! Disk space of a run, estimated from its scene.

use super::model::{ProbeKind, Scene};
use super::summary::{estimated_volume, frame_bytes, steps_to};

/// Size of a number in a CSV file, including the comma, B.
const NUMBER_BYTES: f64 = 20.0;

/// Number of columns of a monitor row.
const MONITOR_COLUMNS: f64 = 30.0;

/// Number of columns of a probe point: velocity, pressure, density and names.
const PROBE_COLUMNS: f64 = 8.0;

/// Size of a particle in the checkpoints, B: two are kept while a third is written.
const CHECKPOINT_BYTES: f64 = 3.0 * 150.0;

/// Largest output of a run, before compression, which saves little: the last digits of positions
/// are noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskEstimate {
    /// Frames.
    pub frames: f64,
    /// Bytes of all frames.
    pub frame_bytes: f64,
    /// Bytes of monitor and probes.
    pub row_bytes: f64,
    /// Bytes of the checkpoints.
    pub checkpoint_bytes: f64,
}

impl DiskEstimate {
    /// Returns the estimate for a run up to a time (s) or for a number of steps.
    pub fn new(scene: &Scene, until: Option<f64>, most_steps: Option<u64>) -> Self {
        let until = until.unwrap_or(scene.time.end);
        let steps = steps_to(scene, until).min(most_steps.unwrap_or(u64::MAX) as f64);
        // Output is written at most once per step.
        let times_written = |every: f64| (until / every).min(steps) + 2.0;
        let particles =
            estimated_volume(&scene.container, 0.0, scene.dimensions) / scene.discretisation.cell_volume();
        let points: f64 = scene.output.probes.iter().map(|probe| points_of(&probe.kind)).sum();
        let row = NUMBER_BYTES * (MONITOR_COLUMNS + PROBE_COLUMNS * points);
        let frames = times_written(scene.output.every);
        Self {
            frames,
            frame_bytes: frames * particles * frame_bytes(scene.dimensions),
            row_bytes: times_written(scene.output.monitor_every) * row,
            checkpoint_bytes: CHECKPOINT_BYTES * particles,
        }
    }

    /// Returns the peak disk usage, B: frames and rows exist twice while they are packed.
    pub fn bytes(&self) -> f64 {
        2.0 * (self.frame_bytes + self.row_bytes) + self.checkpoint_bytes
    }

    /// Returns the interval of frames, s, with which a run fits into `space` bytes; None if the
    /// rows alone do not fit.
    pub fn fitting_interval(&self, every: f64, space: f64) -> Option<f64> {
        let left = space - 2.0 * self.row_bytes - self.checkpoint_bytes;
        (left > 0.0).then(|| every * (2.0 * self.frame_bytes / left).max(1.0))
    }
}

fn points_of(kind: &ProbeKind) -> f64 {
    match kind {
        ProbeKind::Line { count, .. } => *count as f64,
        ProbeKind::Point(_) | ProbeKind::Section { .. } => 1.0,
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    fn quickstart(sets: &[(&str, &str)]) -> Scene {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/quickstart.ron");
        Scene::from_file(&path).sets(sets).load().expect("a scene")
    }

    #[test]
    fn frames_are_no_more_than_steps() {
        let scene = quickstart(&[("output.every", "1e-12")]);
        let estimate = DiskEstimate::new(&scene, None, Some(50));
        assert_eq!(estimate.frames, 52.0);
        let estimate = DiskEstimate::new(&scene, None, None);
        assert!(estimate.frames > 1000.0 && estimate.frames < 1e5, "{estimate:?}");
    }

    #[test]
    fn fitting_interval_fits_the_disk() {
        let rows = ("output.monitor_every", "0.01");
        let scene = quickstart(&[("output.every", "1e-3"), rows]);
        let estimate = DiskEstimate::new(&scene, None, None);
        let space = 0.3 * estimate.bytes();
        let every = estimate.fitting_interval(1e-3, space).expect("an interval");
        let scene = quickstart(&[("output.every", &format!("{every:e}")), rows]);
        let fitted = DiskEstimate::new(&scene, None, None);
        // There are two more frames than intervals: the first and the last.
        assert!((fitted.bytes() / space - 1.0).abs() < 0.02, "{fitted:?} for {space}");
        assert_eq!(estimate.fitting_interval(1e-3, 1.0), None);
    }
}
