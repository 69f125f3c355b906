//! Force and torque on the bodies over time: `forces.csv` and `forces.nc`.
//!
//! - [`spectrum`]: amplitude spectrum of a coefficient
//! - [`shedding`]: line of vortex shedding in the lift, or the reason why there is none
//! - [`periodic_fit`]: amplitude of the part that repeats with that line
//! - [`text`]: lines for the user
//! - [`means`]: means, amplitudes and Strouhal number over an interval, `forces_mean.csv`
//!
//! ```text
//! c_d = F_x/(½ ρ0 u∞² A),   c_l = F_y/(½ ρ0 u∞² A)
//! ```
//!
//! Negi et al. (2020), section 4.6, which omits A. A body that moves has its motion beside the
//! forces, and the power F·v + T·ω of the fluid on it. A row has the time and the forces at the
//! beginning of a step. The CSV file is written during the run like `monitor.csv`; the NetCDF file
//! is made from it when the run is packed.

pub mod means;
pub mod periodic_fit;
pub mod shedding;
pub mod spectrum;
pub mod text;

use std::path::Path;

use glam::DVec3;
use means::Means;

use super::error::OutputError;
use super::header::{BodyHeader, Header};
use super::netcdf::dataset::{Dataset, Group, Variable, over, over_time};
use super::pack::Packed;
use super::paths::{FORCES_CSV, FORCES_NETCDF};
use super::table::{Table, TableColumn, TableWriter, number};
use sphecs_core::pass::body::BodySum;
use sphecs_engine::systems::body_forces::BodyForcesRow;
use sphecs_scene::result_name::result_name;

/// Appends rows to `forces.csv`.
#[derive(Debug)]
pub struct ForcesWriter {
    table: TableWriter,
    header: Header,
}

/// Returns the columns before those of the bodies, with their long names.
fn clock_columns() -> [(TableColumn, String); 2] {
    [
        (TableColumn::new("time", "s"), "time at the beginning of the step".to_owned()),
        (TableColumn::new("step", "1"), "steps done before".to_owned()),
    ]
}

/// Returns the columns of a body without its name, with their long names.
fn body_columns(header: &Header, body: &BodyHeader) -> Vec<(TableColumn, String)> {
    // In 2D per metre of depth.
    let [force, torque] = if header.dimensions == 2 { ["N m-1", "N"] } else { ["N", "N m"] };
    let mut columns = Vec::new();
    let mut add =
        |name: String, unit: &str, long_name: String| columns.push((TableColumn::new(name, unit), long_name));
    for (part, of) in
        [("", "of the fluid"), ("pressure_", "of the pressure"), ("viscous_", "of all but the pressure")]
    {
        for axis in header.axes() {
            let long_name = format!("force {of} on {} along {axis}", body.name);
            add(format!("{part}force_{axis}"), force, long_name);
        }
        for axis in header.rotation_axes() {
            let long_name = format!("torque {of} on {} about {axis}", body.name);
            add(format!("{part}torque_{axis}"), torque, long_name);
        }
    }
    if body.moves {
        for axis in header.axes() {
            add(format!("position_{axis}"), "m", format!("position of {} along {axis}", body.name));
        }
        for axis in header.axes() {
            add(format!("velocity_{axis}"), "m s-1", format!("velocity of {} along {axis}", body.name));
        }
        for axis in header.rotation_axes() {
            let long_name = format!("angular velocity of {} about {axis}", body.name);
            add(format!("angular_velocity_{axis}"), "rad s-1", long_name);
        }
        let power = if header.dimensions == 2 { "W m-1" } else { "W" };
        add("power".to_owned(), power, format!("power of the fluid on {}", body.name));
    }
    if body.reference.is_some() {
        add("c_d".to_owned(), "1", format!("drag coefficient of {}", body.name));
        add("c_l".to_owned(), "1", format!("lift coefficient of {}", body.name));
    }
    columns
}

/// Returns the columns of `forces.csv`, those of the bodies with their names behind.
fn columns(header: &Header) -> Vec<TableColumn> {
    let mut columns: Vec<TableColumn> = clock_columns().map(|(column, _)| column).to_vec();
    for body in &header.bodies {
        let name = result_name(&body.name);
        let named = |(column, _): (TableColumn, String)| {
            let name = format!("{}_{name}", column.name);
            TableColumn { name, ..column }
        };
        columns.extend(body_columns(header, body).into_iter().map(named));
    }
    columns
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
            TableWriter::create(&path, &columns(header))?
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
        let axes = header.dimensions;
        let along = |vector: DVec3| vector.to_array().into_iter().take(axes).map(number);
        let about =
            |vector: DVec3| vector.to_array().into_iter().skip(if axes == 2 { 2 } else { 0 }).map(number);
        for ((body, sum), motion) in header.bodies.iter().zip(&row.forces).zip(&row.motions) {
            for (force, torque) in parts(sum) {
                cells.extend(along(force));
                cells.extend(about(torque));
            }
            if let Some(motion) = motion {
                cells.extend(along(motion.position));
                cells.extend(along(motion.velocity));
                cells.extend(about(motion.spin));
                cells.push(number(motion.power(sum)));
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
    let found = means::means_of_bodies(header, &table);
    let mut next = clock_columns().len();
    let groups = header.bodies.iter().map(|body| {
        let columns = body_columns(header, body);
        let first = next;
        next += columns.len();
        Ok(group(body, &table, &columns, first, &found))
    });
    let path = folder.join(FORCES_NETCDF);
    let title = "force and torque on the bodies over time".to_owned();
    Dataset { title, root: Group::default() }.write_with(&path, header, groups)?;
    packed.files.push(path);
    packed.files.extend(means::write(folder, header, &found)?);
    packed.notes.extend(means::notes(header, &table));
    let with_reference = header.bodies.iter().filter(|body| body.reference.is_some());
    for (body, (_, means)) in with_reference.zip(&found) {
        packed.forces.push((body.name.clone(), text::lines(means)));
    }
    Ok(())
}

/// Returns the group of a body, whose columns begin at `first` in the table.
fn group(
    body: &BodyHeader,
    table: &Table,
    columns: &[(TableColumn, String)],
    first: usize,
    found: &[(String, Means)],
) -> Group {
    let name = result_name(&body.name);
    let clock = clock_columns();
    let own = clock.iter().zip(0..).chain(columns.iter().zip(first..));
    let over_rows = |((column, long_name), index): (&(TableColumn, String), usize)| {
        over_time(column, &column.name, Some(long_name), table.numbers(index))
    };
    let mut variables: Vec<Variable> = own.map(over_rows).collect();
    if let Some((_, means)) = found.iter().find(|(other, _)| *other == name) {
        variables.extend(means::QUANTITIES.map(|(quantity, long_name)| {
            let mut attributes = vec![("units", "1".to_owned()), ("long_name", long_name.to_owned())];
            if quantity == "strouhal" && !means.remark().is_empty() {
                attributes.push(("comment", means.remark()));
            }
            let (name, values) = (quantity.to_owned(), vec![means.get(quantity)]);
            Variable { name, dimensions: Vec::new(), values, attributes }
        }));
    }
    let attributes = vec![("long_name", body.name.clone())];
    Group { name, attributes, variables, ..over(table.rows.len()) }
}
