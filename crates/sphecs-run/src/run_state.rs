//! State of the run loop that a checkpoint saves in addition to the state of the flow.

use serde::{Deserialize, Serialize};

use super::close_pairs::CloseRows;
use super::closed_pressure::ClosedPressure;
use super::output_schedule::OutputInterval;
use super::sample_schedule::SampleSchedule;
use sphecs_core::format::significant;
use sphecs_engine::systems::monitor::MonitorRow;
use sphecs_scene::model::Scene;

/// Column of a checkpoint that holds this state.
pub const COLUMN: &str = "run.log";

/// Largest Mach number at which the density varies by about 1 %, as Monaghan (1994) recommends.
pub const LARGEST_MACH: f64 = 0.1;

/// Number of monitor rows that a speed must last: the first one after a sudden start may have a
/// higher one.
const FAST_ROWS: u32 = 3;

/// Counters and schedules of the run loop.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RunState {
    /// Schedule of the frames.
    pub frames: OutputInterval,
    /// Schedule of the monitor rows.
    pub rows: OutputInterval,
    /// Schedule of each probe, in the order of the scene.
    pub probes: Vec<OutputInterval>,
    /// Step of the last sample of each probe; None before the first.
    pub last_samples: Vec<Option<u64>>,
    /// Step of the last frame; None before the first.
    pub last_frame: Option<u64>,
    /// Schedule of the gridded fields; None without them.
    #[serde(default)]
    pub fields: Option<SampleSchedule>,
    /// Schedule of the quantities at the walls; None without them.
    #[serde(default)]
    pub walls: Option<SampleSchedule>,
    /// Number of frames submitted.
    pub frame_count: u64,
    /// Last monitor row.
    pub last_row: MonitorRow,
    /// Step of the last row; None before the first.
    pub last_row_step: Option<u64>,
    /// Steps × particles so far, reservoir not counted.
    pub particle_steps: f64,
    /// Wall time of the processes before this one, s.
    pub wall_time: f64,
    /// Wall time spent on submitting frames, rows and checkpoints, s.
    pub output_time: f64,
    /// Wall time by stage of the processes before this one, s.
    pub stages: Vec<f64>,
    /// Number of successive monitor rows with a speed above a tenth of the sound speed.
    pub fast_rows: u32,
    /// Successive monitor rows with particles nearer than half a spacing.
    pub close_rows: CloseRows,
    /// Mean pressure of a closed domain.
    #[serde(default)]
    pub closed_pressure: ClosedPressure,
    /// Notes of the run loop, those of the flow not included.
    pub notes: Vec<String>,
}

impl RunState {
    /// Returns the state before the first output.
    pub fn new(scene: &Scene) -> Self {
        let output = &scene.output;
        let fields = output.fields.as_ref().map(|fields| (fields.every, fields.mean, scene.mean_interval()));
        let walls = output.walls.as_ref().map(|walls| (walls.every, walls.mean, scene.wall_mean_interval()));
        let [fields, walls] = [fields, walls]
            .map(|times| times.map(|(every, mean, mean_every)| SampleSchedule::new(every, mean, mean_every)));
        Self {
            frames: OutputInterval::every(output.every),
            rows: OutputInterval::every(output.monitor_every),
            probes: output.probes.iter().map(|probe| OutputInterval::every(probe.every)).collect(),
            last_samples: vec![None; output.probes.len()],
            last_frame: None,
            fields,
            walls,
            frame_count: 0,
            last_row: MonitorRow::default(),
            last_row_step: None,
            particle_steps: 0.0,
            wall_time: 0.0,
            output_time: 0.0,
            stages: Vec::new(),
            fast_rows: 0,
            close_rows: CloseRows::default(),
            closed_pressure: ClosedPressure::default(),
            notes: Vec::new(),
        }
    }

