//! Layout of `walls.nc`, and of its times in the journal.
//!
//! ```text
//! dimensions  time (unlimited), point
//! x y (z) normal_x …    f64 (point); f32 (time, point) if the walls move
//! area wall_part (curve arc_length)          (point), the place at the start
//! pressure wall_shear_stress_x … y_plus      f32 (time, point)   NaN: no fluid
//! pressure_mean … oscillatory_shear_index    f32 (point), with `cell_methods`
//! step        i64 (time)
//! ```

use std::path::{Path, PathBuf};
use std::sync::Arc;

use ::netcdf::{AttributeValue, File, FileMut};
use glam::DVec3;

use super::file::{Stored, WriteError, add_variable, open_file, read_error, write_file};
use super::layout::{AXES, TIME_ATTRIBUTES, put_header};
use crate::error::OutputError;
use crate::header::{Header, WallsHeader};
use crate::walls::WallQuantity;
use crate::walls::at_time::{WallSnapshot, quantities};
use crate::walls::over_time::{WallMeans, means};
use sphecs_scene::result_name::result_name;
use sphecs_scene::wall_points::WallPoint;

/// Largest number of points in a chunk: 1 MiB of singles.
const CHUNK: usize = 1 << 18;

/// Names of the place at the start, if the walls move.
const AT_START: &str = "_at_start";

/// Writes a file of the quantities at some times, which `next` returns one by one.
///
/// # Errors
/// [`OutputError`] of a time, or with the path and the cause.
pub(crate) fn write(
    path: &Path,
    (header, walls, points): (&Header, &WallsHeader, &[WallPoint]),
    times: usize,
    means: Option<&WallMeans>,
    mut next: impl FnMut(usize) -> Result<WallSnapshot, OutputError>,
) -> Result<(), OutputError> {
    write_file(path, |file| {
        put_header(file, header, "pressure and shear stress at the walls")?;
        file.add_unlimited_dimension("time")?;
        file.add_dimension("point", points.len())?;
        let mut attributes = TIME_ATTRIBUTES.map(|(name, value)| text(name, value)).to_vec();
        attributes.push(text("long_name", "time since the start of the run"));
        add_variable::<f64>(file, "time", &["time"], &[512], &attributes)?;
        let attributes = [text("units", "1"), text("long_name", "steps done")];
        add_variable::<i64>(file, "step", &["time"], &[512], &attributes)?;
        put_points(file, (header, walls), points)?;
        let chunks = [1, points.len().clamp(1, CHUNK)];
        for quantity in quantities(header.dimensions, walls.moves) {
            let attributes = attributes_of(&quantity, header.dimensions);
            add_variable::<f32>(file, &quantity.name, &["time", "point"], &chunks, &attributes)?;
        }
        if let Some(means) = means {
            put_means(file, (header, walls), means)?;
        }
        for index in 0..times {
            let snapshot = next(index).map_err(WriteError::Source)?;
            put(file, "time", &[snapshot.time], (vec![index], vec![1]))?;
            put(file, "step", &[snapshot.step as i64], (vec![index], vec![1]))?;
            for (quantity, column) in quantities(header.dimensions, walls.moves).iter().zip(&snapshot.columns)
            {
                put(file, &quantity.name, column, (vec![index, 0], vec![1, points.len()]))?;
            }
        }
        Ok(())
    })
}

fn text(name: &'static str, value: impl Into<String>) -> (&'static str, AttributeValue) {
    (name, AttributeValue::from(value.into()))
}

fn put<T: Stored>(
    file: &mut FileMut,
    name: &str,
    values: &[T],
    place: (Vec<usize>, Vec<usize>),
) -> Result<(), ::netcdf::Error> {
    let missing = || ::netcdf::Error::NotFound(name.to_owned());
    file.variable_mut(name).ok_or_else(missing)?.put_values(values, place)
}

fn attributes_of(quantity: &WallQuantity, dimensions: usize) -> Vec<(&'static str, AttributeValue)> {
    let mut attributes = vec![text("units", quantity.unit), text("long_name", quantity.long_name.clone())];
    if !AXES.contains(&quantity.name.as_str()) {
        attributes.push(text("coordinates", AXES[..dimensions].join(" ")));
    }
    attributes
}

