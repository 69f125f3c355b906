//! Disk space that a run will need, from its scene alone.

use super::model::{ProbeKind, Scene};
use super::summary::{estimated_volume, frame_bytes, steps_to};

/// Bytes of a number in a CSV file, comma included.
const NUMBER: f64 = 20.0;

/// Columns of a row of the monitor.
const MONITOR_COLUMNS: f64 = 30.0;

/// Columns of a point of a probe: velocity, pressure, density and where it belongs.
const PROBE_COLUMNS: f64 = 8.0;

/// Bytes of a particle in a checkpoint, of which two are kept and a third is written.
const CHECKPOINT: f64 = 3.0 * 150.0;

/// Largest output of a run, before compression, which saves little: the last digits of positions
/// are noise.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Demand {
    /// Frames.
    pub frames: f64,
    /// Bytes of all frames.
    pub frame_bytes: f64,
    /// Bytes of monitor and probes.
    pub row_bytes: f64,
    /// Bytes of the checkpoints.
    pub checkpoint_bytes: f64,
}

impl Demand {
    /// Returns the demand of a scene up to a time (s), or the end of a number of steps.
    pub fn of(scene: &Scene, until: Option<f64>, most_steps: Option<u64>) -> Self {
        let until = until.unwrap_or(scene.time.end);
        let steps = steps_to(scene, until).min(most_steps.unwrap_or(u64::MAX) as f64);
        // None is written between two steps.
        let occasions = |every: f64| (until / every).min(steps) + 2.0;
        let particles =
            estimated_volume(&scene.container, 0.0, scene.dimensions) / scene.discretisation.cell_volume();
        let points: f64 = scene.output.probes.iter().map(|probe| points_of(&probe.kind)).sum();
        let row = NUMBER * (MONITOR_COLUMNS + PROBE_COLUMNS * points);
        let frames = occasions(scene.output.every);
        Self {
            frames,
            frame_bytes: frames * particles * frame_bytes(scene.dimensions),
            row_bytes: occasions(scene.output.monitor_every) * row,
            checkpoint_bytes: CHECKPOINT * particles,
        }
    }

    /// Most bytes on the disk at a time: while they are packed, frames and rows are there twice.
    pub fn bytes(&self) -> f64 {
        2.0 * (self.frame_bytes + self.row_bytes) + self.checkpoint_bytes
    }

    /// The interval of the frames with which a run would fit into so many bytes, s; None where the
    /// rows alone are too much.
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
        let demand = Demand::of(&scene, None, Some(50));
        assert_eq!(demand.frames, 52.0);
        let demand = Demand::of(&scene, None, None);
        assert!(demand.frames > 1000.0 && demand.frames < 1e5, "{demand:?}");
    }

    #[test]
    fn the_interval_that_fits_fits() {
        let rows = ("output.monitor_every", "0.01");
        let scene = quickstart(&[("output.every", "1e-3"), rows]);
        let demand = Demand::of(&scene, None, None);
        let space = 0.3 * demand.bytes();
        let every = demand.fitting_interval(1e-3, space).expect("an interval");
        let scene = quickstart(&[("output.every", &format!("{every:e}")), rows]);
        let fitted = Demand::of(&scene, None, None);
        // Two frames more than intervals: the first and the last.
        assert!((fitted.bytes() / space - 1.0).abs() < 0.02, "{fitted:?} for {space}");
        assert_eq!(demand.fitting_interval(1e-3, 1.0), None);
    }
}
