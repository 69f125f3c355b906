//! Layout of `tracks.nc` and its writing, chunk by chunk.
//!
//! ```text
//! dimensions  trajectory, time                     featureType = trajectory
//! trajectory  i64 (trajectory), cf_role            passage · 10¹⁰ + particle_id, ascending
//! particle_id passage   u32 (trajectory)
//! time        f64 (time)
//! x y (z)     f64 (trajectory, time), m            NaN: not in the flow
//! u v (w) density pressure tag   f32 (trajectory, time)
//! zone        u8  (trajectory, time)               if there are others than fluid
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use ::netcdf::{AttributeValue, FileMut};
use rayon::iter::{IntoParallelIterator, ParallelIterator};

use super::chunks::Chunk;
use super::compression::Values;
use super::file::{WriteError, add_variable, write_file_with_chunks};
use super::layout::{AXES, TIME_ATTRIBUTES, VELOCITIES, put_header, zone_attributes};
use super::particles::FrameTime;
use crate::error::OutputError;
use crate::header::Header;
use crate::tracks::{Tile, Track, WindowShape};
use sphecs_core::particles::zone::Zone;

/// Content of the file, apart from the samples.
pub(crate) struct TracksContent<'a> {
    /// Times of the frames.
    pub(crate) times: &'a [FrameTime],
    /// Trajectories, ascending.
    pub(crate) tracks: &'a [Track],
    /// Zones of the samples.
    pub(crate) zones: &'a [Zone],
    /// Shape of the chunks.
    pub(crate) shape: &'a WindowShape,
    /// Every which frame of the run is in the file.
    pub(crate) every: usize,
}

impl TracksContent<'_> {
    fn has_zone(&self) -> bool {
        self.zones != [Zone::Fluid]
    }
}

/// Writes the file; `window` returns the blocks of trajectories with samples in a window of frames.
///
/// # Errors
/// [`OutputError`] of a window, or with the path and the cause.
pub(crate) fn write(
    path: &Path,
    header: &Header,
    content: &TracksContent<'_>,
    mut window: impl FnMut(usize) -> Result<BTreeMap<usize, Tile>, OutputError>,
) -> Result<(), OutputError> {
    let &WindowShape { block, frames } = content.shape;
    write_file_with_chunks(
        path,
        |file| Ok(define(file, header, content)?),
        |file| {
            let names: Vec<&str> =
                columns(None, header.dimensions, content.has_zone()).iter().map(|(name, _)| *name).collect();
            let variables = names.iter().map(|name| file.variable(name)).collect::<Result<Vec<_>, _>>()?;
            let order: Vec<u32> = (0..(block * frames) as u32).collect();
            for number in 0..content.times.len().div_ceil(frames) {
                let tiles = window(number).map_err(WriteError::Source)?;
                // HDF5 lets one thread in at a time, so the threads only compress.
                let compressed: Vec<(usize, Vec<Chunk>)> = tiles
                    .into_par_iter()
                    .map(|(index, tile)| {
                        let columns = columns(Some(&tile), header.dimensions, content.has_zone());
                        let chunk = |(_, values): &(&str, Values<'_>)| {
                            Chunk::compressed(&values.shuffled(&order, order.len()))
                        };
                        (index, columns.iter().map(chunk).collect())
                    })
                    .collect();
                for (index, chunks) in &compressed {
                    for (variable, chunk) in variables.iter().zip(chunks) {
                        variable.write(index * block, number * frames, chunk)?;
                    }
                }
            }
            Ok(())
        },
    )
}

/// Returns the variables over (trajectory, time) with their values in a tile, or without any.
fn columns(tile: Option<&Tile>, dimensions: usize, has_zone: bool) -> Vec<(&'static str, Values<'_>)> {
    let mut columns = Vec::new();
    for axis in 0..dimensions {
        columns.push((AXES[axis], Values::F64(tile.map_or(&[], |tile| &tile.position[axis]))));
        columns.push((VELOCITIES[axis], Values::F32(tile.map_or(&[], |tile| &tile.velocity[axis]))));
    }
    columns.extend([
        ("density", Values::F32(tile.map_or(&[], |tile| &tile.density))),
        ("pressure", Values::F32(tile.map_or(&[], |tile| &tile.pressure))),
        ("tag", Values::F32(tile.map_or(&[], |tile| &tile.tag))),
    ]);
    if has_zone {
        columns.push(("zone", Values::U8(tile.map_or(&[], |tile| &tile.zone))));
    }
    columns
}