/// Defines and writes what does not depend on time: the points at the start.
fn put_points(
    file: &mut FileMut,
    (header, walls): (&Header, &WallsHeader),
    points: &[WallPoint],
) -> Result<(), ::netcdf::Error> {
    let (suffix, when) = if walls.moves { (AT_START, " at the start") } else { ("", "") };
    let mut add = |name: &str, unit: &str, long_name: &str, values: Vec<f64>| {
        let attributes = [text("units", unit), text("long_name", long_name)];
        add_variable::<f64>(file, name, &["point"], &[points.len().clamp(1, CHUNK)], &attributes)?
            .put_values(&values, ..)
    };
    for (axis, name) in AXES.iter().enumerate().take(header.dimensions) {
        let along = |of: fn(&WallPoint) -> DVec3| points.iter().map(|point| of(point)[axis]).collect();
        let long_name = format!("{name} coordinate{when}");
        add(&format!("{name}{suffix}"), "m", &long_name, along(|point| point.position))?;
        let long_name = format!("unit normal of the wall along {name}{when}, into the fluid");
        add(&format!("normal_{name}{suffix}"), "1", &long_name, along(|point| point.normal))?;
    }
    let unit = if header.dimensions == 2 { "m" } else { "m2" };
    let areas = points.iter().map(|point| point.area).collect();
    add("area", unit, "area of the wall that the point stands for, per depth in 2D", areas)?;
    if header.dimensions == 2 {
        let lengths = points.iter().map(|point| point.arc_length).collect();
        add("arc_length", "m", "distance along the curve of the wall", lengths)?;
    }
    let chunks = [points.len().clamp(1, CHUNK)];
    let names: Vec<String> = header.wall_parts.iter().map(|name| result_name(name)).collect();
    let flags: Vec<u16> = (0..names.len() as u16).collect();
    let attributes = [
        text("long_name", "part of the walls"),
        ("flag_values", AttributeValue::from(flags)),
        text("flag_meanings", names.join(" ")),
    ];
    let parts: Vec<u16> = points.iter().map(|point| point.part).collect();
    add_variable::<u16>(file, "wall_part", &["point"], &chunks, &attributes)?.put_values(&parts, ..)?;
    if header.dimensions == 2 {
        let attributes = [text("long_name", "number of the curve of the wall")];
        let curves: Vec<u32> = points.iter().map(|point| point.curve).collect();
        add_variable::<u32>(file, "curve", &["point"], &chunks, &attributes)?.put_values(&curves, ..)?;
    }
    Ok(())
}

