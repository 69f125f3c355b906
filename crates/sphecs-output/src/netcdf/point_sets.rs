//! Point clouds over time in the layout of VTKHDF 2, an HDF5 file for VTK and ParaView.
//!
//! ```text
//! /VTKHDF            Version = [2, 0], Type = "UnstructuredGrid"
//!   Points           f64 (point, 3)                  points of all frames, one after another
//!   PointData/…      (point) or (point, 3)
//!   Types            u8 (point)                      1: a vertex for each point
//!   Connectivity     i64 (largest number of points)  0, 1, 2, … for all frames
//!   Offsets          i64 (points + frames)           0, 1, 2, … for each frame
//!   NumberOfPoints NumberOfCells NumberOfConnectivityIds   i64 (frame)
//!   Steps            NSteps                          if there are times
//!     Values         f64 (frame), s
//!     PointOffsets … PointDataOffsets/…              where a frame begins
//! ```
//!
//! Arrays that are constant have no chunks, only a fill value, so that they take no space.

use std::path::Path;

use ::netcdf::{FileMut, GroupMut};

use super::file::{Stored, WriteError, add_to_group, write_file};
use super::layout::put_header;
use crate::error::OutputError;
use crate::header::Header;

/// Name of the column of the positions.
pub(crate) const POINTS: &str = "Points";

/// Largest number of points in a chunk.
const CHUNK: usize = 1 << 15;

/// Cell with one point.
const VERTEX: u8 = 1;

const ROOT: &str = "VTKHDF";

/// Points of some times.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointSet {
    /// Times, s; empty for points without time.
    pub(crate) times: Vec<f64>,
    /// Number of points at each time, or the single one.
    pub(crate) counts: Vec<usize>,
    /// Arrays of equal numbers.
    pub(crate) constants: Vec<(&'static str, f32)>,
}

/// Values of the points at one time.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct PointColumn {
    /// Name; [`POINTS`] for the positions, which come first.
    pub(crate) name: &'static str,
    /// Numbers for each point, 1 or 3.
    pub(crate) components: usize,
    /// Values, point by point.
    pub(crate) values: PointValues,
}

/// Numbers of a column.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum PointValues {
    F64(Vec<f64>),
    F32(Vec<f32>),
    U32(Vec<u32>),
    U16(Vec<u16>),
    U8(Vec<u8>),
}

/// Writes a file; `columns` returns the values at each time in their order, always the same
/// columns.
///
/// # Errors
/// [`OutputError`] of a time, or with the path and the cause.
pub(crate) fn write(
    path: &Path,
    header: &Header,
    set: &PointSet,
    mut columns: impl FnMut(usize) -> Result<Vec<PointColumn>, OutputError>,
) -> Result<(), OutputError> {
    write_file(path, |file| {
        put_header(file, header, "particles for VTK")?;
        define(file, set)?;
        let mut start = 0;
        for (index, &count) in set.counts.iter().enumerate() {
            let columns = columns(index).map_err(WriteError::Source)?;
            for column in &columns {
                if index == 0 {
                    add_column(file, set, column)?;
                }
                put_column(file, column, start, count)?;
            }
            start += count;
        }
        Ok(())
    })
}

fn chunk_of(set: &PointSet) -> usize {
    // Chunks of about a frame, because a chunk that two frames share is compressed twice.
    set.counts.iter().max().map_or(1, |&count| count.clamp(1, CHUNK))
}

fn group<'f>(file: &'f mut FileMut, name: &str) -> Result<GroupMut<'f>, ::netcdf::Error> {
    file.group_mut(name)?.ok_or_else(|| ::netcdf::Error::NotFound(name.to_owned()))
}

fn define(file: &mut FileMut, set: &PointSet) -> Result<(), ::netcdf::Error> {
    let [total, largest] = [set.counts.iter().sum::<usize>(), set.counts.iter().copied().max().unwrap_or(0)];
    let frames = set.counts.len();
    let chunk = [chunk_of(set)];
    let mut root = file.add_group(ROOT)?;
    root.add_attribute("Version", vec![2_i64, 0])?;
    root.add_attribute("Type", "UnstructuredGrid")?;
    for (name, length) in [
        ("frame", frames),
        ("topology", 1),
        ("point", total),
        ("component", 3),
        ("connection", largest),
        ("offset", total + frames),
    ] {
        root.add_dimension(name, length)?;
    }
    let counts: Vec<i64> = set.counts.iter().map(|&count| count as i64).collect();
    for name in ["NumberOfPoints", "NumberOfCells", "NumberOfConnectivityIds"] {
        add_to_group::<i64>(&mut root, name, &["frame"], &[frames], &[])?.put_values(&counts, ..)?;
    }
    let numbers: Vec<i64> = (0..largest as i64).collect();
    add_to_group::<i64>(&mut root, "Connectivity", &["connection"], &[largest.min(CHUNK)], &[])?
        .put_values(&numbers, ..)?;
    add_to_group::<u8>(&mut root, "Types", &["point"], &chunk, &[])?.set_fill_value(VERTEX)?;
    let numbers: Vec<i64> = (0..=largest as i64).collect();
    let mut offsets = add_to_group::<i64>(&mut root, "Offsets", &["offset"], &chunk, &[])?;
    let mut start = 0;
    for &count in &set.counts {
        offsets.put_values(&numbers[..=count], ([start], [count + 1]))?;
        start += count + 1;
    }
    let mut data = root.add_group("PointData")?;
    for (name, value) in &set.constants {
        add_to_group::<f32>(&mut data, name, &["point"], &chunk, &[])?.set_fill_value(*value)?;
    }
    if set.times.is_empty() { Ok(()) } else { define_steps(&mut root, set) }
}

