//! The packed neighbourhood of a cell: what all rows of the cell sum over.
//!
//! Once per cell the particles of all cells within reach are copied, column by column, into a small buffer that stays
//! in the first-level cache: positions relative to the cell's centre, in units of h and in the precision of the
//! sums, periodic images shifted, those that no point of the cell can reach left out. The tail is padded with
//! particles far away. So the pair loop has no masks, no gathers and one form for 2D and 3D, periodic or narrow
//! boxes, and single precision loses only the last digits of a distance, wherever in the domain it is.

use std::marker::PhantomData;
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::math::grid::CellGrid;
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Coordinate of the padding, in units of h: beyond every support, and its square is finite in f32.
const FAR: f64 = 1e6;

/// The most lanes that an instruction set has.
const MOST_LANES: usize = 16;

/// Numbers in a line of the cache, for f32: columns begin on one.
const LINE: usize = 16;

/// Culling pays where the cells reach far beyond the support: in 3D, a third of the candidates.
const CULLED_DIMENSIONS: usize = 3;

/// What a neighbourhood is packed from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, R, const D: usize> {
    /// Grid that the rows are sorted by.
    pub grid: &'a CellGrid<D>,
    /// Position, m.
    pub position: &'a [Vec<f64>; D],
    /// Further columns, in the order in which the pair loop asks for them.
    pub columns: &'a [&'a [R]],
    /// 1/h, 1/m.
    pub inverse_h: f64,
    /// Radius of the support over h.
    pub support_ratio: f64,
    /// Which of the rows are packed.
    pub only: Only<'a, R>,
}

/// Which rows a pack takes up. A pass that asks for walls alone, or for all others, has less to loop over.
#[derive(Clone, Copy, Debug)]
pub enum Only<'a, R> {
    /// All rows.
    All,
    /// Those that have more than 0 in this column.
    Positive(&'a [R]),
    /// Those that have not.
    NotPositive(&'a [R]),
}

impl<'a, R> Only<'a, R> {
    fn column(self) -> Option<&'a [R]> {
        match self {
            Only::All => None,
            Only::Positive(column) | Only::NotPositive(column) => Some(column),
        }
    }
}

/// A neighbourhood, column by column.
#[derive(Debug, Default)]
pub struct Pack<R> {
    storage: Vec<R>,
    /// Where the first column begins in the storage.
    begin: usize,
    /// From one column to the next.
    stride: usize,
    /// Columns packed.
    columns: usize,
    /// Entries of each column, padding included: a multiple of the lanes that filled it.
    len: usize,
    /// Lanes that filled it.
    lanes: usize,
    /// Centre of the cell, m.
    centre: [f64; 3],
    /// Rows that were packed.
    runs: Vec<Run>,
}

/// Consecutive rows, and what to add to their positions, m.
#[derive(Clone, Copy, Debug)]
struct Run {
    start: usize,
    end: usize,
    shift: [f64; 3],
}

impl<R: Real> Pack<R> {
    /// Packs the neighbourhood of a cell.
    #[inline(always)]
    pub fn fill<L: Lanes<Real = R>, const D: usize>(&mut self, source: &Source<R, D>, cell: usize) {
        self.fill_around::<L, D>(source, source.grid.index_of(cell));
    }

