//! Layout of `fields.nc`, and of its times in the journal.
//!
//! ```text
//! dimensions  time (unlimited), (z), y, x          a plane across an axis: the other two axes
//! u v (w) pressure density vorticity (tag) fluid_fraction   f32 (time, …)   NaN: no fluid
//! solid       u8 (…), (time, …) if walls move      1: inside a wall or outside the domain
//! u_mean … uu_covariance … fluid_time              f32 (…), with `cell_methods`
//! step        i64 (time)
//! ```
//!
//! The whole domain is in the root of the file, every plane in a group of its name. An oblique
//! plane has the dimensions (time, b, a) and x, y, z as auxiliary coordinates over (b, a).

use std::path::{Path, PathBuf};

use ::netcdf::{AttributeValue, File, FileMut, Group, GroupMut};

use super::file::{Stored, WriteError, add_to_group, open_file, read_error, write_file};
use super::layout::{TIME_ATTRIBUTES, put_header};
use crate::error::OutputError;
use crate::fields::averages::FieldMeans;
use crate::fields::quantities::{Quantity, means, quantities};
use crate::fields::snapshot::{FieldSnapshot, GridValues};
use crate::header::{FieldsHeader, Header};
use sphecs_scene::field_grid::FieldGrid;
use sphecs_scene::result_name::result_name;

/// Largest numbers of nodes in a chunk along the axes, the fastest last: 4 MiB of singles.
const CHUNK: [usize; 3] = [4, 512, 512];

/// Writes a file of the fields at some times, which `next` returns one by one.
///
/// # Errors
/// [`OutputError`] of a time, or with the path and the cause.
pub(crate) fn write(
    path: &Path,
    (header, fields): (&Header, &FieldsHeader),
    times: usize,
    means: Option<&FieldMeans>,
    mut next: impl FnMut(usize) -> Result<FieldSnapshot, OutputError>,
) -> Result<(), OutputError> {
    write_file(path, |file| {
        put_header(file, header, "fields on a grid")?;
        for (index, grid) in fields.grids.iter().enumerate() {
            let columns = means.map(|means| (means.covered, means.grids[index].as_slice()));
            let mut group = group_of(file, grid, true)?;
            define(&mut group, header.dimensions, fields, grid)?;
            put_means(&mut group, (header.dimensions, fields.tagged), grid, columns)?;
        }
        for index in 0..times {
            let snapshot = next(index).map_err(WriteError::Source)?;
            for (grid, values) in fields.grids.iter().zip(&snapshot.grids) {
                let mut group = group_of(file, grid, false)?;
                put_values(&mut group, header.dimensions, fields, (grid, values), index)?;
                put(&mut group, "step", &[snapshot.step as i64], &[index])?;
                put(&mut group, "time", &[snapshot.time], &[index])?;
            }
        }
        Ok(())
    })
}

/// Returns the group of a grid, which is made if it is new.
fn group_of<'f>(
    file: &'f mut FileMut,
    grid: &FieldGrid,
    is_new: bool,
) -> Result<GroupMut<'f>, ::netcdf::Error> {
    let name = result_name(&grid.name);
    let missing = || ::netcdf::Error::NotFound(name.clone());
    if grid.name.is_empty() {
        return file.root_mut().ok_or_else(missing);
    }
    if is_new { file.add_group(&name) } else { file.group_mut(&name)?.ok_or_else(missing) }
}

fn text(name: &'static str, value: impl Into<String>) -> (&'static str, AttributeValue) {
    (name, AttributeValue::from(value.into()))
}

/// Returns the names of the dimensions of a grid, the slowest first.
fn shape(grid: &FieldGrid) -> Vec<&str> {
    grid.axes.iter().rev().map(|axis| axis.name.as_str()).collect()
}

fn counts(grid: &FieldGrid) -> Vec<usize> {
    grid.axes.iter().rev().map(|axis| axis.count).collect()
}