/// Defines and writes the means, and the interval that they cover.
fn put_means(
    file: &mut FileMut,
    (header, walls): (&Header, &WallsHeader),
    of: &WallMeans,
) -> Result<(), ::netcdf::Error> {
    let (from, to) = of.covered;
    for (name, value, long_name) in [
        (MEAN_TIME, 0.5 * (from + to), "middle of the interval of the means"),
        (MEAN_START, from, "beginning of the interval of the means"),
        (MEAN_END, to, "end of the interval of the means"),
    ] {
        let attributes = [text("units", "s"), text("long_name", long_name)];
        add_variable::<f64>(file, name, &[], &[], &attributes)?.put_value(value, ())?;
    }
    let suffix = if walls.moves { AT_START } else { "" };
    let place = AXES[..header.dimensions].iter().map(|axis| format!("{axis}{suffix}"));
    let coordinates = place.chain([MEAN_TIME.to_owned()]).collect::<Vec<_>>().join(" ");
    for (quantity, values) in means(header.dimensions).iter().zip(&of.columns) {
        let attributes = [
            text("units", quantity.unit),
            text("long_name", quantity.long_name.clone()),
            text("coordinates", coordinates.clone()),
            text("cell_methods", format!("{MEAN_TIME}: {}", quantity.method)),
            text("comment", "weighted by the time between the samples"),
        ];
        let values: Vec<f32> = values.iter().map(|&value| value as f32).collect();
        add_variable::<f32>(file, &quantity.name, &["point"], &[values.len().clamp(1, CHUNK)], &attributes)?
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
pub(crate) struct WallFile {
    path: PathBuf,
    file: File,
    dimensions: usize,
    moves: bool,
}

impl WallFile {
    /// Opens a file.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn open(path: &Path, (header, walls): (&Header, &WallsHeader)) -> Result<Self, OutputError> {
        let file = open_file(path)?;
        Ok(Self { path: path.to_path_buf(), file, dimensions: header.dimensions, moves: walls.moves })
    }

    fn values<T: Stored>(&self, name: &str, place: Option<(usize, usize)>) -> Result<Vec<T>, OutputError> {
        let damaged =
            || OutputError::Damaged { path: self.path.clone(), what: format!("has no variable `{name}`") };
        let variable = self.file.variable(name).ok_or_else(damaged)?;
        let values = match place {
            Some((index, count)) => variable.get_values((vec![index, 0], vec![1, count])),
            None => variable.get_values(..),
        };
        values.map_err(read_error(&self.path))
    }

    /// Returns the number of times.
    pub(crate) fn times(&self) -> usize {
        self.file.dimension("time").map_or(0, |time| time.len())
    }

    /// Returns the points.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when they cannot be read.
    pub(crate) fn points(&self) -> Result<Arc<Vec<WallPoint>>, OutputError> {
        let suffix = if self.moves { AT_START } else { "" };
        let (area, part): (Vec<f64>, Vec<u16>) =
            (self.values("area", None)?, self.values("wall_part", None)?);
        let (mut curve, mut length) = (vec![0_u32; area.len()], vec![0.0; area.len()]);
        if self.dimensions == 2 {
            (curve, length) = (self.values("curve", None)?, self.values("arc_length", None)?);
        }
        let mut points: Vec<WallPoint> = (0..area.len())
            .map(|index| WallPoint {
                position: DVec3::ZERO,
                normal: DVec3::ZERO,
                area: area[index],
                part: part[index],
                curve: curve[index],
                arc_length: length[index],
            })
            .collect();
        for (axis, name) in AXES.iter().enumerate().take(self.dimensions) {
            let place: Vec<f64> = self.values(&format!("{name}{suffix}"), None)?;
            let normal: Vec<f64> = self.values(&format!("normal_{name}{suffix}"), None)?;
            for (point, (at, normal)) in points.iter_mut().zip(place.into_iter().zip(normal)) {
                (point.position[axis], point.normal[axis]) = (at, normal);
            }
        }
        Ok(Arc::new(points))
    }

    /// Returns the quantities at the time `index`.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when they cannot be read.
    pub(crate) fn snapshot(&self, index: usize) -> Result<WallSnapshot, OutputError> {
        let points = self.points()?;
        let (times, steps): (Vec<f64>, Vec<i64>) = (self.values("time", None)?, self.values("step", None)?);
        let of = |quantity: &WallQuantity| self.values(&quantity.name, Some((index, points.len())));
        let columns = quantities(self.dimensions, self.moves).iter().map(of).collect::<Result<_, _>>()?;
        Ok(WallSnapshot { time: times[index], step: steps[index] as u64, points, columns })
    }

    /// Returns the means; None without any.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when they cannot be read.
    pub(crate) fn means(&self) -> Result<Option<WallMeans>, OutputError> {
        if self.file.variable(MEAN_END).is_none() {
            return Ok(None);
        }
        let end = |name: &str| -> Result<f64, OutputError> { Ok(self.values(name, None)?[0]) };
        let column = |quantity: &WallQuantity| -> Result<Vec<f64>, OutputError> {
            Ok(self.values::<f32>(&quantity.name, None)?.into_iter().map(f64::from).collect())
        };
        Ok(Some(WallMeans {
            covered: (end(MEAN_START)?, end(MEAN_END)?),
            points: self.points()?,
            columns: means(self.dimensions).iter().map(column).collect::<Result<_, _>>()?,
        }))
    }
}