    /// Packs the neighbourhood of the cell of an unwrapped index, which need not be in the grid.
    #[inline(always)]
    pub fn fill_around<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        index: [i64; D],
    ) {
        let grid = source.grid;
        let total = source.position[0].len();
        let columns = source.columns.len();
        assert!(grid.starts()[grid.len()] as usize <= total, "the arrays must be sorted by this grid");
        let mut needed = source.columns.iter().copied().chain(source.only.column());
        assert!(needed.all(|column| column.len() == total), "columns must have all rows");

        let candidates = self.find_runs(grid, index, L::COUNT);
        self.reserve(candidates + L::COUNT, D + columns);
        let base = self.storage[self.begin..].as_mut_ptr();
        let stride = self.stride;
        let limit = L::constant(source.support_ratio * source.support_ratio);
        let mut half = [L::constant(0.0); D];
        for d in 0..D {
            // The margin covers the rounding of f32 coordinates.
            half[d] = L::constant(0.5 * grid.cell_size()[d] * source.inverse_h + 1e-5);
        }

        let zero = L::constant(0.0);
        let in_place = D < CULLED_DIMENSIONS && matches!(source.only, Only::All);
        let mut len = 0;
        for &Run { start, end, shift } in &self.runs {
            let mut row = start;
            while row < end {
                let count = L::COUNT.min(end - row);
                let whole = row + L::COUNT <= total;
                let mut x = [L::constant(0.0); D];
                let mut beyond = L::constant(0.0);
                for d in 0..D {
                    let origin = self.centre[d] - shift[d];
                    // SAFETY: `COUNT` numbers follow `row`, or a copy of what is there is read.
                    x[d] = unsafe {
                        if whole {
                            L::load_relative(source.position[d].as_ptr().add(row), origin, source.inverse_h)
                        } else {
                            L::load_relative(
                                padded(&source.position[d][row..]).as_ptr(),
                                origin,
                                source.inverse_h,
                            )
                        }
                    };
                    let outside = (x[d].abs() - half[d]).max(L::constant(0.0));
                    beyond = outside.mul_add(outside, beyond);
                }
                let asked_for = match source.only {
                    Only::All => beyond,
                    Only::Positive(column) => L::select(zero.less(load_rows(column, row)), beyond, limit),
                    Only::NotPositive(column) => L::select(zero.less(load_rows(column, row)), limit, beyond),
                };
                let near = asked_for.less(limit);
                let kept = if in_place {
                    count
                } else {
                    (L::bits(near) & ((1u32 << count) - 1)).count_ones() as usize
                };
                if kept > 0 {
                    for column in 0..D + columns {
                        let values =
                            if column < D { x[column] } else { load_rows(source.columns[column - D], row) };
                        // SAFETY: `reserve` made room for all candidates, each run rounded up to whole vectors.
                        unsafe {
                            let to = base.add(column * stride + len);
                            if in_place { values.store(to) } else { values.compress(near, to) }
                        }
                    }
                }
                len += kept;
                row += L::COUNT;
            }
        }

        for column in 0..D + columns {
            // SAFETY: `reserve` left room for one more vector after all candidates. What the padding has in its other
            // columns must be finite, so they repeat the first particle.
            unsafe {
                let filler = if column < D { R::from_f64(FAR) } else { *base.add(column * stride) };
                L::splat(filler).store(base.add(column * stride + len));
            }
        }
        self.columns = D + columns;
        self.lanes = L::COUNT;
        self.len = len.next_multiple_of(L::COUNT);
    }

    /// The packed particles, vector by vector; `columns` says how many columns will be asked for.
    #[inline(always)]
    pub fn entries<L: Lanes<Real = R>>(&self, columns: usize) -> Entries<'_, L> {
        assert!(columns <= self.columns && self.lanes == L::COUNT);
        Entries {
            base: self.storage[self.begin..].as_ptr(),
            left: self.len / L::COUNT,
            stride: self.stride,
            columns,
            pack: PhantomData,
        }
    }

    /// How many rows around a cell are counted by `before`, which says how many there are before each row.
    pub fn count_around<const D: usize>(grid: &CellGrid<D>, cell: usize, before: &[u32]) -> usize {
        let mut count = 0;
        grid.for_each_run(grid.index_of(cell), |rows, _| {
            count += (before[rows.end] - before[rows.start]) as usize
        });
        count
    }

    /// Position of a row of the cell as the pack has it: relative to the cell's centre, in units of h.
    #[inline(always)]
    pub fn relative<const D: usize>(&self, source: &Source<R, D>, row: usize) -> [R; D] {
        self.relative_to(source, std::array::from_fn(|d| source.position[d][row]))
    }

    /// The same of any point of the cell.
    #[inline(always)]
    pub fn relative_to<const D: usize>(&self, source: &Source<R, D>, point: [f64; D]) -> [R; D] {
        std::array::from_fn(|d| R::from_f64((point[d] - self.centre[d]) * source.inverse_h))
    }

    /// Finds the runs of rows around a cell and its centre; returns the number of candidates, each run rounded up to
    /// whole vectors.
    fn find_runs<const D: usize>(&mut self, grid: &CellGrid<D>, index: [i64; D], lanes: usize) -> usize {
        let corner = grid.corner(index);
        for d in 0..D {
            self.centre[d] = corner[d] + 0.5 * grid.cell_size()[d];
        }
        self.runs.clear();
        let mut candidates = 0;
        grid.for_each_run(index, |rows, by| {
            let mut shift = [0.0; 3];
            shift[..D].copy_from_slice(&by);
            candidates += rows.len().next_multiple_of(lanes);
            self.runs.push(Run { start: rows.start, end: rows.end, shift });
        });
        candidates
    }

    /// Makes room for `rows` entries in each of `columns` columns.
    fn reserve(&mut self, rows: usize, columns: usize) {
        let needed = rows.next_multiple_of(LINE) + LINE;
        if needed > self.stride {
            // An odd number of lines between columns, or all columns would compete for the same cache sets.
            self.stride = ((needed / LINE) | 1) * LINE;
        }
        // The stride in use, not the one needed now: it may come from a pass with fewer columns and longer rows.
        let length = self.stride * columns + 2 * LINE;
        if length > self.storage.len() {
            self.storage.resize(length, R::default());
            self.begin = self.storage.as_ptr().align_offset(64).min(LINE);
        }
    }
}

