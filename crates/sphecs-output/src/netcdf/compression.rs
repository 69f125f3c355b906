//! Columns of a frame as compressed chunks: compressed by several threads, or copied from a file.

use std::path::Path;
use std::sync::atomic::{AtomicUsize, Ordering};

use super::chunks::{Access, Chunk, ChunkError, ChunkFile};
use super::layout::{AXES, CHUNK, VELOCITIES};
use crate::frame::{ABSENT, Frame};

/// Columns of a frame, each with its chunks in the order of the slots.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct FrameChunks(Vec<(&'static str, Vec<Chunk>)>);

impl FrameChunks {
    /// Compresses the slots of a frame on some threads; slots beyond its end are absent.
    pub(super) fn of(frame: &Frame, dimensions: usize, slots: &[u32], threads: usize) -> Self {
        let columns = columns(frame, dimensions);
        let parts: Vec<&[u32]> = slots.chunks(CHUNK).collect();
        let (count, length) = (columns.len() * parts.len(), slots.len().min(CHUNK));
        let next = AtomicUsize::new(0);
        let compress_next = || {
            let task = next.fetch_add(1, Ordering::Relaxed);
            (task < count).then(|| {
                let (column, part) = (&columns[task / parts.len()].1, parts[task % parts.len()]);
                (task, Chunk::compressed(&column.shuffled(part, length)))
            })
        };
        // Not the threads of the pool: they compute the next step while the writer thread is here.
        let mut done = std::thread::scope(|scope| {
            let work = |_| scope.spawn(|| std::iter::from_fn(compress_next).collect::<Vec<_>>());
            let others: Vec<_> = (1..threads.min(count)).map(work).collect();
            let mut done: Vec<_> = std::iter::from_fn(compress_next).collect();
            for other in others {
                match other.join() {
                    Ok(more) => done.extend(more),
                    Err(panic) => std::panic::resume_unwind(panic),
                }
            }
            done
        });
        done.sort_unstable_by_key(|(task, _)| *task);
        let mut chunks = done.into_iter().map(|(_, chunk)| chunk);
        let taken = columns.iter().map(|(name, _)| (*name, chunks.by_ref().take(parts.len()).collect()));
        Self(taken.collect())
    }

    /// Reads the frame `index` of a file as it is; None if its chunks are not those of this
    /// version.
    pub(super) fn read(
        path: &Path,
        dimensions: usize,
        index: usize,
        slots: usize,
    ) -> Result<Option<Self>, ChunkError> {
        let file = ChunkFile::open(path, Access::Read)?;
        let mut read = Vec::new();
        for (name, _) in columns(&Frame::default(), dimensions) {
            let variable = file.variable(name)?;
            if variable.slots_in_chunk() != Some(slots.min(CHUNK)) {
                return Ok(None);
            }
            let chunks = (0..slots).step_by(CHUNK).map(|slot| variable.read(index, slot));
            read.push((name, chunks.collect::<Result<_, _>>()?));
        }
        Ok(Some(Self(read)))
    }

    /// Writes the columns as the frame `index` of a file.
    pub(super) fn write(&self, file: &ChunkFile, index: usize, slots: usize) -> Result<(), ChunkError> {
        for (name, chunks) in self.0.iter().filter(|(_, chunks)| !chunks.is_empty()) {
            let variable = file.variable(name)?;
            variable.resize(index + 1, slots)?;
            for (slot, chunk) in (0..slots).step_by(CHUNK).zip(chunks) {
                variable.write(index, slot, chunk)?;
            }
        }
        Ok(())
    }
}

/// Values of a variable.
pub(super) enum Values<'a> {
    F64(&'a [f64]),
    F32(&'a [f32]),
    U32(&'a [u32]),
    U8(&'a [u8]),
}

impl Values<'_> {
    /// Returns the first bytes of the values of some slots, then their second bytes, and so on, as
    /// the filter of HDF5 arranges them; a chunk has `length` slots.
    pub(super) fn shuffled(&self, slots: &[u32], length: usize) -> Vec<u8> {
        match self {
            Self::F64(values) => shuffled(values, f64::NAN, f64::to_ne_bytes, slots, length),
            Self::F32(values) => shuffled(values, f32::NAN, f32::to_ne_bytes, slots, length),
            Self::U32(values) => shuffled(values, 0, u32::to_ne_bytes, slots, length),
            Self::U8(values) => shuffled(values, ABSENT, u8::to_ne_bytes, slots, length),
        }
    }
}

fn shuffled<T: Copy, const N: usize>(
    values: &[T],
    absent: T,
    bytes: fn(T) -> [u8; N],
    slots: &[u32],
    length: usize,
) -> Vec<u8> {
    let mut shuffled = vec![0; N * length];
    for (at, &slot) in slots.iter().enumerate() {
        let value = values.get(slot as usize).copied().unwrap_or(absent);
        for (byte, plane) in bytes(value).into_iter().zip(shuffled.chunks_exact_mut(length)) {
            plane[at] = byte;
        }
    }
    shuffled
}

/// Returns the columns of a frame over (time, slot) with the names of their variables.
fn columns(frame: &Frame, dimensions: usize) -> Vec<(&'static str, Values<'_>)> {
    let mut columns = Vec::new();
    for axis in 0..dimensions {
        columns.push((AXES[axis], Values::F64(&frame.position[axis])));
        columns.push((VELOCITIES[axis], Values::F32(&frame.velocity[axis])));
    }
    columns.extend([
        ("density", Values::F32(&frame.density)),
        ("pressure", Values::F32(&frame.pressure)),
        ("tag", Values::F32(&frame.tag)),
        ("zone", Values::U8(&frame.zone)),
        ("passage", Values::U32(&frame.passage)),
    ]);
    columns
}
