//! Writer of `probes.csv`: one line per time, probe and point.

use std::path::Path;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{ProbePoints, ProbeSample, ProbeSet, ProbeValues};
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::paths::PROBES_CSV;
use crate::table::{TableColumn, TableWriter, line, number};
use sphecs_core::particles::sample::Sample;

/// Returns name, unit and long name of the quantities, in the order of the columns after the
/// position.
pub(super) fn quantities(header: &Header) -> [(&'static str, &'static str, &'static str); 7] {
    let mass_flow = if header.dimensions == 2 { "kg m-1 s-1" } else { "kg s-1" };
    [
        ("u", "m s-1", "velocity along x"),
        ("v", "m s-1", "velocity along y"),
        ("w", "m s-1", "velocity along z"),
        ("pressure", "Pa", "pressure"),
        ("density", "kg m-3", "density"),
        ("mass_flow", mass_flow, "mass flow through the section along its normal"),
        ("mean_pressure", "Pa", "mean pressure of the section"),
    ]
}

/// Number of columns before the quantities.
pub(super) const PLACE: usize = 6;

/// Returns the columns of `probes.csv`.
pub(super) fn columns(header: &Header) -> Vec<TableColumn> {
    let mut columns =
        vec![TableColumn::new("time", "s"), TableColumn::of_text("probe"), TableColumn::of_text("point")];
    columns.extend(["x", "y", "z"].map(|axis| TableColumn::new(axis, "m")));
    columns.extend(quantities(header).map(|(name, unit, _)| TableColumn::new(name, unit)));
    columns
}

/// Appends to `probes.csv`.
#[derive(Debug)]
pub struct ProbeWriter {
    table: TableWriter,
    /// Probe, point and position of each row as CSV, by probe.
    starts: Vec<Vec<String>>,
}

impl ProbeWriter {
    /// Creates `probes.csv` in a run folder.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn create(folder: &Path, header: &Header, probes: &ProbeSet) -> Result<Self, OutputError> {
        let table = TableWriter::create(&folder.join(PROBES_CSV), &columns(header))?;
        Ok(Self { table, starts: starts(probes) })
    }

    /// Continues `probes.csv` after its first `length` bytes, or creates it if `length` is 0.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn resume(
        folder: &Path,
        header: &Header,
        probes: &ProbeSet,
        length: u64,
    ) -> Result<Self, OutputError> {
        if length == 0 {
            return Self::create(folder, header, probes);
        }
        Ok(Self { table: TableWriter::resume(&folder.join(PROBES_CSV), length)?, starts: starts(probes) })
    }

    /// Returns the table of the file.
    pub(crate) fn table(&self) -> &TableWriter {
        &self.table
    }

    /// Appends the samples of all probes, which are written to the file when this returns.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn append(&mut self, sample: &ProbeSample) -> Result<(), OutputError> {
        let time = number(sample.time);
        // Formatting a line probe of a thousand points takes longer than sampling it.
        let of_probe = |(starts, values): (&Vec<String>, &ProbeValues)| lines(&time, starts, values);
        let lines: Vec<String> = self.starts.par_iter().zip(&sample.values).map(of_probe).collect();
        self.table.append_lines(&lines.concat())
    }
}

/// Returns the lines of one probe at one time.
fn lines(time: &str, starts: &[String], values: &ProbeValues) -> String {
    match values {
        ProbeValues::Fields(fields) => {
            let line = |(start, field): (&String, &Option<Sample>)| {
                format!("{time},{start},{},,\n", fields_of(field.as_ref()))
            };
            starts.iter().zip(fields).map(line).collect()
        }
        ProbeValues::Section { mass_flow, mean_pressure } => {
            let line = |start| format!("{time},{start},,,,,,{mass_flow:.8e},{mean_pressure:.8e}\n");
            starts.iter().map(line).collect()
        }
    }
}

/// Returns probe, point and position of each row as CSV, by probe.
fn starts(probes: &ProbeSet) -> Vec<Vec<String>> {
    let starts = |probe: &ProbePoints| {
        let section = [probe.at];
        let places = match probe.shape {
            ProbeShape::Section => &section[..],
            ProbeShape::Point | ProbeShape::Line => &probe.points,
        };
        let start = |(point, at): (usize, &DVec3)| {
            let mut cells = vec![probe.name.clone(), point.to_string()];
            cells.extend(at.to_array().map(number));
            line(&cells)
        };
        places.iter().enumerate().map(start).collect()
    };
    probes.probes().iter().map(starts).collect()
}

/// Returns velocity, pressure and density as cells, empty without fluid nearby.
///
/// Nine digits exceed the accuracy of a sample, and more would only fill the disk.
fn fields_of(sample: Option<&Sample>) -> String {
    match sample {
        Some(Sample { velocity: DVec3 { x, y, z }, pressure, density }) => {
            format!("{x:.8e},{y:.8e},{z:.8e},{pressure:.8e},{density:.8e}")
        }
        None => ",,,,".to_owned(),
    }
}