/// Whether none of a vector's neighbours is within the support, so that it adds nothing to a sum; `limit` is the square of the
/// support. In 2D that is some quarter of the vectors; in a culled pack too few for what the branch costs (docs/performance.md), so there it is
/// never said.
#[inline(always)]
pub fn nothing_near<L: Lanes, const D: usize>(q2: L, limit: L) -> bool {
    D < CULLED_DIMENSIONS && L::bits(q2.less(limit)) == 0
}

/// The vectors of a pack, one after another.
#[derive(Debug)]
pub struct Entries<'a, L: Lanes> {
    base: *const L::Real,
    left: usize,
    stride: usize,
    columns: usize,
    pack: PhantomData<&'a L::Real>,
}

impl<'a, L: Lanes> Iterator for Entries<'a, L> {
    type Item = Entry<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry<'a, L>> {
        if self.left == 0 {
            return None;
        }
        let entry = Entry { base: self.base, stride: self.stride, columns: self.columns, pack: PhantomData };
        self.left -= 1;
        self.base = self.base.wrapping_add(L::COUNT);
        Some(entry)
    }
}

/// One vector of neighbours: a lane is a neighbour.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a, L: Lanes> {
    base: *const L::Real,
    stride: usize,
    columns: usize,
    pack: PhantomData<&'a L::Real>,
}

impl<L: Lanes> Entry<'_, L> {
    /// Numbers of a column: the coordinates first, then the columns in the order of the source.
    #[inline(always)]
    pub fn column(&self, column: usize) -> L {
        assert!(column < self.columns);
        // SAFETY: the pack has that many columns (checked when the iteration began), each of whole vectors.
        unsafe { L::load(self.base.add(column * self.stride)) }
    }

    /// `D` consecutive columns as a vector.
    #[inline(always)]
    pub fn vector<const D: usize>(&self, first: usize) -> [L; D] {
        let mut vector = [L::constant(0.0); D];
        for d in 0..D {
            vector[d] = self.column(first + d);
        }
        vector
    }
}

/// The numbers from a row on, followed by zeros where the column ends.
#[inline(always)]
fn load_rows<L: Lanes>(column: &[L::Real], row: usize) -> L {
    // SAFETY: `COUNT` numbers follow `row`, or a copy of what is there is read.
    unsafe {
        if row + L::COUNT <= column.len() {
            L::load(column.as_ptr().add(row))
        } else {
            L::load(padded(&column[row..]).as_ptr())
        }
    }
}

/// The numbers, followed by zeros: for the last rows of the arrays.
#[inline(always)]
fn padded<T: Copy + Default>(numbers: &[T]) -> [T; MOST_LANES] {
    let mut copy = [T::default(); MOST_LANES];
    let count = numbers.len().min(MOST_LANES);
    copy[..count].copy_from_slice(&numbers[..count]);
    copy
}

/// One pack per thread, kept from pass to pass.
#[derive(Debug, Default)]
pub struct PackPool<R>(Vec<Mutex<Pack<R>>>);

impl<R: Real> PackPool<R> {
    /// One pack for every thread of the pool that runs the pass.
    pub fn prepare(&mut self) {
        let threads = rayon::current_num_threads();
        if self.0.len() < threads {
            self.0.resize_with(threads, Mutex::default);
        }
    }

    /// The pack of this thread. Never contended: a thread holds it for one block, in which it starts no other work.
    pub fn of_this_thread(&self) -> MutexGuard<'_, Pack<R>> {
        let thread = rayon::current_thread_index().unwrap_or(0) % self.0.len();
        self.0[thread].lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn many_columns_after_long_rows_have_room() {
        let mut pack = Pack::<f64>::default();
        pack.reserve(1000, 3);
        pack.reserve(10, 12);
        assert!(pack.begin + pack.stride * 12 <= pack.storage.len());
    }
}
