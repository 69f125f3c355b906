//! Integral quantities of the flow over time: `monitor.csv` and `monitor.nc`.
//!
//! The CSV file is written row by row during the run, with columns named `name [unit]`. Packing the
//! run makes the NetCDF file from it, with the same columns as variables over `time`.

use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::header::Header;
use super::netcdf::dataset::Dataset;
use super::paths::{MONITOR_CSV, MONITOR_NETCDF};
use super::table::{Table, TableColumn, TableWriter, for_each_row, number, parsed};
use sphecs_core::particles::zone::Zone;
use sphecs_engine::systems::monitor::MonitorRow;
use sphecs_scene::result_name::result_name;

/// Appends rows to `monitor.csv`.
#[derive(Debug)]
pub struct MonitorWriter {
    table: TableWriter,
    dimensions: usize,
}

/// Returns column and long name of each quantity of a row.
fn columns(header: &Header) -> Vec<(TableColumn, String)> {
    // In 2D all extensive quantities are per metre of depth.
    let planar = header.dimensions == 2;
    let [mass, mass_flow, energy, momentum, angular_momentum] = if planar {
        ["kg m-1", "kg m-1 s-1", "J m-1", "kg s-1", "kg m s-1"]
    } else {
        ["kg", "kg s-1", "J", "kg m s-1", "kg m2 s-1"]
    };
    let mut columns = Vec::new();
    let mut add =
        |name: String, unit: &str, long_name: String| columns.push((TableColumn::new(name, unit), long_name));
    add("time".into(), "s", "time since the start of the run".into());
    add("step".into(), "1", "steps done".into());
    add("time_step".into(), "s", "size of the last step".into());
    for zone in Zone::ALL.map(Zone::name) {
        add(format!("count_{zone}"), "1", format!("number of {zone} particles"));
    }
    for zone in Zone::ALL.map(Zone::name) {
        add(format!("mass_{zone}"), mass, format!("mass of the {zone} particles"));
    }
    for name in header.inlets.iter().map(|name| result_name(name)) {
        let long_name = format!("mass flow into the domain through {name}, mean since the row before");
        add(format!("inlet_mass_flow_{name}"), mass_flow, long_name);
    }
    for name in header.outlets.iter().map(|name| result_name(name)) {
        let long_name = format!("mass flow out of the domain through {name}, mean since the row before");
        add(format!("outlet_mass_flow_{name}"), mass_flow, long_name);
    }
    add("kinetic_energy".into(), energy, "kinetic energy of the fluid".into());
    for axis in header.axes() {
        add(format!("momentum_{axis}"), momentum, format!("momentum of the fluid along {axis}"));
    }
    for axis in header.rotation_axes() {
        let long_name = format!("angular momentum of the fluid about the origin along {axis}");
        add(format!("angular_momentum_{axis}"), angular_momentum, long_name);
    }
    add("largest_speed".into(), "m s-1", "largest speed of the fluid".into());
    add(
        "largest_density_deviation".into(),
        "1",
        "largest deviation from the reference density over the reference density".into(),
    );
    add("largest_divergence".into(), "s-1", "largest absolute divergence of the velocity".into());
    add("mean_pressure".into(), "Pa", "mean pressure of the fluid".into());
    add(
        "held_at_walls".into(),
        "1",
        "times that a fluid particle was set back onto a wall since the row before".into(),
    );
    add("through_walls".into(), "1", "fluid particles behind a wall surface".into());
    add("close_pairs".into(), "1", "pairs of fluid particles nearer than half a spacing".into());
    columns
}

/// Rows of `monitor.csv` as columns of numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MonitorRows {
    columns: Vec<(TableColumn, Vec<f64>)>,
}

impl MonitorRows {
    /// Returns a column.
    pub fn column(&self, name: &str) -> Option<&[f64]> {
        self.columns.iter().find(|(column, _)| column.name == name).map(|(_, values)| values.as_slice())
    }

    /// Returns unit and sum of all columns whose names begin with `name`; None without any.
    pub fn sum(&self, name: &str) -> Option<(String, Vec<f64>)> {
        let mut columns = self.columns.iter().filter(|(column, _)| column.name.starts_with(name));
        let (first, values) = columns.next()?;
        let mut sum = values.clone();
        for (_, values) in columns {
            sum.iter_mut().zip(values).for_each(|(sum, value)| *sum += value);
        }
        Some((first.unit.clone().unwrap_or_default(), sum))
    }
}

/// Returns the rows written so far; none before the first.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub fn read_rows(folder: &Path) -> Result<MonitorRows, OutputError> {
    let path = folder.join(MONITOR_CSV);
    if !path.exists() {
        return Ok(MonitorRows::default());
    }
    let mut values: Vec<Vec<f64>> = Vec::new();
    let columns = for_each_row(&path, |row| {
        values.resize_with(row.len().max(values.len()), Vec::new);
        values.iter_mut().zip(row).for_each(|(column, cell)| column.push(parsed(cell)));
    })?;
    values.resize_with(columns.len(), Vec::new);
    Ok(MonitorRows { columns: columns.into_iter().zip(values).collect() })
}

