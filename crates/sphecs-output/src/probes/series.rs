//! Samples of the probes read from their CSV files, and time means.

use std::path::Path;

use super::writer::{Quantity, quantities};
use crate::error::OutputError;
use crate::header::{Header, ProbeHeader, ProbeShape};
use crate::paths::{self, PROBES_POINTS_CSV};
use crate::table::{for_each_row, parsed};
use sphecs_scene::result_name::result_name;

/// Samples of one probe.
pub(super) struct Series<'a> {
    /// Header of the probe.
    pub(super) probe: &'a ProbeHeader,
    /// Name of the probe in files and groups.
    pub(super) name: String,
    /// Points, m.
    pub(super) places: Vec<[f64; 3]>,
    /// Times, s.
    pub(super) times: Vec<f64>,
    /// Quantities with their values, `values[time · points + point]`.
    pub(super) columns: Vec<(Quantity, Vec<f64>)>,
}

impl Series<'_> {
    /// Returns the number of points.
    pub(super) fn points(&self) -> usize {
        self.places.len()
    }
}

/// Reads the points of all probes, m.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(super) fn read_places(folder: &Path, header: &Header) -> Result<Vec<Vec<[f64; 3]>>, OutputError> {
    let mut all = vec![Vec::new(); header.probes.len()];
    for_each_row(&folder.join(PROBES_POINTS_CSV), |row| {
        let index = header.probes.iter().position(|probe| probe.name == row[0]);
        if let Some(places) = index.map(|index| &mut all[index]) {
            places.push(std::array::from_fn(|axis| row.get(2 + axis).map_or(0.0, parsed)));
        }
    })?;
    Ok(all)
}

/// Reads the samples of a probe; the last time is omitted if its rows are incomplete, as after a
/// kill.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(super) fn read<'a>(
    folder: &Path,
    header: &Header,
    probe: &'a ProbeHeader,
    places: Vec<[f64; 3]>,
) -> Result<Series<'a>, OutputError> {
    let first = if probe.kind == ProbeShape::Line { 2 } else { 1 };
    let quantities = quantities(probe.kind, header.dimensions).into_iter();
    let mut columns: Vec<(Quantity, Vec<f64>)> = quantities.map(|quantity| (quantity, Vec::new())).collect();
    let points = places.len().max(1);
    let (mut rows, mut times) = (0_usize, Vec::new());
    for_each_row(&paths::probe(folder, &probe.name), |row| {
        if rows.is_multiple_of(points) {
            times.push(parsed(&row[0]));
        }
        rows += 1;
        for ((_, values), cell) in columns.iter_mut().zip(first..) {
            values.push(parsed(&row[cell]));
        }
    })?;
    let complete = rows / points;
    times.truncate(complete);
    columns.iter_mut().for_each(|(_, values)| values.truncate(complete * points));
    Ok(Series { probe, name: result_name(&probe.name), places, times, columns })
}

/// Returns the mean from `begin` to `end`, s, of the linear interpolation between samples.
///
/// Intervals next to a missing sample are omitted; NaN without any other.
pub(super) fn time_mean(times: &[f64], values: &[f64], begin: f64, end: f64) -> f64 {
    let (mut sum, mut duration) = (0.0, 0.0);
    for (time, value) in times.windows(2).zip(values.windows(2)) {
        let (low, high) = (time[0].max(begin), time[1].min(end));
        let slope = (value[1] - value[0]) / (time[1] - time[0]);
        let middle = value[0] + slope * (0.5 * (low + high) - time[0]);
        if high > low && middle.is_finite() {
            sum += (high - low) * middle;
            duration += high - low;
        }
    }
    sum / duration
}

#[cfg(test)]
mod tests {
    use super::super::writer::columns;
    use super::*;
    use crate::table::TableWriter;

    #[test]
    fn time_without_all_points_is_omitted() {
        let folder = tempfile::tempdir().expect("a folder");
        let probe = ProbeHeader { name: "wake, behind".to_owned(), kind: ProbeShape::Line, mean: None };
        let header = Header { dimensions: 2, probes: vec![probe.clone()], ..Header::default() };
        let path = paths::probe(folder.path(), &probe.name);
        std::fs::create_dir(path.parent().expect("a folder")).expect("made");
        let rows = [["0", "0"], ["0", "1"], ["1", "0"]];
        let rows = rows.map(|row| row.into_iter().chain(["1"; 4]).map(str::to_owned).collect());
        let mut writer = TableWriter::create(&path, &columns(probe.kind, 2)).expect("created");
        writer.append(rows).expect("written");
        let series = read(folder.path(), &header, &probe, vec![[0.0; 3]; 2]).expect("read");
        assert_eq!(series.times, [0.0]);
        assert!(series.columns.len() == 4 && series.columns.iter().all(|(_, values)| values.len() == 2));
    }

    #[test]
    fn mean_of_a_linear_function_is_its_midpoint() {
        let times = [0.0, 0.3, 1.0, 1.1, 2.0];
        let values = times.map(|t| 4.0 * t + 1.0);
        assert!((time_mean(&times, &values, 0.5, 1.5) - 5.0).abs() < 1e-12);
        assert!(time_mean(&times, &values, 3.0, 4.0).is_nan());
    }

    #[test]
    fn missing_samples_are_omitted() {
        let times = [0.0, 1.0, 2.0, 3.0];
        assert_eq!(time_mean(&times, &[2.0, 2.0, f64::NAN, 8.0], 0.0, 3.0), 2.0);
    }
}
