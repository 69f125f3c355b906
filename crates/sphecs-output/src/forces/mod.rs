//! Force and torque on the bodies over time: `forces.csv` and `forces.nc`.
//!
//! - [`spectrum`]: frequency of the lift
//! - [`means`]: means, amplitudes and Strouhal number over an interval, `forces_mean.csv`
//!
//! ```text
//! c_d = F_x/(½ ρ0 u∞² A),   c_l = F_y/(½ ρ0 u∞² A)
//! ```
//!
//! Negi et al. (2020), section 4.6, which omits A. A row has the time and the forces at the
//! beginning of a step. The CSV file is written during the run like `monitor.csv`; the NetCDF file
//! is made from it when the run is packed.

pub mod means;
pub mod spectrum;

use std::path::Path;

use glam::DVec3;
use means::Means;

use super::error::OutputError;
use super::header::{BodyHeader, Header};
use super::netcdf::dataset::{Dataset, Variable};
use super::pack::Packed;
use super::paths::{FORCES_CSV, FORCES_NETCDF};
use super::table::{Table, TableColumn, TableWriter, number, safe_names};
use sphecs_core::pass::body::BodySum;
use sphecs_engine::systems::body_forces::BodyForcesRow;

/// Appends rows to `forces.csv`.
#[derive(Debug)]
pub struct ForcesWriter {
    table: TableWriter,
    header: Header,
}

/// Returns column and long name of each quantity of a row.
fn columns(header: &Header) -> Vec<(TableColumn, String)> {
    // In 2D per metre of depth.
    let [force, torque] = if header.dimensions == 2 { ["N m-1", "N"] } else { ["N", "N m"] };
    let mut columns = Vec::new();
    let mut add =
        |name: String, unit: &str, long_name: String| columns.push((TableColumn::new(name, unit), long_name));
    add("time".into(), "s", "time at the beginning of the step".into());
    add("step".into(), "1", "steps done before".into());
    let names = safe_names(header.bodies.iter().map(|body| body.name.as_str()));
    for (body, name) in header.bodies.iter().zip(names) {
        for (part, of) in
            [("", "of the fluid"), ("pressure_", "of the pressure"), ("viscous_", "of all but the pressure")]
        {
            for axis in header.axes() {
                add(
                    format!("{part}force_{axis}_{name}"),
                    force,
                    format!("force {of} on {} along {axis}", body.name),
                );
            }
            for axis in torque_axes(header) {
                let long_name = format!("torque {of} on {} about {axis}", body.name);
                add(format!("{part}torque_{axis}_{name}"), torque, long_name);
            }
        }
        if body.reference.is_some() {
            add(format!("c_d_{name}"), "1", format!("drag coefficient of {}", body.name));
            add(format!("c_l_{name}"), "1", format!("lift coefficient of {}", body.name));
        }
    }
    columns
}

/// Returns the axes that a torque may have.
fn torque_axes(header: &Header) -> &'static [&'static str] {
    if header.dimensions == 2 { &["z"] } else { &["x", "y", "z"] }
}

/// Returns drag and lift coefficient of a force, N (N/m in 2D).
fn coefficients(header: &Header, body: &BodyHeader, force: DVec3) -> Option<[f64; 2]> {
    let reference = body.reference?;
    let scale = 0.5 * header.reference_density * reference.velocity * reference.velocity * reference.area;
    Some([force.x / scale, force.y / scale])
}

impl ForcesWriter {
    /// Continues `forces.csv` after its first `length` bytes, or creates it if `length` is 0.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn resume(folder: &Path, header: &Header, length: u64) -> Result<Self, OutputError> {
        let path = folder.join(FORCES_CSV);
        let table = if length == 0 {
            let columns: Vec<TableColumn> = columns(header).into_iter().map(|(column, _)| column).collect();
            TableWriter::create(&path, &columns)?
        } else {
            TableWriter::resume(&path, length)?
        };
        Ok(Self { table, header: header.clone() })
    }

    /// Returns the table of the file.
    pub(crate) fn table(&self) -> &TableWriter {
        &self.table
    }

    /// Appends a row, which is written to the file when this returns.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn append(&mut self, row: &BodyForcesRow) -> Result<(), OutputError> {
        let header = &self.header;
        let mut cells = vec![number(row.time), row.step.to_string()];
        for (body, sum) in header.bodies.iter().zip(&row.forces) {
            for (force, torque) in parts(sum) {
                let axes = header.dimensions;
                cells.extend(force.to_array().iter().take(axes).map(|&value| number(value)));
                let torque = torque.to_array();
                cells.extend(torque[if axes == 2 { 2.. } else { 0.. }].iter().map(|&value| number(value)));
            }
            let force = sum.pressure_force + sum.viscous_force;
            cells.extend(coefficients(header, body, force).into_iter().flatten().map(number));
        }
        self.table.append([cells])
    }
}

/// Returns force and torque: total, of the pressure, of all other terms.
fn parts(sum: &BodySum) -> [(DVec3, DVec3); 3] {
    [
        (sum.pressure_force + sum.viscous_force, sum.pressure_torque + sum.viscous_torque),
        (sum.pressure_force, sum.pressure_torque),
        (sum.viscous_force, sum.viscous_torque),
    ]
}

/// Forces on the bodies of a run and their means.
#[derive(Clone, Debug, Default)]
pub struct ForcesHistory {
    /// Columns of `forces.csv` by name; none without bodies.
    pub columns: Vec<(String, Vec<f64>)>,
    /// Means of the bodies that have coefficients, by name.
    pub means: Vec<(String, Means)>,
}

/// Reads `forces.csv`, if the run has one.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub fn read_history(folder: &Path, header: &Header) -> Result<ForcesHistory, OutputError> {
    let path = folder.join(FORCES_CSV);
    if !path.exists() {
        return Ok(ForcesHistory::default());
    }
    let table = Table::read(&path)?;
    let columns = table.columns.iter().enumerate();
    // The names are those of the scene, not of the columns.
    let with_reference = header.bodies.iter().filter(|body| body.reference.is_some());
    let means = with_reference
        .zip(means::means_of_bodies(header, &table))
        .map(|(body, (_, means))| (body.name.clone(), means));
    Ok(ForcesHistory {
        columns: columns.map(|(index, column)| (column.name.clone(), table.numbers(index))).collect(),
        means: means.collect(),
    })
}

/// Writes `forces.nc` and `forces_mean.csv` from `forces.csv` and adds their paths to `packed`,
/// with a note on each mean that the run did not complete; nothing without a CSV file.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn pack(folder: &Path, header: &Header, packed: &mut Packed) -> Result<(), OutputError> {
    let source = folder.join(FORCES_CSV);
    if !source.exists() {
        return Ok(());
    }
    let table = Table::read(&source)?;
    let mut dataset =
        Dataset::over_time("force and torque on the bodies over time", &table, &columns(header));
    let found = means::means_of_bodies(header, &table);
    for (name, long_name) in means::QUANTITIES {
        for (body, means) in &found {
            dataset.variables.push(Variable {
                name: format!("{name}_{body}"),
                dimensions: Vec::new(),
                values: vec![means.get(name)],
                attributes: vec![("units", "1".to_owned()), ("long_name", long_name.to_owned())],
            });
        }
    }
    let path = folder.join(FORCES_NETCDF);
    dataset.write(&path, header)?;
    packed.files.push(path);
    packed.files.extend(means::write(folder, header, &found)?);
    packed.notes.extend(means::notes(header, &table));
    Ok(())
}
