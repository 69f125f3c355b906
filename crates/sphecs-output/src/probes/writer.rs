//! `probes.csv`, written while the run goes on: tidy, a line per time, probe and point.

use std::path::Path;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::{ProbePoints, ProbeSample, ProbeSet, ProbeValues};
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::table::{Column, TableWriter, line, number};
use sphecs_core::particles::sample::Sample;

/// Name of the CSV file in the run folder.
pub const CSV: &str = "probes.csv";
/// Name of the CSV file of time means in the run folder.
pub const MEAN_CSV: &str = "probes_mean.csv";

/// Name, unit and long name of the measured quantities, in the order of the columns after time, probe, point and place.
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

/// Columns before the quantities.
pub(super) const PLACE: usize = 6;

/// The columns of `probes.csv`.
pub(super) fn columns(header: &Header) -> Vec<Column> {
    let mut columns = vec![Column::new("time", "s"), Column::of_text("probe"), Column::of_text("point")];
    columns.extend(["x", "y", "z"].map(|axis| Column::new(axis, "m")));
    columns.extend(quantities(header).map(|(name, unit, _)| Column::new(name, unit)));
    columns
}

/// Appends to `probes.csv`.
#[derive(Debug)]
pub struct ProbeWriter {
    table: TableWriter,
    /// Probe, point and place of each row, as CSV; by probe.
    starts: Vec<Vec<String>>,
}

impl ProbeWriter {
    /// Starts `probes.csv` in a run folder.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn create(folder: &Path, header: &Header, probes: &ProbeSet) -> Result<Self, OutputError> {
        let table = TableWriter::create(&folder.join(CSV), &columns(header))?;
        Ok(Self { table, starts: starts(probes) })
    }

    /// Goes on behind the first `length` bytes of `probes.csv`, or starts it where there are none.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn go_on(
        folder: &Path,
        header: &Header,
        probes: &ProbeSet,
        length: u64,
    ) -> Result<Self, OutputError> {
        if length == 0 {
            return Self::create(folder, header, probes);
        }
        Ok(Self { table: TableWriter::go_on(&folder.join(CSV), length)?, starts: starts(probes) })
    }

    /// The table, for its length.
    pub(crate) fn table(&self) -> &TableWriter {
        &self.table
    }

    /// Appends what the probes measured, which is in the file when this returns.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the system refuses.
    pub fn append(&mut self, sample: &ProbeSample) -> Result<(), OutputError> {
        let time = number(sample.time);
        // A line of a thousand points takes longer to write down than to measure.
        let of_probe = |(starts, values): (&Vec<String>, &ProbeValues)| lines(&time, starts, values);
        let lines: Vec<String> = self.starts.par_iter().zip(&sample.values).map(of_probe).collect();
        self.table.append_lines(&lines.concat())
    }
}

/// What one probe measured at a time, line by line.
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

/// Probe, point and place of each row, as CSV; by probe.
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

/// Velocity, pressure and density as cells, empty where no fluid was near. Nine digits: a sample is not better than that,
/// and a line of many points fills the disk.
fn fields_of(sample: Option<&Sample>) -> String {
    match sample {
        Some(Sample { velocity: DVec3 { x, y, z }, pressure, density }) => {
            format!("{x:.8e},{y:.8e},{z:.8e},{pressure:.8e},{density:.8e}")
        }
        None => ",,,,".to_owned(),
    }
}