fn chunks(grid: &FieldGrid) -> Vec<usize> {
    let counts = counts(grid);
    let limits = &CHUNK[3 - counts.len()..];
    counts.iter().zip(limits).map(|(&count, &limit)| count.min(limit)).collect()
}

/// Returns the names of the coordinates that are no dimensions.
fn auxiliary(grid: &FieldGrid, dimensions: usize) -> Vec<&'static str> {
    let all = &["x", "y", "z"][..dimensions];
    all.iter().copied().filter(|name| grid.axes.iter().all(|axis| axis.name != *name)).collect()
}

/// Defines dimensions, coordinates and the variables over time.
fn define(
    group: &mut GroupMut<'_>,
    dimensions: usize,
    fields: &FieldsHeader,
    grid: &FieldGrid,
) -> Result<(), ::netcdf::Error> {
    if !grid.name.is_empty() {
        group.add_attribute("long_name", grid.name.as_str())?;
    }
    group.add_unlimited_dimension("time")?;
    for axis in grid.axes.iter().rev() {
        group.add_dimension(&axis.name, axis.count)?;
    }
    let mut attributes = TIME_ATTRIBUTES.map(|(name, value)| text(name, value)).to_vec();
    attributes.push(text("long_name", "time since the start of the run"));
    add_to_group::<f64>(group, "time", &["time"], &[512], &attributes)?;
    let attributes = [text("units", "1"), text("long_name", "steps done")];
    add_to_group::<i64>(group, "step", &["time"], &[512], &attributes)?;
    put_coordinates(group, dimensions, grid)?;
    let over_time: Vec<&str> = std::iter::once("time").chain(shape(grid)).collect();
    let chunks: Vec<usize> = std::iter::once(1).chain(chunks(grid)).collect();
    for quantity in quantities(dimensions, fields.tagged) {
        let attributes = attributes_of(&quantity, grid, dimensions);
        add_to_group::<f32>(group, &quantity.name, &over_time, &chunks, &attributes)?;
    }
    let skipped = usize::from(!fields.has_moving_walls);
    let mut attributes = vec![
        text("units", "1"),
        text("long_name", "mask of the walls"),
        ("flag_values", AttributeValue::from(vec![0_u8, 1])),
        text("flag_meanings", "domain solid"),
    ];
    attributes.extend(coordinates_of(grid, dimensions));
    add_to_group::<u8>(group, "solid", &over_time[skipped..], &chunks[skipped..], &attributes)?;
    Ok(())
}

fn coordinates_of(grid: &FieldGrid, dimensions: usize) -> Option<(&'static str, AttributeValue)> {
    let names = auxiliary(grid, dimensions);
    (!names.is_empty()).then(|| text("coordinates", names.join(" ")))
}

fn attributes_of(
    quantity: &Quantity,
    grid: &FieldGrid,
    dimensions: usize,
) -> Vec<(&'static str, AttributeValue)> {
    let mut attributes = vec![text("units", quantity.unit), text("long_name", quantity.long_name.clone())];
    attributes.extend(coordinates_of(grid, dimensions));
    attributes
}

/// Defines and writes the coordinates in space.
fn put_coordinates(
    group: &mut GroupMut<'_>,
    dimensions: usize,
    grid: &FieldGrid,
) -> Result<(), ::netcdf::Error> {
    for axis in &grid.axes {
        let mut attributes = vec![text("units", "m")];
        match axis.name.as_str() {
            "a" | "b" => attributes.push(text(
                "long_name",
                format!(
                    "distance in the plane along ({}, {}, {})",
                    axis.direction.x, axis.direction.y, axis.direction.z
                ),
            )),
            name => {
                attributes.push(text("long_name", format!("{name} coordinate")));
            }
        }
        add_to_group::<f64>(group, &axis.name, &[&axis.name], &[axis.count], &attributes)?
            .put_values(&axis.coordinates(), ..)?;
    }
    for name in auxiliary(grid, dimensions) {
        let attributes = [text("units", "m"), text("long_name", format!("{name} coordinate"))];
        let along = "xyz".find(name).unwrap_or_default();
        if grid.is_aligned() {
            add_to_group::<f64>(group, name, &[], &[], &attributes)?.put_value(grid.origin[along], ())?;
        } else {
            let values: Vec<f64> =
                (0..grid.rows()).flat_map(|row| grid.row_points(row)).map(|point| point[along]).collect();
            add_to_group::<f64>(group, name, &shape(grid), &chunks(grid), &attributes)?
                .put_values(&values, ..)?;
        }
    }
    Ok(())
}

