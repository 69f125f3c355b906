//! Writer of the samples: one CSV file per probe, and one with the points of all.
//!
//! A file has the quantities of its probe only, one line per time, for a line probe one per time
//! and point. The places are in `probes_points.csv`, once.

use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

use super::{ProbePoints, ProbeSample, ProbeSet, ProbeValues};
use crate::disk;
use crate::error::OutputError;
use crate::header::{Header, ProbeShape};
use crate::paths::{self, PROBES, PROBES_POINTS_CSV};
use crate::table::{TableColumn, TableWriter, number};
use sphecs_core::particles::sample::Sample;

/// A measured quantity.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Quantity {
    /// Name of its column and variable.
    pub(super) name: &'static str,
    /// Unit in UDUNITS notation.
    pub(super) unit: &'static str,
    /// Long name.
    pub(super) long_name: &'static str,
}

/// Returns the quantities of a probe in the order of its columns.
pub(super) fn quantities(shape: ProbeShape, dimensions: usize) -> Vec<Quantity> {
    let quantity = |(name, unit, long_name)| Quantity { name, unit, long_name };
    let mass_flow = if dimensions == 2 { "kg m-1 s-1" } else { "kg s-1" };
    match shape {
        ProbeShape::Section => [
            ("mass_flow", mass_flow, "mass flow through the section along its normal"),
            ("mean_pressure", "Pa", "mean pressure of the section"),
        ]
        .map(quantity)
        .to_vec(),
        ProbeShape::Point | ProbeShape::Line => [
            ("u", "m s-1", "velocity along x"),
            ("v", "m s-1", "velocity along y"),
            ("w", "m s-1", "velocity along z"),
            ("pressure", "Pa", "pressure"),
            ("density", "kg m-3", "density"),
        ]
        .into_iter()
        .filter(|&(name, ..)| dimensions == 3 || name != "w")
        .map(quantity)
        .collect(),
    }
}

/// Returns the columns of the samples of a probe.
pub(super) fn columns(shape: ProbeShape, dimensions: usize) -> Vec<TableColumn> {
    let point = (shape == ProbeShape::Line).then(|| TableColumn::of_text("point"));
    let values = quantities(shape, dimensions).into_iter();
    let time = std::iter::once(TableColumn::new("time", "s"));
    time.chain(point).chain(values.map(|quantity| TableColumn::new(quantity.name, quantity.unit))).collect()
}

/// Appends to the CSV files of the probes.
#[derive(Debug)]
pub struct ProbeWriter {
    files: Vec<ProbeFile>,
}

/// CSV file of a probe.
///
/// It is open during a write only, so that the number of probes is not limited by that of open
/// files.
#[derive(Debug)]
struct ProbeFile {
    path: PathBuf,
    length: u64,
    is_line: bool,
    dimensions: usize,
}

impl ProbeWriter {
    /// Continues the files after their first `lengths` bytes, or creates them without lengths.
    ///
    /// # Errors
    /// [`OutputError::Io`] when a write fails.
    pub fn resume(
        folder: &Path,
        header: &Header,
        probes: &ProbeSet,
        lengths: &[u64],
    ) -> Result<Self, OutputError> {
        let inner = folder.join(PROBES);
        fs::create_dir_all(&inner).map_err(OutputError::io(&inner, "make the folder"))?;
        write_points(folder, header, probes)?;
        let file = |(index, probe): (usize, &ProbePoints)| {
            let path = paths::probe(folder, &probe.name);
            let table = match lengths.get(index) {
                None | Some(0) => TableWriter::create(&path, &columns(probe.shape, header.dimensions))?,
                Some(&length) => TableWriter::resume(&path, length)?,
            };
            let is_line = probe.shape == ProbeShape::Line;
            Ok(ProbeFile { path, length: table.length(), is_line, dimensions: header.dimensions })
        };
        let files = probes.probes().iter().enumerate().map(file).collect::<Result<_, OutputError>>()?;
        disk::sync_folder(&inner)?;
        Ok(Self { files })
    }

