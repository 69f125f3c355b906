//! Counting sort of particles into the cells, by cell and inside a cell by the particle's number.

use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::CellGrid;

/// Rows that a thread takes at a time.
const CHUNK: usize = 8192;

/// Cells that one thread sorts without splitting further.
const CELLS_PER_TASK: usize = 2048;

/// Cell of a row that is left out.
const NO_CELL: u32 = u32::MAX;

/// Buffers kept from sort to sort.
#[derive(Debug, Default)]
pub(super) struct SortBuffers {
    /// Rows counted per cell, then the next free slot of the cell.
    cursor: Vec<AtomicU32>,
    /// Particle number in the upper half, row in the lower half.
    slots: Vec<AtomicU64>,
}

impl<const D: usize> CellGrid<D> {
    /// Sorts the rows for which `keep` holds into the cells and returns the order: row indices by cell, inside a cell
    /// by `id`, so that a sum over neighbours does not depend on how the particles came there.
    ///
    /// # Errors
    /// The first kept row that is outside the box, or whose position is not finite.
    pub fn build(
        &mut self,
        position: &[Vec<f64>; D],
        id: &[u32],
        keep: impl Fn(usize) -> bool + Sync,
    ) -> Result<&[u32], usize> {
        let rows = id.len();
        let cells = self.len();
        let mut buffers = std::mem::take(&mut self.buffers);
        // The cell of each row, in the memory of the order that will replace it.
        let mut cell_of_row = std::mem::take(&mut self.order);
        cell_of_row.resize(rows, NO_CELL);
        buffers.cursor.resize_with(cells, AtomicU32::default);
        buffers.cursor.par_iter_mut().with_min_len(CHUNK).for_each(|count| *count.get_mut() = 0);

        let outside = self.count(position, &keep, &mut cell_of_row, &buffers.cursor);
        if outside != usize::MAX {
            self.order = cell_of_row;
            self.buffers = buffers;
            return Err(outside);
        }

        let mut total = 0;
        for (start, cursor) in self.starts.iter_mut().zip(&mut buffers.cursor) {
            *start = total;
            total += *cursor.get_mut();
            *cursor.get_mut() = *start;
        }
        self.starts[cells] = total;

        let kept = total as usize;
        buffers.slots.resize_with(kept, AtomicU64::default);
        cell_of_row.par_chunks(CHUNK).enumerate().for_each(|(chunk, cell_of)| {
            let mut row = chunk * CHUNK;
            for run in cell_of.chunk_by(|a, b| a == b) {
                if run[0] != NO_CELL {
                    let first = buffers.cursor[run[0] as usize].fetch_add(run.len() as u32, Relaxed) as usize;
                    for (slot, row) in buffers.slots[first..first + run.len()].iter().zip(row..) {
                        slot.store(u64::from(id[row]) << 32 | row as u64, Relaxed);
                    }
                }
                row += run.len();
            }
        });

        self.order = cell_of_row;
        self.order.resize(kept, 0);
        sort_inside_cells(&self.starts, &mut buffers.slots, &mut self.order);
        self.buffers = buffers;
        Ok(&self.order)
    }

    /// Finds the cell of each row and counts rows per cell; returns the first row outside the box, or `usize::MAX`.
    fn count(
        &self,
        position: &[Vec<f64>; D],
        keep: &(impl Fn(usize) -> bool + Sync),
        cell_of_row: &mut [u32],
        cursor: &[AtomicU32],
    ) -> usize {
        let outside = AtomicUsize::new(usize::MAX);
        cell_of_row.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, cell_of)| {
            for (offset, cell) in cell_of.iter_mut().enumerate() {
                let row = chunk * CHUNK + offset;
                *cell = NO_CELL;
                if !keep(row) {
                    continue;
                }
                match self.cell_of(std::array::from_fn(|d| position[d][row])) {
                    Some(found) => *cell = found as u32,
                    None => {
                        outside.fetch_min(row, Relaxed);
                    }
                }
            }
            // Most rows are in order since the last sort: one atomic addition a run of rows, not one a row.
            for run in cell_of.chunk_by(|a, b| a == b) {
                if run[0] != NO_CELL {
                    cursor[run[0] as usize].fetch_add(run.len() as u32, Relaxed);
                }
            }
        });
        outside.into_inner()
    }
}

/// Sorts the slots of each cell by particle number and writes their rows. `starts` are the bounds of the cells within
/// the whole order; `slots` and `order` are the part that belongs to them.
fn sort_inside_cells(starts: &[u32], slots: &mut [AtomicU64], order: &mut [u32]) {
    let cells = starts.len() - 1;
    if cells > CELLS_PER_TASK {
        let middle = cells / 2;
        let rows = (starts[middle] - starts[0]) as usize;
        let (slots_low, slots_high) = slots.split_at_mut(rows);
        let (order_low, order_high) = order.split_at_mut(rows);
        rayon::join(
            || sort_inside_cells(&starts[..=middle], slots_low, order_low),
            || sort_inside_cells(&starts[middle..], slots_high, order_high),
        );
        return;
    }
    for bounds in starts.windows(2) {
        let rows = (bounds[0] - starts[0]) as usize..(bounds[1] - starts[0]) as usize;
        let slots = &mut slots[rows.clone()];
        slots.sort_unstable_by_key(|slot| slot.load(Relaxed));
        for (row, slot) in order[rows].iter_mut().zip(slots) {
            *row = *slot.get_mut() as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn order_is_by_cell_then_by_number() {
        let mut grid = CellGrid::new([0.0; 2], [4.0, 2.0], [false; 2], 1.0, 1.0);
        let position = [vec![3.5, 0.5, 0.4, 0.6, 1.5], vec![1.5, 0.5, 0.5, 0.5, 0.5]];
        let order = grid.build(&position, &[7, 9, 3, 5, 1], |row| row != 3).expect("all inside");
        assert_eq!(order, [2, 1, 4, 0]);
        assert_eq!(grid.starts(), [0, 2, 3, 3, 3, 3, 3, 3, 4]);
    }

    #[test]
    fn first_row_outside_is_named() {
        let mut grid = CellGrid::new([0.0; 2], [1.0; 2], [false; 2], 0.5, 0.5);
        let position = [vec![0.5, f64::NAN, 2.0, 0.1], vec![0.5; 4]];
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |_| true), Err(1));
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |row| row != 1), Err(2));
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |row| row == 3), Ok(&[3][..]));
    }
}