/// Writes the fields of a grid at one time.
fn put_values(
    group: &mut GroupMut<'_>,
    dimensions: usize,
    fields: &FieldsHeader,
    (grid, values): (&FieldGrid, &GridValues),
    index: usize,
) -> Result<(), ::netcdf::Error> {
    let at: Vec<usize> = std::iter::once(index).chain(grid.axes.iter().map(|_| 0)).collect();
    let extent: Vec<usize> = std::iter::once(1).chain(counts(grid)).collect();
    let place = |skipped: usize| (at[skipped..].to_vec(), extent[skipped..].to_vec());
    for (quantity, column) in quantities(dimensions, fields.tagged).iter().zip(&values.columns) {
        variable(group, &quantity.name)?.put_values(column, place(0))?;
    }
    if fields.has_moving_walls || index == 0 {
        variable(group, "solid")?.put_values(&values.solid, place(usize::from(!fields.has_moving_walls)))?;
    }
    Ok(())
}

fn variable<'g>(
    group: &'g mut GroupMut<'_>,
    name: &str,
) -> Result<::netcdf::VariableMut<'g>, ::netcdf::Error> {
    group.variable_mut(name).ok_or_else(|| ::netcdf::Error::NotFound(name.to_owned()))
}

fn put<T: Stored>(
    group: &mut GroupMut<'_>,
    name: &str,
    values: &[T],
    at: &[usize],
) -> Result<(), ::netcdf::Error> {
    variable(group, name)?.put_values(values, (at.to_vec(), vec![values.len(); at.len()]))
}

/// Defines and writes the means of a grid, and the interval that they cover.
fn put_means(
    group: &mut GroupMut<'_>,
    (dimensions, tagged): (usize, bool),
    grid: &FieldGrid,
    columns: Option<((f64, f64), &[Vec<f64>])>,
) -> Result<(), ::netcdf::Error> {
    let Some(((from, to), columns)) = columns else { return Ok(()) };
    for (name, value, long_name) in [
        (MEAN_TIME, 0.5 * (from + to), "middle of the interval of the means"),
        (MEAN_START, from, "beginning of the interval of the means"),
        (MEAN_END, to, "end of the interval of the means"),
    ] {
        let attributes = [text("units", "s"), text("long_name", long_name)];
        add_to_group::<f64>(group, name, &[], &[], &attributes)?.put_value(value, ())?;
    }
    let coordinates: Vec<&str> = auxiliary(grid, dimensions).into_iter().chain([MEAN_TIME]).collect();
    for (quantity, values) in means(dimensions, tagged).iter().zip(columns) {
        let method = match quantity.name.as_str() {
            "fluid_time" => "sum",
            "uu_covariance" | "vv_covariance" | "ww_covariance" => "variance",
            name if name.ends_with("_variance") => "variance",
            _ => "mean",
        };
        let attributes = [
            text("units", quantity.unit),
            text("long_name", quantity.long_name.clone()),
            text("coordinates", coordinates.join(" ")),
            text("cell_methods", format!("{MEAN_TIME}: {method}")),
            text("comment", "weighted by the time between the samples"),
        ];
        let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
        add_to_group::<f32>(group, &quantity.name, &shape(grid), &chunks(grid), &attributes)?
            .put_values(&values, ..)?;
    }
    Ok(())
}

/// Scalar coordinate of the means.
const MEAN_TIME: &str = "mean_time";

/// Ends of their interval. The checker of CF wants bounds with a dimension that a scalar lacks.
const MEAN_START: &str = "mean_start";
const MEAN_END: &str = "mean_end";

