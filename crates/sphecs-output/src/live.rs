//! State of a run from its files while it is under way, for those who watch it.
//!
//! Only `summary.json`, `monitor.csv` and the names in the journal are read; nothing is locked or
//! written, so that the run does not notice.

use std::fs;
use std::path::Path;

use serde::Serialize;

use super::error::OutputError;
use super::journal::frame_paths;
use super::monitor::read_rows;
use super::paths::{JOURNAL, MONITOR_CSV};
use super::summary::{Status, Summary};

/// Largest number of rows that are kept for curves.
const MOST_POINTS: usize = 400;

/// Part of the time so far over which the steadiness is evaluated.
const LATE: f64 = 0.1;

/// A quantity over time.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LiveSeries {
    /// Name.
    pub name: String,
    /// Unit in UDUNITS notation.
    pub unit: String,
    /// Values at [`LiveState::times`].
    pub values: Vec<f64>,
}

/// State of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct LiveState {
    /// Title of the scene.
    pub title: String,
    /// State or end of the run in words; a run that was killed is `running`, too.
    pub status: String,
    /// True if the run has ended.
    pub has_ended: bool,
    /// Time of the last row, s.
    pub time: f64,
    /// Time at which the run ends, s.
    pub end: f64,
    /// Steps done at the last row.
    pub step: u64,
    /// Number of steps after which the run ends.
    pub max_steps: Option<u64>,
    /// Size of the last step, s.
    pub time_step: f64,
    /// Number of frames written.
    pub frames: u64,
    /// Number of particles that are no reservoir.
    pub particles: u64,
    /// Seconds since the last row was written; None after the end.
    pub row_age: Option<f64>,
    /// Times of the curves, s.
    pub times: Vec<f64>,
    /// Curves: mass flows in and out, mean pressure, kinetic energy, largest speed, largest density
    /// deviation.
    pub series: Vec<LiveSeries>,
    /// Range of the kinetic energy over its mean in the last tenth of the time so far; None at the
    /// beginning.
    pub unsteadiness: Option<f64>,
    /// Notes of the run.
    pub notes: Vec<String>,
}

impl LiveState {
    /// Reads the state of the run in a folder.
    ///
    /// # Errors
    /// [`OutputError::NotARun`] when the folder has no run, or [`OutputError`] with path and cause.
    pub fn read(folder: &Path) -> Result<Self, OutputError> {
        let summary = Summary::read(folder)?;
        let journal = folder.join(JOURNAL);
        let frames = if journal.exists() { frame_paths(&journal)?.len() as u64 } else { summary.frames };
        let has_ended = summary.status != Status::Running;
        let rows = read_rows(folder)?;
        let age = |path: &Path| fs::metadata(path).ok()?.modified().ok()?.elapsed().ok();
        let mut state = Self {
            title: summary.run.title.clone(),
            status: summary.status.word().to_owned(),
            has_ended,
            end: summary.run.until.unwrap_or(summary.run.end),
            max_steps: summary.run.max_steps,
            frames,
            row_age: age(&folder.join(MONITOR_CSV)).filter(|_| !has_ended).map(|age| age.as_secs_f64()),
            notes: summary.notes,
            ..Self::default()
        };
        let last = |name: &str| rows.column(name).and_then(|column| column.last().copied()).unwrap_or(0.0);
        state.time = last("time");
        state.step = last("step") as u64;
        state.time_step = last("time_step");
        let zones = ["count_fluid", "count_wall", "count_inflow", "count_outflow"];
        state.particles = zones.iter().map(|zone| last(zone)).sum::<f64>() as u64;
        let (Some(times), Some(energy)) = (rows.column("time"), rows.column("kinetic_energy")) else {
            return Ok(state);
        };
        state.unsteadiness = unsteadiness(times, energy);
        let stride = times.len().div_ceil(MOST_POINTS).max(1);
        // The last row is always among them.
        let first = times.len().saturating_sub(1) % stride;
        let thinned = |column: &[f64]| column.iter().skip(first).step_by(stride).copied().collect::<Vec<_>>();
        state.times = thinned(times);
        for (name, columns) in [
            ("inflow", "inlet_mass_flow_"),
            ("outflow", "outlet_mass_flow_"),
            ("mean pressure", "mean_pressure"),
            ("kinetic energy", "kinetic_energy"),
            ("largest speed", "largest_speed"),
            ("largest density deviation", "largest_density_deviation"),
        ] {
            if let Some((unit, sum)) = rows.sum(columns) {
                state.series.push(LiveSeries { name: name.to_owned(), unit, values: thinned(&sum) });
            }
        }
        Ok(state)
    }

    /// Returns the part of the run that is done, 0 to 1.
    pub fn fraction(&self) -> f64 {
        let of_time = if self.end > 0.0 { self.time / self.end } else { 0.0 };
        let of_steps = self.max_steps.map_or(0.0, |steps| self.step as f64 / steps as f64);
        of_time.max(of_steps).clamp(0.0, 1.0)
    }

    /// Returns a curve.
    pub fn series(&self, name: &str) -> Option<&LiveSeries> {
        self.series.iter().find(|series| series.name == name)
    }
}

/// Returns the range of a quantity over its mean in the last part of the time.
fn unsteadiness(times: &[f64], values: &[f64]) -> Option<f64> {
    let from = times.last()? * (1.0 - LATE);
    let late: Vec<f64> =
        times.iter().zip(values).filter(|(time, _)| **time >= from).map(|(_, value)| *value).collect();
    if late.len() < 3 {
        return None;
    }
    let (low, high) = late
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), &value| (low.min(value), high.max(value)));
    let mean = late.iter().sum::<f64>() / late.len() as f64;
    (mean != 0.0).then(|| (high - low) / mean.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unsteadiness_is_that_of_the_last_tenth() {
        let times: Vec<f64> = (0..=100).map(|time| 0.1 * f64::from(time)).collect();
        let rising: Vec<f64> = times.iter().map(|time| time.min(9.0)).collect();
        assert_eq!(unsteadiness(&times, &rising), Some(0.0));
        let found = unsteadiness(&times, &times).expect("enough rows");
        assert!((found - 1.0 / 9.5).abs() < 1e-9, "{found}");
        assert_eq!(unsteadiness(&times[..2], &times[..2]), None);
        assert_eq!(unsteadiness(&[], &[]), None);
    }

    #[test]
    fn a_folder_without_a_run_is_named() {
        let folder = tempfile::tempdir().expect("a folder");
        assert!(matches!(LiveState::read(folder.path()), Err(OutputError::NotARun { .. })));
    }
}