    /// Returns the number of bytes written to each file.
    pub(crate) fn lengths(&self) -> Vec<u64> {
        self.files.iter().map(|file| file.length).collect()
    }

    /// Returns the paths of the files.
    pub(crate) fn paths(&self) -> impl Iterator<Item = PathBuf> + '_ {
        self.files.iter().map(|file| file.path.clone())
    }

    /// Appends the samples of the probes that have some, which are written to the files when this
    /// returns.
    ///
    /// # Errors
    /// [`OutputError::Io`] when a write fails.
    pub fn append(&mut self, sample: &ProbeSample) -> Result<(), OutputError> {
        let time = number(sample.time);
        // Formatting a line of a thousand points takes longer than sampling it.
        let written = self.files.par_iter_mut().zip(&sample.values).map(|(file, values)| match values {
            Some(values) => file.append(&lines(&time, values, file.is_line, file.dimensions)),
            None => Ok(()),
        });
        // The first error in the order of the probes, whichever thread was faster.
        written.collect::<Vec<_>>().into_iter().collect()
    }
}

impl ProbeFile {
    fn append(&mut self, lines: &str) -> Result<(), OutputError> {
        let opened = File::options().append(true).open(&self.path);
        let written = opened.and_then(|mut file| file.write_all(lines.as_bytes()));
        written.map_err(OutputError::io(&self.path, "write"))?;
        self.length += lines.len() as u64;
        Ok(())
    }
}

/// Returns the lines of one probe at one time.
fn lines(time: &str, values: &ProbeValues, is_line: bool, dimensions: usize) -> String {
    match values {
        ProbeValues::Fields(fields) => {
            let line = |(point, field): (usize, &Option<Sample>)| {
                let values = fields_of(field.as_ref(), dimensions);
                if is_line { format!("{time},{point},{values}\n") } else { format!("{time},{values}\n") }
            };
            fields.iter().enumerate().map(line).collect()
        }
        ProbeValues::Section { mass_flow, mean_pressure } => {
            format!("{time},{mass_flow:.8e},{mean_pressure:.8e}\n")
        }
    }
}

/// Writes the points of all probes, those of the scene for sections.
fn write_points(folder: &Path, header: &Header, probes: &ProbeSet) -> Result<(), OutputError> {
    let mut columns = vec![TableColumn::of_text("probe"), TableColumn::of_text("point")];
    columns.extend(header.axes().iter().map(|axis| TableColumn::new(*axis, "m")));
    let rows = |probe: &ProbePoints| {
        let places = match probe.shape {
            ProbeShape::Section => vec![probe.at],
            ProbeShape::Point | ProbeShape::Line => probe.points.clone(),
        };
        let row = |(point, at): (usize, &DVec3)| {
            let mut cells = vec![probe.name.clone(), point.to_string()];
            cells.extend(at.to_array()[..header.dimensions].iter().map(|&x| number(x)));
            cells
        };
        places.iter().enumerate().map(row).collect::<Vec<_>>()
    };
    TableWriter::create(&folder.join(PROBES_POINTS_CSV), &columns)?
        .append(probes.probes().iter().flat_map(rows))
}

/// Returns velocity, pressure and density as cells, empty without fluid nearby.
///
/// Nine digits exceed the accuracy of a sample, and more would only fill the disk.
fn fields_of(sample: Option<&Sample>, dimensions: usize) -> String {
    match sample {
        Some(Sample { velocity: DVec3 { x, y, z }, pressure, density }) => {
            let across = if dimensions == 3 { format!("{z:.8e},") } else { String::new() };
            format!("{x:.8e},{y:.8e},{across}{pressure:.8e},{density:.8e}")
        }
        None => ",".repeat(dimensions + 1),
    }
}