    /// Returns the state of a run resumed at `time`, s, with intervals that may be new.
    #[must_use]
    pub fn resumed(self, scene: &Scene, time: f64) -> Self {
        let output = &scene.output;
        let probes = self.probes.into_iter().zip(&output.probes);
        let resumed = |schedule: Option<SampleSchedule>, every: Option<f64>| match (schedule, every) {
            (Some(schedule), Some(every)) => Some(schedule.resumed(every, time)),
            (schedule, _) => schedule,
        };
        Self {
            frames: self.frames.resumed(output.every, time),
            rows: self.rows.resumed(output.monitor_every, time),
            fields: resumed(self.fields, output.fields.as_ref().map(|fields| fields.every)),
            walls: resumed(self.walls, output.walls.as_ref().map(|walls| walls.every)),
            probes: probes.map(|(interval, probe)| interval.resumed(probe.every, time)).collect(),
            ..self
        }
    }

    /// Returns true for each probe without a sample at a step.
    pub fn probes_without(&self, step: u64) -> Vec<bool> {
        self.last_samples.iter().map(|last| *last != Some(step)).collect()
    }

    /// Records that the probes that are due were sampled at a step.
    pub fn record_samples(&mut self, due: &[bool], step: u64) {
        for (last, _) in self.last_samples.iter_mut().zip(due).filter(|(_, is_due)| **is_due) {
            *last = Some(step);
        }
    }

    /// Returns true for each probe that is due at `time`, s, and moves its next sample past it.
    pub fn probes_due(&mut self, time: f64) -> Vec<bool> {
        self.probes.iter_mut().map(|interval| interval.advance(time)).collect()
    }

    /// Records the last monitor row and returns the notes on it.
    pub fn record_row(&mut self, scene: &Scene) -> Vec<String> {
        let speed = self.record_speed(scene).map(str::to_owned);
        let close = self.close_rows.record(&self.last_row, scene);
        let pressure = self.closed_pressure.record(&self.last_row, scene);
        let others: Vec<String> = close.into_iter().chain(pressure).collect();
        self.notes.extend_from_slice(&others);
        speed.into_iter().chain(others).collect()
    }

    /// Records the largest speed of the last monitor row and returns a note, once in a run, when it
    /// has stayed above a tenth of the sound speed for three rows.
    ///
    /// From there on the density varies by more than 1 % (Monaghan 1994). A scene whose reference
    /// velocity is above that has a note of its own.
    fn record_speed(&mut self, scene: &Scene) -> Option<&str> {
        let largest = LARGEST_MACH * scene.fluid.sound_speed;
        if scene.reference_velocity > largest || self.fast_rows >= FAST_ROWS {
            return None;
        }
        let MonitorRow { time, largest_speed: speed, .. } = self.last_row;
        self.fast_rows = if speed > largest { self.fast_rows + 1 } else { 0 };
        if self.fast_rows < FAST_ROWS {
            return None;
        }
        self.notes.push(format!(
            "speed, at t = {} s: the fastest particle has {} m/s, Mach {}, {LARGEST_MACH} or less is wanted: \
             `fluid.sound_speed` of at least {} m/s",
            significant(time),
            significant(speed),
            significant(speed / scene.fluid.sound_speed),
            significant(speed / LARGEST_MACH)
        ));
        self.notes.last().map(String::as_str)
    }

    /// Returns the wall time of a stage in all processes, s, with `seconds` spent in this one.
    pub fn stage(&self, index: usize, seconds: f64) -> f64 {
        self.stages.get(index).copied().unwrap_or(0.0) + seconds
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn lasting_speed_is_noted_once() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/quickstart.ron");
        let scene = Scene::from_file(&path).set("fluid.sound_speed", "10").load().expect("a scene");
        let mut state = RunState::new(&scene);
        let mut notes = 0;
        for (row, speed) in [1.2, 0.9, 1.2, 1.2, 1.3, 1.4, 0.5, 1.2, 1.2, 1.2].into_iter().enumerate() {
            (state.last_row.time, state.last_row.largest_speed) = (row as f64, speed);
            if let Some(note) = state.record_speed(&scene) {
                assert_eq!(row, 4);
                assert!(note.contains("1.3 m/s") && note.contains("at least 13 m/s"), "{note}");
                notes += 1;
            }
        }
        assert_eq!((notes, state.notes.len()), (1, 1));
    }
}
