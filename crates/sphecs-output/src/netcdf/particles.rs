//! Writing and reading of frames in NetCDF files with the [`layout`](super::layout).

use std::path::{Path, PathBuf};

use ::netcdf::{File, FileMut};

use super::chunks::ChunkError;
use super::compression::FrameChunks;
use super::file::{Stored, WriteError, open_file, read_error, write_file, write_file_with_chunks};
use super::layout::{AXES, VELOCITIES, define, put_walls};
use super::slots::{NO_PART, Slots};
use crate::error::OutputError;
use crate::frame::{ABSENT, Frame};
use crate::header::Header;
use sphecs_core::particles::zone::Zone;

/// Writes the walls of a run without a frame.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_walls(path: &Path, header: &Header, frame: &Frame) -> Result<(), OutputError> {
    let slots = Slots { walls: Slots::of(frame).walls, ..Slots::default() };
    write_file(path, |file| {
        define(file, header, &slots)?;
        Ok(put_walls(file, header, &slots, frame)?)
    })
}

/// Writes one frame without its walls, compressed by some threads.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_frame(
    path: &Path,
    header: &Header,
    frame: &Frame,
    threads: usize,
) -> Result<(), OutputError> {
    let slots = Slots::of(frame);
    let chunks = FrameChunks::of(frame, header.dimensions, &slots.particles, threads);
    write_chunks(path, header, &slots, &FrameTime::of(frame), &chunks)
}

/// Writes one frame without its walls, of which the chunks are given.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_chunks(
    path: &Path,
    header: &Header,
    slots: &Slots,
    time: &FrameTime,
    chunks: &FrameChunks,
) -> Result<(), OutputError> {
    write_file_with_chunks(
        path,
        |file| {
            define(file, header, slots)?;
            Ok(put_times(file, std::slice::from_ref(time))?)
        },
        |file| Ok(chunks.write(file, 0, slots.particles.len())?),
    )
}

/// Writes all frames of a run; `frame` is called for each of the `times` in their order, and
/// `slots` are those of the largest frame.
///
/// # Errors
/// [`OutputError`] of a frame, or with the path and the cause.
pub(crate) fn write_run(
    path: &Path,
    header: &Header,
    slots: &Slots,
    walls: &Frame,
    times: &[FrameTime],
    mut frame: impl FnMut(usize) -> Result<FrameChunks, OutputError>,
) -> Result<(), OutputError> {
    write_file_with_chunks(
        path,
        |file| {
            define(file, header, slots)?;
            put_walls(file, header, slots, walls)?;
            Ok(put_times(file, times)?)
        },
        |file| {
            (0..times.len()).try_for_each(|index| {
                let chunks = frame(index).map_err(WriteError::Source)?;
                Ok(chunks.write(file, index, slots.particles.len())?)
            })
        },
    )
}

/// Time of a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct FrameTime {
    /// Time, s.
    pub(crate) time: f64,
    /// Steps done.
    pub(crate) step: u64,
    /// Size of the last step, s.
    time_step: f64,
}

impl FrameTime {
    fn of(frame: &Frame) -> Self {
        Self { time: frame.time, step: frame.step, time_step: frame.time_step }
    }
}

fn put_times(file: &mut FileMut, times: &[FrameTime]) -> Result<(), ::netcdf::Error> {
    fn put<T: Stored>(file: &mut FileMut, name: &str, values: Vec<T>) -> Result<(), ::netcdf::Error> {
        let Some(mut variable) = file.variable_mut(name) else {
            return Err(::netcdf::Error::NotFound(name.to_owned()));
        };
        variable.put_values(&values, ([0], [values.len()]))
    }
    put(file, "step", times.iter().map(|frame| frame.step as i64).collect())?;
    put(file, "time_step", times.iter().map(|frame| frame.time_step).collect())?;
    put(file, "time", times.iter().map(|frame| frame.time).collect())
}

/// Open file of the layout.
#[derive(Debug)]
pub(crate) struct ParticleFile {
    path: PathBuf,
    file: File,
    dimensions: usize,
    /// Particles of the slots.
    pub(crate) slots: Slots,
    /// Times of its frames, s.
    pub(crate) times: Vec<f64>,
}

