//! Rows of `probes.csv` sorted by probe, and time means.

use std::path::Path;

use super::writer::PLACE;
use crate::error::OutputError;
use crate::header::{Header, ProbeHeader, ProbeShape};
use crate::table::{for_each_row, safe_names};

/// Rows of one probe.
pub(super) struct Series<'a> {
    /// Header of the probe.
    pub(super) probe: &'a ProbeHeader,
    /// Name of the probe in variables.
    pub(super) name: String,
    /// Points, m.
    pub(super) places: Vec<[f64; 3]>,
    /// `values[quantity][time · points + point]`; empty for quantities that the probe does not
    /// measure.
    pub(super) values: [Vec<f64>; 7],
}

impl Series<'_> {
    /// Returns the number of points.
    pub(super) fn points(&self) -> usize {
        self.places.len()
    }

    /// Returns the range of the quantities that the probe measures.
    pub(super) fn measured(&self) -> std::ops::Range<usize> {
        match self.probe.kind {
            ProbeShape::Section => 5..7,
            ProbeShape::Point | ProbeShape::Line => 0..5,
        }
    }
}

/// Reads times and rows of `probes.csv` by probe; times without rows of all probes, as after a
/// kill, are omitted.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(super) fn read<'a>(path: &Path, header: &'a Header) -> Result<(Vec<f64>, Vec<Series<'a>>), OutputError> {
    let names = safe_names(header.probes.iter().map(|probe| probe.name.as_str()));
    let mut all: Vec<Series> = header
        .probes
        .iter()
        .zip(names)
        .map(|(probe, name)| Series { probe, name, places: Vec::new(), values: Default::default() })
        .collect();
    // Times of the rows of each probe, as written.
    let mut times: Vec<Vec<String>> = vec![Vec::new(); all.len()];
    for_each_row(path, |row| {
        let Some(index) = all.iter().position(|series| series.probe.name == row[1]) else {
            return;
        };
        let (series, times) = (&mut all[index], &mut times[index]);
        let cell = |column: usize| row[column].parse().unwrap_or(f64::NAN);
        if times.last().is_none_or(|last| *last != row[0]) {
            times.push(row[0].to_owned());
        }
        if times.len() == 1 {
            series.places.push([3, 4, 5].map(cell));
        }
        for quantity in series.measured() {
            series.values[quantity].push(cell(PLACE + quantity));
        }
    })?;
    let complete = |series: &Series| {
        let rows = series.values[series.measured().start].len();
        rows.checked_div(series.points())
    };
    let length = all.iter().filter_map(complete).min().unwrap_or(0);
    for series in &mut all {
        let rows = length * series.points();
        series.values.iter_mut().for_each(|values| values.truncate(rows));
    }
    let longest = times.into_iter().max_by_key(Vec::len).unwrap_or_default();
    let times = longest.iter().take(length).map(|time| time.parse().unwrap_or(f64::NAN)).collect();
    Ok((times, all))
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
    fn time_without_all_probes_is_omitted() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("probes.csv");
        let probes = ["wake, behind", "throat", "tip"].map(|name| ProbeHeader {
            name: name.to_owned(),
            kind: ProbeShape::Point,
            mean: None,
        });
        let header = Header { dimensions: 2, probes: probes.to_vec(), ..Header::default() };
        let mut rows = Vec::new();
        for time in ["0", "1"] {
            for probe in &header.probes {
                let mut row = vec![time.to_owned(), probe.name.clone()];
                row.resize(PLACE + 7, "1".to_owned());
                rows.push(row);
            }
        }
        rows.pop();
        TableWriter::create(&path, &columns(&header)).expect("created").append(rows).expect("written");
        let (times, all) = read(&path, &header).expect("read");
        assert_eq!(times, [0.0]);
        assert!(all.iter().all(|series| series.values[0].len() == 1));
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
