//! Writing and reading of frames in NetCDF files with the [`layout`](super::layout).

use std::path::{Path, PathBuf};

use ::netcdf::{File, FileMut};

use super::file::{Stored, WriteError, open_file, read_error, write_file};
use super::layout::{AXES, VELOCITIES, define, put_walls};
use super::slots::{Slots, pick};
use crate::error::OutputError;
use crate::frame::Frame;
use crate::header::Header;
use sphecs_core::particles::zone::Zone;

/// Writes the walls of a run without a frame.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_walls(path: &Path, header: &Header, frame: &Frame) -> Result<(), OutputError> {
    let slots = Slots { particles: Vec::new(), walls: Slots::of(frame).walls };
    write_file(path, |file| {
        define(file, header, &slots)?;
        Ok(put_walls(file, header, &slots, frame)?)
    })
}

/// Writes one frame without its walls.
///
/// # Errors
/// [`OutputError`] with the path and the cause.
pub(crate) fn write_frame(path: &Path, header: &Header, frame: &Frame) -> Result<(), OutputError> {
    let slots = Slots::of(frame);
    write_file(path, |file| {
        define(file, header, &slots)?;
        Ok(put_frame(file, header, &slots, 0, frame)?)
    })
}

/// Writes all frames of a run; `frame` is called for 0, 1, … `count` − 1, and `slots` are those of
/// the largest frame.
///
/// # Errors
/// [`OutputError`] of a frame, or with the path and the cause.
pub(crate) fn write_run(
    path: &Path,
    header: &Header,
    slots: &Slots,
    walls: &Frame,
    count: usize,
    mut frame: impl FnMut(usize) -> Result<Frame, OutputError>,
) -> Result<(), OutputError> {
    write_file(path, |file| {
        define(file, header, slots)?;
        put_walls(file, header, slots, walls)?;
        for index in 0..count {
            put_frame(file, header, slots, index, &frame(index).map_err(WriteError::Source)?)?;
        }
        Ok(())
    })
}

fn put_frame(
    file: &mut FileMut,
    header: &Header,
    slots: &Slots,
    index: usize,
    frame: &Frame,
) -> Result<(), ::netcdf::Error> {
    fn put<T: Stored>(
        file: &mut FileMut,
        name: &str,
        index: usize,
        values: &[T],
    ) -> Result<(), ::netcdf::Error> {
        let Some(mut variable) = file.variable_mut(name) else {
            return Err(::netcdf::Error::NotFound(name.to_owned()));
        };
        if variable.dimensions().len() == 1 {
            variable.put_values(values, ([index], [1]))
        } else if values.is_empty() {
            Ok(())
        } else {
            variable.put_values(values, ([index, 0], [1, values.len()]))
        }
    }
    // Frames from before the last growth of the reservoir have fewer slots than the file.
    let longer;
    let frame = if frame.len() < slots.dense_len() {
        let mut padded = frame.clone();
        padded.resize(slots.dense_len());
        longer = padded;
        &longer
    } else {
        frame
    };
    let ids = &slots.particles;
    for axis in 0..header.dimensions {
        put(file, AXES[axis], index, &pick(&frame.position[axis], ids))?;
        put(file, VELOCITIES[axis], index, &pick(&frame.velocity[axis], ids))?;
    }
    put(file, "density", index, &pick(&frame.density, ids))?;
    put(file, "pressure", index, &pick(&frame.pressure, ids))?;
    put(file, "tag", index, &pick(&frame.tag, ids))?;
    put(file, "zone", index, &pick(&frame.zone, ids))?;
    put(file, "passage", index, &pick(&frame.passage, ids))?;
    put(file, "step", index, &[frame.step as i64])?;
    put(file, "time_step", index, &[frame.time_step])?;
    put(file, "time", index, &[frame.time])
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
        if self.dimensions == 2 {
            for slot in ids.iter().map(|&slot| slot as usize) {
                // It is zero, or NaN for slots without a position.
                frame.position[2][slot] = 0.0 * frame.position[0][slot] + 0.0;
                frame.velocity[2][slot] = 0.0 * frame.velocity[0][slot] + 0.0;
            }
        }
        let scalar = |name| -> Result<f64, OutputError> {
            self.variable(name)?.get_value([index]).map_err(read_error(&self.path))
        };
        frame.time = scalar("time")?;
        frame.time_step = scalar("time_step")?;
        frame.step = scalar("step")? as u64;
        Ok(frame)
    }

    fn row<T: Stored>(&self, name: &str, index: usize) -> Result<Vec<T>, OutputError> {
        self.variable(name)?
            .get_values(([index, 0], [1, self.slots.particles.len()]))
            .map_err(read_error(&self.path))
    }
}

fn place<T: Copy>(column: &mut [T], slots: &[u32], values: &[T]) {
    for (&slot, &value) in slots.iter().zip(values) {
        column[slot as usize] = value;
    }
}