impl ParticleFile {
    /// Opens a file and reads its times and slots.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when the file has another layout.
    pub(crate) fn open(path: &Path) -> Result<Self, OutputError> {
        let file = open_file(path)?;
        let mut opened = Self {
            path: path.to_path_buf(),
            dimensions: if file.variable("z").is_some() { 3 } else { 2 },
            file,
            slots: Slots::default(),
            times: Vec::new(),
        };
        opened.times = opened.column("time")?;
        // A file with walls only has one unused slot.
        if !opened.times.is_empty() {
            opened.slots.particles = opened.column("particle_id")?;
            if opened.file.variable("moving_part").is_some() {
                opened.slots.moving_parts = opened.column("moving_part")?;
            }
        }
        if opened.file.dimension("wall").is_some() {
            opened.slots.walls = opened.column("wall_id")?;
        }
        Ok(opened)
    }

    fn column<T: Stored>(&self, name: &str) -> Result<Vec<T>, OutputError> {
        let variable = self.variable(name)?;
        variable.get_values(..).map_err(read_error(&self.path))
    }

    fn variable(&self, name: &str) -> Result<::netcdf::Variable<'_>, OutputError> {
        self.file.variable(name).ok_or_else(|| OutputError::Damaged {
            path: self.path.clone(),
            what: format!("has no variable `{name}`"),
        })
    }

    /// Returns a frame with the walls only; all other slots are absent.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when the walls cannot be read.
    pub(crate) fn walls(&self) -> Result<Frame, OutputError> {
        let mut frame = Frame::absent(self.slots.walls.last().map_or(0, |&last| last as usize + 1));
        if self.slots.walls.is_empty() {
            return Ok(frame);
        }
        for (axis, name) in AXES.iter().enumerate() {
            let values = if axis < self.dimensions {
                self.column(&format!("wall_{name}"))?
            } else {
                vec![0.0; self.slots.walls.len()]
            };
            place(&mut frame.position[axis], &self.slots.walls, &values);
        }
        place(&mut frame.patch, &self.slots.walls, &self.column("wall_part")?);
        let zones = vec![Zone::Wall as u8; self.slots.walls.len()];
        place(&mut frame.zone, &self.slots.walls, &zones);
        Ok(frame)
    }

    /// Returns the frame `index` with the walls, of which only position and part are known.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn frame(&self, index: usize, walls: &Frame) -> Result<Frame, OutputError> {
        let ids = &self.slots.particles;
        let mut frame = walls.clone();
        frame.resize(walls.len().max(self.slots.dense_len()));
        for axis in 0..self.dimensions {
            place(&mut frame.position[axis], ids, &self.row(AXES[axis], index)?);
            place(&mut frame.velocity[axis], ids, &self.row(VELOCITIES[axis], index)?);
        }
        place(&mut frame.density, ids, &self.row("density", index)?);
        place(&mut frame.pressure, ids, &self.row("pressure", index)?);
        place(&mut frame.tag, ids, &self.row("tag", index)?);
        place(&mut frame.zone, ids, &self.row("zone", index)?);
        place(&mut frame.passage, ids, &self.row("passage", index)?);
        self.place_moving_walls(&mut frame);
        if self.dimensions == 2 {
            for slot in ids.iter().map(|&slot| slot as usize) {
                // It is zero, or NaN for slots without a position.
                frame.position[2][slot] = 0.0 * frame.position[0][slot] + 0.0;
                frame.velocity[2][slot] = 0.0 * frame.velocity[0][slot] + 0.0;
            }
        }
        let FrameTime { time, step, time_step } = self.frame_time(index)?;
        Ok(Frame { time, step, time_step, ..frame })
    }

    /// Returns the frame `index` with zones and passages only, on request with positions.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn occupancy(&self, index: usize, with_positions: bool) -> Result<Frame, OutputError> {
        let ids = &self.slots.particles;
        let mut frame = Frame::absent(self.slots.dense_len());
        for axis in 0..self.dimensions * usize::from(with_positions) {
            place(&mut frame.position[axis], ids, &self.row(AXES[axis], index)?);
        }
        if self.dimensions == 2 {
            frame.position[2].fill(0.0);
        }
        place(&mut frame.zone, ids, &self.row("zone", index)?);
        place(&mut frame.passage, ids, &self.row("passage", index)?);
        self.place_moving_walls(&mut frame);
        Ok(frame)
    }

    /// Sets the wall parts of the particles of walls that move, and their numbers.
    fn place_moving_walls(&self, frame: &mut Frame) {
        let moving = self.slots.particles.iter().zip(&self.slots.moving_parts);
        let mut moving = moving.filter(|(_, part)| **part != NO_PART);
        let Some((&first, &part)) = moving.next() else { return };
        frame.patch[first as usize] = part;
        frame.moving_walls = first..first + 1;
        for (&slot, &part) in moving {
            frame.patch[slot as usize] = part;
            frame.moving_walls.end = slot + 1;
        }
    }

    /// Returns the time of the frame `index`.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn frame_time(&self, index: usize) -> Result<FrameTime, OutputError> {
        let scalar = |name| -> Result<f64, OutputError> {
            self.variable(name)?.get_value([index]).map_err(read_error(&self.path))
        };
        Ok(FrameTime { time: scalar("time")?, step: scalar("step")? as u64, time_step: scalar("time_step")? })
    }

    /// Returns true if the last slot of a frame has a particle, so that the frame has all slots of
    /// the file.
    ///
    /// # Errors
    /// [`OutputError::Damaged`] when it cannot be read.
    pub(crate) fn has_last_slot(&self, index: usize) -> Result<bool, OutputError> {
        let Some(last) = self.slots.particles.len().checked_sub(1) else { return Ok(false) };
        let zone: u8 = self.variable("zone")?.get_value([index, last]).map_err(read_error(&self.path))?;
        Ok(zone != ABSENT)
    }

    fn row<T: Stored>(&self, name: &str, index: usize) -> Result<Vec<T>, OutputError> {
        self.variable(name)?
            .get_values(([index, 0], [1, self.slots.particles.len()]))
            .map_err(read_error(&self.path))
    }
}