/// Returns the index of the first point of each time.
fn starts(set: &PointSet) -> Vec<i64> {
    let sums = set.counts.iter().scan(0, |sum, &count| {
        let start = *sum;
        *sum += count as i64;
        Some(start)
    });
    sums.collect()
}

fn define_steps(root: &mut GroupMut<'_>, set: &PointSet) -> Result<(), ::netcdf::Error> {
    let frames = set.times.len();
    let starts = starts(set);
    let mut steps = root.add_group("Steps")?;
    steps.add_attribute("NSteps", frames as i64)?;
    add_to_group::<f64>(&mut steps, "Values", &["frame"], &[frames], &[])?.put_values(&set.times, ..)?;
    // The reader adds the offset of the part to that of the cells where it reads `Offsets`.
    let parts: Vec<i64> = (0..frames as i64).collect();
    for (name, values) in
        [("PartOffsets", &parts), ("NumberOfParts", &vec![1; frames]), ("PointOffsets", &starts)]
    {
        add_to_group::<i64>(&mut steps, name, &["frame"], &[frames], &[])?.put_values(values, ..)?;
    }
    for (name, values) in [("CellOffsets", &starts), ("ConnectivityIdOffsets", &vec![0; frames])] {
        add_to_group::<i64>(&mut steps, name, &["frame", "topology"], &[frames, 1], &[])?
            .put_values(values, ..)?;
    }
    let mut offsets = steps.add_group("PointDataOffsets")?;
    for (name, _) in &set.constants {
        add_to_group::<i64>(&mut offsets, name, &["frame"], &[frames], &[])?.put_values(&starts, ..)?;
    }
    Ok(())
}

/// Returns the group of a column.
fn place_of(column: &PointColumn) -> String {
    if column.name == POINTS { ROOT.to_owned() } else { format!("{ROOT}/PointData") }
}

fn add_column(file: &mut FileMut, set: &PointSet, column: &PointColumn) -> Result<(), ::netcdf::Error> {
    let all = (["point", "component"], [chunk_of(set), 3]);
    let rank = if column.components == 1 { 1 } else { 2 };
    let (shape, chunks) = (&all.0[..rank], &all.1[..rank]);
    let mut to = group(file, &place_of(column))?;
    match &column.values {
        PointValues::F64(_) => add_to_group::<f64>(&mut to, column.name, shape, chunks, &[])?,
        PointValues::F32(_) => add_to_group::<f32>(&mut to, column.name, shape, chunks, &[])?,
        PointValues::U32(_) => add_to_group::<u32>(&mut to, column.name, shape, chunks, &[])?,
        PointValues::U16(_) => add_to_group::<u16>(&mut to, column.name, shape, chunks, &[])?,
        PointValues::U8(_) => add_to_group::<u8>(&mut to, column.name, shape, chunks, &[])?,
    };
    if set.times.is_empty() || column.name == POINTS {
        return Ok(());
    }
    let mut to = group(file, &format!("{ROOT}/Steps/PointDataOffsets"))?;
    let frames = set.times.len();
    add_to_group::<i64>(&mut to, column.name, &["frame"], &[frames], &[])?.put_values(&starts(set), ..)
}

fn put_column(
    file: &mut FileMut,
    column: &PointColumn,
    start: usize,
    count: usize,
) -> Result<(), ::netcdf::Error> {
    fn put<T: Stored>(
        to: &mut GroupMut<'_>,
        column: &PointColumn,
        values: &[T],
        (start, count): (usize, usize),
    ) -> Result<(), ::netcdf::Error> {
        let missing = || ::netcdf::Error::NotFound(column.name.to_owned());
        let mut variable = to.variable_mut(column.name).ok_or_else(missing)?;
        match column.components {
            1 => variable.put_values(values, ([start], [count])),
            components => variable.put_values(values, ([start, 0], [count, components])),
        }
    }
    if count == 0 {
        return Ok(());
    }
    let mut to = group(file, &place_of(column))?;
    let range = (start, count);
    match &column.values {
        PointValues::F64(values) => put(&mut to, column, values, range),
        PointValues::F32(values) => put(&mut to, column, values, range),
        PointValues::U32(values) => put(&mut to, column, values, range),
        PointValues::U16(values) => put(&mut to, column, values, range),
        PointValues::U8(values) => put(&mut to, column, values, range),
    }
}
