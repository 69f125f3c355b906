//! Packed neighbourhood of a cell: the particles that all rows of the cell sum over.
//!
//! Once per cell the particles of all cells within reach are copied, column by column, into a small
//! buffer that stays in the first-level cache. Positions are relative to the centre of the rows
//! that sum, in units of h and in the precision of the sums. Periodic images are shifted. In 3D
//! particles out of reach of all rows are left out (culled). The tail is padded with particles far
//! away. So the pair loop has no gathers and one form for 2D and 3D, periodic and narrow boxes.
//! Single precision loses only the last digits of a distance, anywhere in the domain.
//!
//! | file | subject |
//! |---|---|
//! | `source.rs` | the columns and rows that a pack is made from |
//! | `copy.rs` | how it is filled |
//! | `columns.rs` | its columns by name and type |
//! | `entries.rs` | its vectors, as the pair loops read them |
//! | `mask.rs`, `tile.rs` | the particles in the support of a row |
//! | `bounds.rs` | the box around it |

mod bounds;
mod columns;
mod copy;
mod entries;
mod mask;
#[cfg(test)]
mod mask_tests;
mod source;
mod tile;

use std::ops::Range;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crossbeam_utils::CachePadded;

pub use bounds::Bounds;
pub use columns::{ColumnList, Scalar, Symmetric, Vector};
pub use entries::Entry;
pub use mask::{CoveredLanes, MaskBuilder, NeighbourMask, mask_len};
pub use source::{Only, Source};
pub use tile::TILE_VECTORS;

use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Coordinate of the padding, in units of h, beyond every support and with a finite square in f32.
const FAR: f64 = 1e6;

/// Numbers in a cache line, for f32: columns begin on one.
const LINE: usize = 16;

/// Smallest number of dimensions in which packs are culled. In 3D 40 % of the candidates are out of
/// reach of all rows that sum.
pub const CULLED_DIMENSIONS: usize = 3;

/// A neighbourhood, column by column.
#[derive(Debug, Default)]
pub struct Pack<R> {
    storage: Vec<R>,
    /// Index in the storage at which the first column begins.
    begin: usize,
    /// Distance from one column to the next.
    stride: usize,
    /// Number of columns.
    columns: usize,
    /// Entries of each column, padding included: a multiple of the lanes that filled it.
    len: usize,
    /// Lanes of the vectors that filled it.
    lanes: usize,
    /// Bits that masks of the pack use.
    used_bits: u64,
    /// Lanes that share a bit of a mask.
    lanes_per_bit: usize,
    /// Centre of the box around the rows that sum, m.
    centre: [f64; 3],
    /// Runs of rows that were packed.
    runs: Vec<Run>,
}

/// Consecutive rows, and the shift of their positions, m.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: usize,
    end: usize,
    shift: [f64; 3],
}