impl MonitorWriter {
    /// Creates `monitor.csv` in a run folder.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn create(folder: &Path, header: &Header) -> Result<Self, OutputError> {
        let columns: Vec<TableColumn> = columns(header).into_iter().map(|(column, _)| column).collect();
        Ok(Self {
            table: TableWriter::create(&folder.join(MONITOR_CSV), &columns)?,
            dimensions: header.dimensions,
        })
    }

    /// Continues `monitor.csv` after its first `length` bytes, or creates it if `length` is 0.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn resume(folder: &Path, header: &Header, length: u64) -> Result<Self, OutputError> {
        if length == 0 {
            return Self::create(folder, header);
        }
        Ok(Self {
            table: TableWriter::resume(&folder.join(MONITOR_CSV), length)?,
            dimensions: header.dimensions,
        })
    }

    /// Returns the table of the file.
    pub(crate) fn table(&self) -> &TableWriter {
        &self.table
    }

    /// Appends a row, which is written to the file when this returns.
    ///
    /// # Errors
    /// [`OutputError::Io`] when the write fails.
    pub fn append(&mut self, row: &MonitorRow) -> Result<(), OutputError> {
        let mut cells = vec![number(row.time), row.step.to_string(), number(row.time_step)];
        cells.extend(row.count.iter().map(u64::to_string));
        let numbers = row.mass.iter().chain(&row.inlet_mass_flow).chain(&row.outlet_mass_flow);
        cells.extend(numbers.map(|&value| number(value)));
        cells.push(number(row.kinetic_energy));
        cells.extend(row.momentum.to_array().iter().take(self.dimensions).map(|&value| number(value)));
        // In 2D about z alone.
        let first = if self.dimensions == 2 { 2 } else { 0 };
        cells.extend(row.angular_momentum.to_array().iter().skip(first).map(|&value| number(value)));
        cells.extend(
            [row.largest_speed, row.largest_density_deviation, row.largest_divergence, row.mean_pressure]
                .map(number),
        );
        cells.extend([row.held_at_walls, row.through_walls, row.close_pairs].map(|count| count.to_string()));
        self.table.append([cells])
    }
}

/// Returns the columns of `monitor.csv` with their names, without units.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub fn read_history(folder: &Path) -> Result<Vec<(String, Vec<f64>)>, OutputError> {
    let table = Table::read(&folder.join(MONITOR_CSV))?;
    let numbers = |index: usize| table.numbers(index);
    Ok(table
        .columns
        .iter()
        .enumerate()
        .map(|(index, column)| (column.name.clone(), numbers(index)))
        .collect())
}

/// Writes `monitor.nc` from `monitor.csv` and returns its path; None without a CSV file.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub fn pack(folder: &Path, header: &Header) -> Result<Option<PathBuf>, OutputError> {
    let source = folder.join(MONITOR_CSV);
    if !source.exists() {
        return Ok(None);
    }
    let table = Table::read(&source)?;
    let mut dataset = Dataset::over_time("integral figures over time", &table, &columns(header));
    for variable in dataset.root.variables.iter_mut().filter(|variable| variable.name.contains("mass_flow")) {
        variable.attributes.push(("cell_methods", "time: mean".to_owned()));
    }
    let target = folder.join(MONITOR_NETCDF);
    dataset.write(&target, header)?;
    Ok(Some(target))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn values_are_written_under_their_names() {
        let folder = tempfile::tempdir().expect("a folder");
        let header = Header {
            dimensions: 2,
            inlets: vec!["in".to_owned()],
            outlets: vec!["left leg".to_owned(), "right leg".to_owned()],
            ..Header::default()
        };
        let row = MonitorRow {
            time: 0.25,
            step: 12,
            count: [5, 4, 3, 2, 1],
            inlet_mass_flow: vec![1.5],
            outlet_mass_flow: vec![0.5, 1.0],
            momentum: DVec3::new(7.0, 8.0, 0.0),
            angular_momentum: DVec3::new(0.0, 0.0, 3.5),
            held_at_walls: 7,
            close_pairs: 9,
            ..MonitorRow::default()
        };
        let mut writer = MonitorWriter::create(folder.path(), &header).expect("created");
        writer.append(&row).expect("written");
        let table = Table::read(&folder.path().join(MONITOR_CSV)).expect("read");
        let value = |name: &str| {
            let column = table.columns.iter().position(|column| column.name == name);
            table.numbers(column.expect(name))[0]
        };
        for (name, wanted) in [
            ("time", 0.25),
            ("step", 12.0),
            ("count_reservoir", 1.0),
            ("inlet_mass_flow_in", 1.5),
            ("outlet_mass_flow_right_leg", 1.0),
            ("momentum_y", 8.0),
            ("angular_momentum_z", 3.5),
            ("held_at_walls", 7.0),
            ("close_pairs", 9.0),
        ] {
            assert_eq!(value(name), wanted, "{name}");
        }
        let packed = pack(folder.path(), &header).expect("packed").expect("there is a table");
        assert!(packed.starts_with(folder.path()) && packed.is_file(), "{}", packed.display());
    }
}
