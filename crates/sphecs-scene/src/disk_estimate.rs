//! Disk space of a run, estimated from its scene.

use super::memory_estimate::{means_of_fields, nodes_of_fields, values_of_fields};
use super::model::{Body, ForcesEvery, Probe, ProbeKind, Scene};
use super::summary::{estimated_volume, frame_bytes, steps_to};

/// Size of a number in a CSV file with its comma, and in the NetCDF file made from it, B.
const NUMBER_BYTES: f64 = 20.0 + 8.0;

/// Number of columns of a monitor row without those of inlets and outlets.
const MONITOR_COLUMNS: f64 = 25.0;

/// Size of the time and the point's number before the values of a probe in its CSV file, B.
const POINT_BYTES: f64 = 22.0;

/// Size of a value of a probe in its CSV file with its comma, and in `probes.nc`, B.
const VALUE_BYTES: f64 = 15.0 + 8.0;

/// Number of checkpoints that are kept.
const CHECKPOINTS: f64 = 2.0;

/// Size of the files of a run without particles, B: scene, summary, and one chunk a variable.
const EMPTY_BYTES: f64 = 3e5;

/// Largest output of a run. Frames count before compression, which takes about a third off.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DiskEstimate {
    /// Frames.
    pub frames: f64,
    /// Bytes of all frames.
    pub frame_bytes: f64,
    /// Bytes of the monitor.
    pub monitor_bytes: f64,
    /// Bytes of the probes.
    pub probe_bytes: f64,
    /// Part of them from probes at the interval of the frames.
    pub probe_bytes_with_frames: f64,
    /// Bytes of the gridded fields, means included.
    pub field_bytes: f64,
    /// Part of them from times at the interval of the frames.
    pub field_bytes_with_frames: f64,
    /// Bytes of the quantities at the walls, means included.
    pub wall_bytes: f64,
    /// Bytes of the forces on bodies.
    pub force_bytes: f64,
    /// Bytes of the checkpoints.
    pub checkpoint_bytes: f64,
}

impl DiskEstimate {
    /// Returns the estimate for a run up to a time (s) or for a number of steps, before the
    /// particles are placed.
    pub fn new(scene: &Scene, until: Option<f64>, most_steps: Option<u64>) -> Self {
        let particles =
            estimated_volume(&scene.container, 0.0, scene.dimensions) / scene.discretisation.cell_volume();
        // Walls are kept in the checkpoints, and are fewer than the fluid in most scenes.
        Self::of_particles(scene, particles, 2.0 * particles, until, most_steps)
    }

    /// Returns the estimate for a run with `moving` particles in its frames and `all` in its
    /// checkpoints.
    pub fn of_particles(
        scene: &Scene,
        moving: f64,
        all: f64,
        until: Option<f64>,
        most_steps: Option<u64>,
    ) -> Self {
        let until = until.unwrap_or(scene.time.end);
        let steps = steps_to(scene, until).min(most_steps.unwrap_or(u64::MAX) as f64);
        // Output is written at most once per step, at the start and at the end.
        let times_written = |every: f64| (until / every - 1e-9).ceil().min(steps) + 1.0;
        let rows = times_written(scene.output.monitor_every);
        let probe_bytes = |probe: &Probe| {
            times_written(probe.every) * points_of(&probe.kind) * point_bytes(&probe.kind, scene.dimensions)
        };
        let probes = scene.output.probes.iter();
        let with_frames = probes.filter(|probe| probe.every.to_bits() == scene.output.every.to_bits());
        let openings = (scene.inlets.len() + scene.outlets.len()) as f64;
        let force_columns: f64 = scene.bodies.iter().map(|body| force_columns(body, scene.dimensions)).sum();
        let force_rows = match scene.output.forces {
            ForcesEvery::Step => steps + 1.0,
            ForcesEvery::Row => rows,
        };
        let frames = times_written(scene.output.every);
        let fields = FieldBytes::of(scene);
        let field_times =
            scene.output.fields.as_ref().map(|fields| (fields.every, times_written(fields.every)));
        let (field_every, field_times) = field_times.unwrap_or((f64::INFINITY, 0.0));
        let walls = WallBytes::of(scene);
        let wall_times = scene.output.walls.as_ref().map_or(0.0, |walls| times_written(walls.every));
        let has_frame_times = field_every.to_bits() == scene.output.every.to_bits();
        Self {
            field_bytes: field_times * fields.time + fields.means,
            field_bytes_with_frames: if has_frame_times { field_times * fields.time } else { 0.0 },
            wall_bytes: wall_times * walls.time + walls.means,
            frames,
            frame_bytes: frames * moving * frame_bytes(scene.dimensions),
            monitor_bytes: rows * NUMBER_BYTES * (MONITOR_COLUMNS + openings),
            probe_bytes: scene.output.probes.iter().map(probe_bytes).sum(),
            probe_bytes_with_frames: with_frames.map(probe_bytes).sum(),
            // Time and step before the columns of the bodies.
            force_bytes: if force_columns > 0.0 {
                force_rows * NUMBER_BYTES * (2.0 + force_columns)
            } else {
                0.0
            },
            checkpoint_bytes: CHECKPOINTS
                * (all * checkpoint_bytes(scene.dimensions) + fields.sums + walls.sums),
        }
    }