/// Returns the chunks of the frame `index` of a file with `slots` particles that is not open; None
/// where they have to be compressed again.
///
/// # Errors
/// [`OutputError::Damaged`] when they cannot be read.
pub(crate) fn read_chunks(
    path: &Path,
    header: &Header,
    index: usize,
    slots: usize,
) -> Result<Option<FrameChunks>, OutputError> {
    FrameChunks::read(path, header.dimensions, index, slots).map_err(|ChunkError(what)| {
        OutputError::Damaged { path: path.to_path_buf(), what: format!("cannot be read: {what}") }
    })
}

/// Compresses the slots of a frame on the threads of the pool.
pub(crate) fn compress(frame: &Frame, header: &Header, slots: &Slots) -> FrameChunks {
    FrameChunks::of(frame, header.dimensions, &slots.particles, rayon::current_num_threads())
}

fn place<T: Copy>(column: &mut [T], slots: &[u32], values: &[T]) {
    for (&slot, &value) in slots.iter().zip(values) {
        column[slot as usize] = value;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chunks_of_a_file_are_those_of_its_frame_and_read_back_through_the_library() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("frame.nc");
        let header = Header { dimensions: 2, ..Header::default() };
        let mut frame = Frame::absent(5);
        for slot in [0, 1, 3, 4] {
            frame.zone[slot] = Zone::Fluid as u8;
            frame.position[0][slot] = 0.1 + slot as f64;
            frame.density[slot] = 1000.5 - slot as f32;
            frame.passage[slot] = 70_000 + slot as u32;
        }
        frame.zone[2] = Zone::Wall as u8;
        write_frame(&path, &header, &frame, 3).expect("written");
        let chunks = read_chunks(&path, &header, 0, 4).expect("read");
        assert_eq!(chunks, Some(compress(&frame, &header, &Slots::of(&frame))));
        assert_eq!(read_chunks(&path, &header, 0, 3).expect("read"), None, "another size of the chunks");
        let back = ParticleFile::open(&path).expect("open").frame(0, &Frame::absent(5)).expect("read");
        for slot in [0, 1, 3, 4] {
            assert_eq!(back.position[0][slot], frame.position[0][slot]);
            assert_eq!((back.density[slot], back.passage[slot]), (frame.density[slot], frame.passage[slot]));
        }
    }
}