/// Open file of the layout.
#[derive(Debug)]
pub(crate) struct FieldFile {
    path: PathBuf,
    file: File,
    dimensions: usize,
    fields: FieldsHeader,
}

impl FieldFile {
    /// Opens a file.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn open(path: &Path, (header, fields): (&Header, &FieldsHeader)) -> Result<Self, OutputError> {
        let (file, fields) = (open_file(path)?, fields.clone());
        Ok(Self { path: path.to_path_buf(), file, dimensions: header.dimensions, fields })
    }

    fn group(&self, grid: &FieldGrid) -> Result<Group<'_>, OutputError> {
        let name = result_name(&grid.name);
        let group = match grid.name.is_empty() {
            true => self.file.root(),
            false => self.file.group(&name).map_err(read_error(&self.path))?,
        };
        group.ok_or_else(|| self.damaged(&format!("has no group `{name}`")))
    }

    fn damaged(&self, what: &str) -> OutputError {
        OutputError::Damaged { path: self.path.clone(), what: what.to_owned() }
    }

    fn values<T: Stored>(
        &self,
        group: &Group<'_>,
        name: &str,
        place: (Vec<usize>, Vec<usize>),
    ) -> Result<Vec<T>, OutputError> {
        let variable = group.variable(name);
        let variable = variable.ok_or_else(|| self.damaged(&format!("has no variable `{name}`")))?;
        variable.get_values(place).map_err(read_error(&self.path))
    }

    /// Returns the number of times.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn times(&self) -> Result<usize, OutputError> {
        let Some(grid) = self.fields.grids.first() else { return Ok(0) };
        Ok(self.group(grid)?.dimension("time").map_or(0, |time| time.len()))
    }

    /// Returns the fields at the time `index`.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when they cannot be read.
    pub(crate) fn snapshot(&self, index: usize) -> Result<FieldSnapshot, OutputError> {
        let mut snapshot = FieldSnapshot::default();
        for grid in &self.fields.grids {
            let group = self.group(grid)?;
            snapshot.time = self.values(&group, "time", (vec![index], vec![1]))?[0];
            snapshot.step = self.values::<i64>(&group, "step", (vec![index], vec![1]))?[0] as u64;
            let at: Vec<usize> = std::iter::once(index).chain(grid.axes.iter().map(|_| 0)).collect();
            let extent: Vec<usize> = std::iter::once(1).chain(counts(grid)).collect();
            let columns = quantities(self.dimensions, self.fields.tagged);
            let columns = columns
                .iter()
                .map(|quantity| self.values(&group, &quantity.name, (at.clone(), extent.clone())));
            let skipped = usize::from(!self.fields.has_moving_walls);
            snapshot.grids.push(GridValues {
                columns: columns.collect::<Result<_, _>>()?,
                solid: self.values(&group, "solid", (at[skipped..].to_vec(), extent[skipped..].to_vec()))?,
            });
        }
        Ok(snapshot)
    }

    /// Returns the means; None without any.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when they cannot be read.
    pub(crate) fn means(&self) -> Result<Option<FieldMeans>, OutputError> {
        let mut read = FieldMeans::default();
        for grid in &self.fields.grids {
            let group = self.group(grid)?;
            if group.variable(MEAN_END).is_none() {
                return Ok(None);
            }
            let end = |name: &str| -> Result<f64, OutputError> {
                Ok(self.values(&group, name, (Vec::new(), Vec::new()))?[0])
            };
            read.covered = (end(MEAN_START)?, end(MEAN_END)?);
            let place = (vec![0; grid.axes.len()], counts(grid));
            let column = |quantity: &Quantity| {
                let values = self.values::<f32>(&group, &quantity.name, place.clone())?;
                Ok(values.into_iter().map(f64::from).collect())
            };
            let columns = means(self.dimensions, self.fields.tagged);
            let columns = columns.iter().map(column).collect::<Result<_, OutputError>>()?;
            read.grids.push(columns);
        }
        Ok(Some(read))
    }
}