fn text(name: &'static str, value: impl Into<String>) -> (&'static str, AttributeValue) {
    (name, AttributeValue::from(value.into()))
}

fn define(file: &mut FileMut, header: &Header, content: &TracksContent<'_>) -> Result<(), ::netcdf::Error> {
    put_header(file, header, "particles as trajectories")?;
    file.add_attribute("featureType", "trajectory")?;
    file.add_attribute("every_frame", content.every as i32)?;
    let zones: Vec<&str> = content.zones.iter().map(|zone| zone.name()).collect();
    file.add_attribute("zones", zones.join(" "))?;
    file.add_dimension("trajectory", content.tracks.len())?;
    file.add_dimension("time", content.times.len())?;
    define_trajectories(file, content.tracks)?;
    define_times(file, content.times)?;

    let shape = ["trajectory", "time"];
    let chunks = [content.shape.block, content.shape.frames];
    for axis in 0..header.dimensions {
        let name = AXES[axis];
        // With `axis` readers take the coordinates for a map.
        let attributes = [text("units", "m"), text("long_name", format!("{name} coordinate"))];
        add_variable::<f64>(file, name, &shape, &chunks, &attributes)?;
    }
    let coordinates = || text("coordinates", format!("{} particle_id passage", header.axes().join(" ")));
    let described = |unit: &'static str, long_name: String| {
        [text("units", unit), text("long_name", long_name), coordinates()]
    };
    for axis in 0..header.dimensions {
        let attributes = described("m s-1", format!("velocity along {}", AXES[axis]));
        add_variable::<f32>(file, VELOCITIES[axis], &shape, &chunks, &attributes)?;
    }
    for (name, unit, long_name) in super::layout::SCALARS {
        add_variable::<f32>(file, name, &shape, &chunks, &described(unit, long_name.to_owned()))?;
    }
    if content.has_zone() {
        let mut attributes = zone_attributes();
        attributes.push(coordinates());
        // Chunks that are not written read as 255, the default of the library and the number of an
        // absent particle. With `_FillValue` xarray would turn the numbers into floats.
        add_variable::<u8>(file, "zone", &shape, &chunks, &attributes)?;
    }
    Ok(())
}

fn define_trajectories(file: &mut FileMut, tracks: &[Track]) -> Result<(), ::netcdf::Error> {
    let chunk = [tracks.len().min(1 << 16)];
    let mut attributes = vec![
        text("units", "1"),
        text("long_name", "number of the trajectory"),
        text("cf_role", "trajectory_id"),
        text(
            "comment",
            "passage * 10000000000 + particle_id: a particle that enters again is another piece of fluid",
        ),
    ];
    let numbers: Vec<i64> = tracks.iter().map(|track| track.number as i64).collect();
    add_variable::<i64>(file, "trajectory", &["trajectory"], &chunk, &attributes)?
        .put_values(&numbers, ..)?;
    attributes = vec![text("units", "1"), text("long_name", "number of the particle in the run")];
    let numbers: Vec<u32> = tracks.iter().map(Track::particle_id).collect();
    add_variable::<u32>(file, "particle_id", &["trajectory"], &chunk, &attributes)?
        .put_values(&numbers, ..)?;
    attributes = vec![text("units", "1"), text("long_name", super::layout::PASSAGE_MEANING)];
    let numbers: Vec<u32> = tracks.iter().map(Track::passage).collect();
    add_variable::<u32>(file, "passage", &["trajectory"], &chunk, &attributes)?.put_values(&numbers, ..)
}

fn define_times(file: &mut FileMut, times: &[FrameTime]) -> Result<(), ::netcdf::Error> {
    let chunk = [times.len().min(512)];
    let mut attributes = TIME_ATTRIBUTES.map(|(name, value)| text(name, value)).to_vec();
    attributes.push(text("long_name", "time since the start of the run"));
    let values: Vec<f64> = times.iter().map(|frame| frame.time).collect();
    add_variable::<f64>(file, "time", &["time"], &chunk, &attributes)?.put_values(&values, ..)
}