impl<R: Real> Pack<R> {
    /// Packs the neighbourhood of the wanted rows of a cell; returns false if there are none. In 3D
    /// particles out of reach of all of them are left out.
    #[inline(always)]
    pub fn fill<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        cell: usize,
        wanted: impl Fn(usize) -> bool,
    ) -> bool {
        let mut rows = source.grid.rows(cell).filter(|&row| wanted(row));
        let Some(first) = rows.next() else { return false };
        if D < CULLED_DIMENSIONS {
            self.fill_around::<L, D>(source, source.grid.index_of(cell));
            return true;
        }
        let mut lower: [f64; D] = std::array::from_fn(|d| source.position[d][first]);
        let mut upper = lower;
        for row in rows {
            for d in 0..D {
                let x = source.position[d][row];
                lower[d] = if x < lower[d] { x } else { lower[d] };
                upper[d] = if x > upper[d] { x } else { upper[d] };
            }
        }
        for d in 0..D {
            self.centre[d] = 0.5 * (lower[d] + upper[d]);
        }
        self.runs.clear();
        let mut candidates = 0;
        source.grid.for_each_run_near(lower, upper, |rows, by| {
            candidates += self.add_run::<L, D>(source.only, rows, by)
        });
        self.copy::<L, D>(source, std::array::from_fn(|d| upper[d] - lower[d]), candidates);
        true
    }

    /// Packs the neighbourhood of the cell of an unwrapped index, which need not be in the grid.
    #[inline(always)]
    pub fn fill_around<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        index: [i64; D],
    ) {
        let candidates = self.find_runs::<L, D>(source, index);
        self.copy::<L, D>(source, source.grid.cell_size(), candidates);
    }

    /// Copies the particles of the runs, of which there are `candidates`, that are in reach of a
    /// box of this `size`, m, about the centre.
    #[inline(always)]
    fn copy<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        size: [f64; D],
        candidates: usize,
    ) {
        let grid = source.grid;
        let total = source.position[0].len();
        let columns = source.columns.len();
        assert!(grid.starts()[grid.len()] as usize <= total, "the arrays must be sorted by this grid");
        let mut needed = source.columns.iter().copied().chain(source.only.column());
        assert!(needed.all(|column| column.len() == total), "columns must have all rows");

        self.reserve(candidates + L::COUNT, D + columns);
        (self.columns, self.lanes, self.len, self.used_bits) = (D + columns, L::COUNT, 0, 0);
        if candidates == 0 {
            return;
        }
        let len = if D < CULLED_DIMENSIONS && matches!(source.only, Only::All) {
            self.copy_all::<L, D>(source)
        } else {
            self.copy_near::<L, D>(source, size)
        };
        let base = self.storage[self.begin..].as_mut_ptr();
        for column in 0..D + columns {
            // SAFETY: `reserve` left space for one more vector after all candidates. The other
            // columns of the padding must be finite, so they repeat the first particle.
            unsafe {
                let first = base.add(column * self.stride);
                let filler = if column < D { R::from_f64(FAR) } else { *first };
                L::splat(filler).store(first.add(len));
            }
        }
        self.len = len.next_multiple_of(L::COUNT);
        (self.used_bits, self.lanes_per_bit) = mask::used_bits::<L>(self.len / L::COUNT);
    }

    /// Returns true if no particle was packed.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Returns the position of a row of the cell relative to the centre of the pack, in units of h.
    #[inline(always)]
    pub fn relative<const D: usize>(&self, source: &Source<R, D>, row: usize) -> [R; D] {
        self.relative_to(source, std::array::from_fn(|d| source.position[d][row]))
    }

    /// Returns a point of the cell (m) relative to the centre of the pack, in units of h.
    #[inline(always)]
    pub fn relative_to<const D: usize>(&self, source: &Source<R, D>, point: [f64; D]) -> [R; D] {
        std::array::from_fn(|d| R::from_f64((point[d] - self.centre[d]) * source.inverse_h))
    }

    /// Finds the runs of rows around a cell, and its centre; returns the number of candidates, each
    /// run rounded up to whole vectors.
    #[inline(always)]
    fn find_runs<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        index: [i64; D],
    ) -> usize {
        let grid = source.grid;
        let corner = grid.corner(index);
        for d in 0..D {
            self.centre[d] = corner[d] + 0.5 * grid.cell_size()[d];
        }
        self.runs.clear();
        let mut candidates = 0;
        grid.for_each_run(index, |rows, by| candidates += self.add_run::<L, D>(source.only, rows, by));
        candidates
    }

    /// Adds a run if it has rows that are packed; returns the number of its rows, rounded up to
    /// whole vectors.
    #[inline(always)]
    fn add_run<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        only: Only<R>,
        rows: Range<usize>,
        by: [f64; D],
    ) -> usize {
        if !only.any(&rows) {
            return 0;
        }
        let mut shift = [0.0; 3];
        shift[..D].copy_from_slice(&by);
        self.runs.push(Run { start: rows.start, end: rows.end, shift });
        rows.len().next_multiple_of(L::COUNT)
    }

    /// Reserves space for `rows` entries in each of `columns` columns.
    fn reserve(&mut self, rows: usize, columns: usize) {
        let needed = rows.next_multiple_of(LINE) + LINE;
        if needed > self.stride {
            // The number of lines between columns is odd, since with an even one all columns would
            // compete for the same cache sets.
            self.stride = ((needed / LINE) | 1) * LINE;
        }
        // The stride may be longer than needed if it comes from a pass with fewer columns and more
        // rows.
        let length = self.stride * columns + 2 * LINE;
        if length > self.storage.len() {
            self.storage.resize(length, R::default());
            self.begin = self.storage.as_ptr().align_offset(64).min(LINE);
        }
    }
}

/// One pack per thread, kept from pass to pass. Each has its own cache lines. The fields of a pack
/// are written at every cell and read at every row; two threads that share a line take 50 % longer.
#[derive(Debug, Default)]
pub struct PackPool<R>(Vec<CachePadded<Mutex<Pack<R>>>>);

impl<R: Real> PackPool<R> {
    /// Makes one pack for every thread of the pool that runs the pass.
    pub fn prepare(&mut self) {
        let threads = rayon::current_num_threads();
        if self.0.len() < threads {
            self.0.resize_with(threads, CachePadded::default);
        }
    }

    /// Returns the pack of this thread. The lock is never contended, since a thread holds it for
    /// one block and starts no other work in it.
    pub fn of_this_thread(&self) -> MutexGuard<'_, Pack<R>> {
        let thread = rayon::current_thread_index().unwrap_or(0) % self.0.len();
        self.0[thread].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_columns_after_a_pass_with_more_rows_fit() {
        let mut pack = Pack::<f64>::default();
        pack.reserve(1000, 3);
        pack.reserve(10, 12);
        assert!(pack.begin + pack.stride * 12 <= pack.storage.len());
    }
}