    /// Returns the size of the folder after the run, B.
    pub fn total(&self) -> f64 {
        self.frame_bytes
            + self.field_bytes
            + self.wall_bytes
            + self.row_bytes()
            + self.checkpoint_bytes
            + EMPTY_BYTES
    }

    /// Returns the peak disk usage, B: frames and gridded fields exist twice while they are packed,
    /// and a third checkpoint is written before the first is deleted.
    pub fn bytes(&self) -> f64 {
        2.0 * self.frame_bytes + self.bytes_beside_frames()
    }

    /// Returns the interval of frames, s, with which a run fits into `space` bytes; None if the
    /// rows alone do not fit.
    pub fn fitting_interval(&self, every: f64, space: f64) -> Option<f64> {
        let others = self.probe_bytes_with_frames + 2.0 * self.field_bytes_with_frames;
        let left = space - (self.bytes_beside_frames() - others);
        let at_interval = 2.0 * self.frame_bytes + others;
        (left > 0.0).then(|| every * (at_interval / left).max(1.0))
    }

    fn row_bytes(&self) -> f64 {
        self.monitor_bytes + self.probe_bytes + self.force_bytes
    }

    fn bytes_beside_frames(&self) -> f64 {
        let checkpoints = self.checkpoint_bytes * (CHECKPOINTS + 1.0) / CHECKPOINTS;
        2.0 * (self.field_bytes + self.wall_bytes) + self.row_bytes() + checkpoints + EMPTY_BYTES
    }
}

/// Sizes of the gridded fields, B, before compression.
struct FieldBytes {
    /// One time.
    time: f64,
    /// Means.
    means: f64,
    /// Sums of the means in a checkpoint.
    sums: f64,
}

impl FieldBytes {
    fn of(scene: &Scene) -> Self {
        let nodes = nodes_of_fields(scene);
        let has_means = scene.output.fields.as_ref().is_some_and(|fields| fields.mean.is_some());
        let means = if has_means { nodes * means_of_fields(scene) } else { 0.0 };
        Self { time: nodes * (4.0 * values_of_fields(scene) + 1.0), means: 4.0 * means, sums: 8.0 * means }
    }
}

/// Sizes of the quantities at the walls, B, before compression.
#[derive(Default)]
struct WallBytes {
    /// One time.
    time: f64,
    /// Means.
    means: f64,
    /// Sums of the means in a checkpoint.
    sums: f64,
}

impl WallBytes {
    fn of(scene: &Scene) -> Self {
        let Some(output) = &scene.output.walls else { return Self::default() };
        let points = scene.wall_points().len() as f64;
        let axes = scene.dimensions as f64;
        // Pressure, y⁺ and shear stress, with place and normal if the walls move.
        let moving = if scene.has_moving_wall_points() { 2.0 * axes } else { 0.0 };
        let time = 4.0 * points * (2.0 + axes + moving);
        // Pressure and its variance, mean stress and its mean magnitude, shear index, y⁺, weight.
        let means = if output.mean.is_some() { points * (6.0 + axes) } else { 0.0 };
        Self { time, means: 4.0 * means, sums: 8.0 * means }
    }
}

/// Returns the size of a particle in a checkpoint, B: 112 to 133 were measured in 2D, 184 in 3D.
fn checkpoint_bytes(dimensions: usize) -> f64 {
    if dimensions == 2 { 135.0 } else { 190.0 }
}

/// Returns the number of columns of a body: force and torque, each in total and by pressure and
/// viscosity, and the coefficients.
fn force_columns(body: &Body, dimensions: usize) -> f64 {
    let components = if dimensions == 2 { 3.0 } else { 6.0 };
    3.0 * components + if body.reference.is_some() { 2.0 } else { 0.0 }
}

/// Returns the size of a probe's point at one time, B.
fn point_bytes(kind: &ProbeKind, dimensions: usize) -> f64 {
    let values = match kind {
        ProbeKind::Section { .. } => 2,
        // Velocity, pressure and density.
        ProbeKind::Line { .. } | ProbeKind::Point(_) => dimensions + 2,
    };
    POINT_BYTES + values as f64 * VALUE_BYTES
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
        assert_eq!(estimate.frames, 51.0);
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
        // There is one more frame than intervals, and a whole number of them.
        assert!((fitted.bytes() / space - 1.0).abs() < 0.02, "{fitted:?} for {space}");
        assert_eq!(estimate.fitting_interval(1e-3, 1.0), None);
    }
}
