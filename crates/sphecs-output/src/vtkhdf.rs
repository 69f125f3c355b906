//! Particles of all frames in one VTKHDF file, which ParaView and VTK open as it is.
//!
//! `particles.vtkhdf` is an unstructured grid over time with one vertex cell for each particle. It
//! has the particles that flow and those of walls that move, at the places of each frame. Walls at
//! rest are in a second file without time, `particles_walls.vtkhdf`. They have no pressure, which
//! would spoil the interpolation of ParaView's SPH filters next to them.
//!
//! # Alternatives considered
//! - A group in `particles.nc`, or a file of virtual datasets into it, would copy nothing. But
//!   slots of the reservoir have no position (NaN), which filters that sort points do not expect,
//!   and virtual datasets cannot leave out slots that lie scattered.
//! - A `PartitionedDataSetCollection` with the walls as a second block, stored once: the reader of
//!   VTK 9.7 shows its first frame at every time.
//!
//! The file is netCDF-4, too, so that the same library writes it; VTK ignores the dimensions.

use std::path::{Path, PathBuf};

use super::error::OutputError;
use super::frame::Frame;
use super::netcdf::point_sets::{self, PointColumn, PointSet, PointValues};
use super::results::Results;

/// Files and numbers of an export.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct VtkHdfExport {
    /// Walls at rest; None without any.
    pub walls: Option<PathBuf>,
    /// Frames.
    pub frames: usize,
}

/// Writes every `every`-th frame of a run into a file, and its walls at rest into another one.
/// Calls `done` with the number of frames written and of all.
///
/// # Errors
/// [`OutputError`] when the run has no frames or no particles, or a file cannot be read or written.
pub fn export_vtkhdf(
    results: &Results,
    target: &Path,
    every: usize,
    mut done: impl FnMut(usize, usize),
) -> Result<VtkHdfExport, OutputError> {
    if results.is_empty() {
        return Err(results.no_frames());
    }
    let frames: Vec<usize> = (0..results.len()).step_by(every.max(1)).collect();
    let times = results.times();
    let mut set = PointSet {
        times: frames.iter().map(|&index| times[index]).collect(),
        counts: Vec::new(),
        constants: results.header.particle_constants().to_vec(),
    };
    for &index in &frames {
        set.counts.push(results.occupancy(index, false)?.present().len());
    }
    if set.counts.iter().all(|&count| count == 0) {
        return Err(OutputError::Request(format!(
            "`{}`: has no particle that flows or moves in its frames",
            results.folder.display()
        )));
    }
    point_sets::write(target, &results.header, &set, |order| {
        let frame = results.frame(frames[order])?;
        let columns = moving_columns(&frame, &frame.present());
        done(order + 1, frames.len());
        Ok(columns)
    })?;
    Ok(VtkHdfExport { walls: write_walls(results, target)?, frames: frames.len() })
}

/// Writes the walls at rest, or removes those of an earlier export where there are none.
fn write_walls(results: &Results, target: &Path) -> Result<Option<PathBuf>, OutputError> {
    let mut name = target.file_stem().unwrap_or_default().to_os_string();
    name.push("_walls.vtkhdf");
    let path = target.with_file_name(name);
    let frame = results.frame(0)?;
    let walls: Vec<usize> = frame.fixed_walls().collect();
    if walls.is_empty() {
        return match std::fs::remove_file(&path) {
            Err(cause) if cause.kind() != std::io::ErrorKind::NotFound => {
                Err(OutputError::io(&path, "remove")(cause))
            }
            _ => Ok(None),
        };
    }
    let set = PointSet {
        times: Vec::new(),
        counts: vec![walls.len()],
        constants: results.header.particle_constants().to_vec(),
    };
    point_sets::write(&path, &results.header, &set, |_| {
        Ok(vec![
            positions(&frame, &walls),
            column("wall_part", PointValues::U16(pick(&frame.patch, &walls))),
            column("zone", PointValues::U8(pick(&frame.zone, &walls))),
            column("particle_id", PointValues::U32(walls.iter().map(|&slot| slot as u32).collect())),
        ])
    })?;
    Ok(Some(path))
}

/// Returns the columns of the particles that flow or move.
fn moving_columns(frame: &Frame, slots: &[usize]) -> Vec<PointColumn> {
    let velocity = slots.iter().flat_map(|&slot| [0, 1, 2].map(|axis| frame.velocity[axis][slot])).collect();
    vec![
        positions(frame, slots),
        PointColumn { name: "velocity", components: 3, values: PointValues::F32(velocity) },
        column("density", PointValues::F32(pick(&frame.density, slots))),
        column("pressure", PointValues::F32(pick(&frame.pressure, slots))),
        column("tag", PointValues::F32(pick(&frame.tag, slots))),
        column("zone", PointValues::U8(pick(&frame.zone, slots))),
        column("particle_id", PointValues::U32(slots.iter().map(|&slot| slot as u32).collect())),
        column("passage", PointValues::U32(pick(&frame.passage, slots))),
    ]
}

fn positions(frame: &Frame, slots: &[usize]) -> PointColumn {
    let places = slots.iter().flat_map(|&slot| [0, 1, 2].map(|axis| frame.position[axis][slot])).collect();
    PointColumn { name: point_sets::POINTS, components: 3, values: PointValues::F64(places) }
}

fn column(name: &'static str, values: PointValues) -> PointColumn {
    PointColumn { name, components: 1, values }
}

fn pick<T: Copy>(column: &[T], slots: &[usize]) -> Vec<T> {
    slots.iter().map(|&slot| column[slot]).collect()
}
