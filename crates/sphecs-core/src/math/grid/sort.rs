//! Counting sort of particles: by cell, inside a cell by its parts along x, inside a part by
//! number.
//!
//! With parts, particles that are adjacent in the order are adjacent in space, so that fewer SIMD
//! vectors of a neighbourhood contain particles inside the support. In 3D, where neighbourhoods are
//! culled, a cell has one part.

use std::sync::atomic::{AtomicU32, AtomicU64, AtomicUsize, Ordering::Relaxed};

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::CellGrid;
use crate::math::lanes::{InstructionSet, Lanes, Vectorised};
use crate::math::real::Real;

/// Rows per task of a thread.
const CHUNK: usize = 8192;

/// Rows whose slots are computed together.
const GROUP: usize = 64;

/// Cells that one thread sorts without splitting further.
const CELLS_PER_TASK: usize = 2048;

/// Marker for a row that is not sorted.
const NO_PLACE: u32 = u32::MAX;

/// Marker for a row of a cell that is not held: [`CellGrid::hold`].
const NOT_HELD: u32 = u32::MAX - 1;

/// Parts of a cell along x. On a lattice with cells of three spacings, no column of particles lies
/// on the edge of one of three parts.
const PARTS: u32 = 3;

/// Returns the number of bits for the part of a cell.
const fn part_bits<const D: usize>() -> u32 {
    if D < 3 { PARTS.next_power_of_two().ilog2() } else { 0 }
}

/// Bits for the row in a slot, below those of the particle number and of the part.
const ROW_BITS: u32 = 30;

/// Buffers reused from sort to sort.
#[derive(Debug, Default)]
pub(super) struct SortBuffers {
    /// Number of rows per cell, then the next free slot of the cell.
    cursor: Vec<AtomicU32>,
    /// Part of the cell, particle number and row, from the highest bit on.
    slots: Vec<AtomicU64>,
}

impl<const D: usize> CellGrid<D> {
    /// Sorts the rows of cells that are held for which `keep` is true, and returns the order: row
    /// indices by cell, inside a cell by part and `id`. A sum over neighbours therefore does not
    /// depend on the previous order.
    ///
    /// # Errors
    /// The first kept row outside the box or with a position that is not finite.
    pub fn build(
        &mut self,
        position: &[Vec<f64>; D],
        id: &[u32],
        keep: impl Fn(usize) -> bool + Sync,
    ) -> Result<&[u32], usize> {
        let rows = id.len();
        let cells = self.len();
        assert!(rows < 1 << ROW_BITS, "more than a billion particles");
        assert!(cells < (NO_PLACE >> part_bits::<D>()) as usize, "more cells than can be numbered");
        let mut buffers = std::mem::take(&mut self.buffers);
        // The buffer of the order holds the places of the rows until the new order is known.
        let mut place_of_row = std::mem::take(&mut self.order);
        place_of_row.resize(rows, NO_PLACE);
        buffers.cursor.resize_with(cells, AtomicU32::default);
        buffers.cursor.par_iter_mut().with_min_len(CHUNK).for_each(|count| *count.get_mut() = 0);

        let outside = self.count(position, &keep, &mut place_of_row, &buffers.cursor);
        if outside != usize::MAX {
            self.order = place_of_row;
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
        place_of_row.par_chunks(CHUNK).enumerate().for_each(|(chunk, place_of)| {
            let mut row = chunk * CHUNK;
            for run in place_of.chunk_by(same_cell::<D>) {
                if run[0] != NO_PLACE {
                    let cursor = &buffers.cursor[(run[0] >> part_bits::<D>()) as usize];
                    let first = cursor.fetch_add(run.len() as u32, Relaxed) as usize;
                    let slots = &buffers.slots[first..first + run.len()];
                    for ((slot, &place), row) in slots.iter().zip(run).zip(row..) {
                        let part = u64::from(place & ((1 << part_bits::<D>()) - 1));
                        let key = part << u32::BITS | u64::from(id[row]);
                        slot.store(key << ROW_BITS | row as u64, Relaxed);
                    }
                }
                row += run.len();
            }
        });

        self.order = place_of_row;
        self.order.resize(kept, 0);
        sort_inside_cells(&self.starts, &mut buffers.slots, &mut self.order);
        self.buffers = buffers;
        Ok(&self.order)
    }

    /// Finds the place of each row, which is its cell and part, and counts the rows per cell.
    ///
    /// Returns the first row outside the box, or `usize::MAX`.
    fn count(
        &self,
        position: &[Vec<f64>; D],
        keep: &(impl Fn(usize) -> bool + Sync),
        place_of_row: &mut [u32],
        cursor: &[AtomicU32],
    ) -> usize {
        let outside = AtomicUsize::new(usize::MAX);
        place_of_row.par_chunks_mut(CHUNK).enumerate().for_each(|(chunk, place_of)| {
            let rows = chunk * CHUNK..chunk * CHUNK + place_of.len();
            let position = std::array::from_fn(|d| &position[d][rows.clone()]);
            f64::dispatch(InstructionSet::best(), FindPlaces { grid: self, position, places: place_of });
            if let Some(held) = &self.held {
                let is_elsewhere =
                    |place: u32| place != NO_PLACE && !held.contains((place >> part_bits::<D>()) as usize);
                place_of.iter_mut().filter(|place| is_elsewhere(**place)).for_each(|place| *place = NOT_HELD);
            }
            for (group, places) in place_of.chunks_mut(GROUP).enumerate() {
                let first = chunk * CHUNK + group * GROUP;
                let rows = first..first + places.len();
                let all_inside = places.iter().fold(true, |all, &place| all & (place < NOT_HELD));
                if all_inside && rows.clone().fold(true, |all, row| all & keep(row)) {
                    continue;
                }
                for (place, row) in places.iter_mut().zip(rows) {
                    if !keep(row) || *place == NOT_HELD {
                        *place = NO_PLACE;
                    } else if *place == NO_PLACE {
                        outside.fetch_min(row, Relaxed);
                    }
                }
            }
            // Most rows are still in order: one atomic addition per run of rows is cheaper than one
            // per row.
            for run in place_of.chunk_by(same_cell::<D>) {
                if run[0] != NO_PLACE {
                    cursor[(run[0] >> part_bits::<D>()) as usize].fetch_add(run.len() as u32, Relaxed);
                }
            }
        });
        outside.into_inner()
    }
}

/// Finds the places of points: the cells that [`CellGrid::cell_of`] gives and their parts along x,
/// or [`NO_PLACE`] outside the box.
///
/// The computation is in floating point, since a conversion to integers that is correct for all
/// numbers takes more than one instruction. It is written over lanes, since the compiler vectorised
/// the scalar loop with AVX2 but not with AVX-512.
struct FindPlaces<'a, const D: usize> {
    grid: &'a CellGrid<D>,
    position: [&'a [f64]; D],
    places: &'a mut [u32],
}

impl<const D: usize> Vectorised<f64> for FindPlaces<'_, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        const { assert!(GROUP.is_multiple_of(L::COUNT)) };
        let grid = self.grid;
        let outside = L::constant(f64::NAN);
        let parts = L::constant(f64::from(PARTS));
        let last_part = L::constant(f64::from(PARTS - 1));
        let numbered = L::constant(f64::from(1_u32 << part_bits::<D>()));
        for (group, places) in self.places.chunks_mut(GROUP).enumerate() {
            let mut found = [0.0; GROUP];
            for (vector, found) in found.chunks_exact_mut(L::COUNT).enumerate() {
                let first = vector * L::COUNT;
                if first >= places.len() {
                    break;
                }
                let mut place = L::constant(0.0);
                for d in (0..D).rev() {
                    let upper = grid.upper[d];
                    let before_upper = if grid.periodic[d] { upper.next_down() } else { upper };
                    let (lower, before_upper) = (L::constant(grid.lower[d]), L::constant(before_upper));
                    let (cells, last) = (grid.cells[d] as f64, (grid.cells[d] - 1) as f64);
                    let x = L::read(&self.position[d][group * GROUP + first..]);
                    let along = (x - lower) * L::constant(grid.inverse_cell_size[d]);
                    let whole = round_down(along);
                    let last = L::constant(last);
                    // `min` is not used here: it may drop a NaN.
                    place = place * L::constant(cells) + L::select(last.less(whole), last, whole);
                    if d == 0 && part_bits::<D>() > 0 {
                        let part = round_down((along - whole) * parts).min(last_part);
                        place = place * numbered + part;
                    }
                    place = L::select(x.less(lower), outside, place);
                    place = L::select(before_upper.less(x), outside, place);
                }
                place.write(found);
            }
            for (place, &found) in places.iter_mut().zip(&found) {
                // A NaN fails the comparison and gets no place.
                let whole = (found + INTEGERS).to_bits() as u32;
                *place = if found >= 0.0 { whole } else { NO_PLACE };
            }
        }
    }
}

/// Lower end of an interval, up to twice this number, in which all `f64` are integers. Adding a
/// number to it rounds the number to an integer in the lowest bits of the sum.
const INTEGERS: f64 = (1_u64 << (f64::MANTISSA_DIGITS - 1)) as f64;

/// Returns the largest integer not above a number from 0 to [`INTEGERS`]; for other numbers the
/// result is arbitrary.
#[inline(always)]
fn round_down<L: Lanes>(x: L) -> L {
    let nearest = (x + L::constant(INTEGERS)) - L::constant(INTEGERS);
    L::select(x.less(nearest), nearest - L::constant(1.0), nearest)
}

/// Returns true if two places are in the same cell.
#[inline]
fn same_cell<const D: usize>(a: &u32, b: &u32) -> bool {
    a >> part_bits::<D>() == b >> part_bits::<D>()
}

/// Sorts the slots of each cell by part and particle number and writes their rows.
///
/// `starts` are the bounds of these cells within the whole order; `slots` and `order` hold only the
/// rows of these cells.
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
            *row = *slot.get_mut() as u32 & ((1 << ROW_BITS) - 1);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::grid::cell_set::CellSet;

    #[test]
    fn rows_are_ordered_by_cell_then_by_number() {
        let mut grid = CellGrid::new([0.0; 2], [4.0, 2.0], [false; 2], 1.0, 1.0);
        let position = [vec![3.5, 0.5, 0.4, 0.6, 1.5], vec![1.5, 0.5, 0.5, 0.5, 0.5]];
        let order = grid.build(&position, &[7, 9, 3, 5, 1], |row| row != 3).expect("all inside");
        assert_eq!(order, [2, 1, 4, 0]);
        assert_eq!(grid.starts(), [0, 2, 3, 3, 3, 3, 3, 3, 4]);
    }

    #[test]
    fn rows_of_a_cell_are_ordered_by_thirds_along_x_only_in_2d() {
        let mut grid = CellGrid::new([-1.0; 2], [1.0; 2], [false, true], 1.0, 1.0);
        // In the lower row of cells the thirds are 2, 0, 0, 2 of the first cell, then 0 and 0 of
        // the second, with one particle on its edge.
        let position = [vec![-0.1, -0.9, -0.99, -0.3, 0.3, 0.0], vec![-0.5; 6]];
        assert_eq!(grid.build(&position, &[1, 5, 4, 2, 3, 9], |_| true), Ok(&[2, 1, 0, 3, 4, 5][..]));
        let [x, y] = position;
        let mut grid = CellGrid::new([-1.0; 3], [1.0; 3], [false; 3], 1.0, 1.0);
        let position = [x, y.clone(), y];
        assert_eq!(grid.build(&position, &[1, 5, 4, 2, 3, 9], |_| true), Ok(&[0, 3, 2, 1, 4, 5][..]));
    }

    #[test]
    fn places_agree_with_cell_of_for_every_point() {
        for periodic in [[false; 2], [true; 2]] {
            let grid = CellGrid::new([-0.7, 0.1], [1.3, 0.9], periodic, 0.17, 0.17);
            let ends =
                |d: usize| [grid.lower()[d], grid.upper()[d], f64::NAN, f64::INFINITY, -3.0, 1e300, -1e-300];
            let mut along: [Vec<f64>; 2] = std::array::from_fn(|d| {
                let edges = (0..=grid.cells()[d]).map(|edge| grid.corner([edge as i64; 2])[d]);
                let all = edges.flat_map(|x| [x, x.next_up(), x.next_down(), x + 0.03, x + 0.06, x + 0.12]);
                all.chain(ends(d).into_iter().flat_map(|x| [x, x.next_up(), x.next_down()])).collect()
            });
            let count = along[0].len().min(along[1].len());
            for _ in 0..count {
                along[1].rotate_left(1);
                let position = std::array::from_fn(|d| &along[d][..count]);
                for set in InstructionSet::available() {
                    let mut places = vec![0; count];
                    f64::dispatch(set, FindPlaces { grid: &grid, position, places: &mut places });
                    for (row, place) in places.into_iter().enumerate() {
                        let point = [along[0][row], along[1][row]];
                        let Some(cell) = grid.cell_of(point) else {
                            assert_eq!(place, NO_PLACE, "{point:?}");
                            continue;
                        };
                        assert_eq!((place >> 2) as usize, cell, "{point:?}");
                        let along = (point[0] - grid.lower()[0]) / grid.cell_size()[0];
                        let part = f64::from(PARTS) * along.fract();
                        // On the edge of a part the result depends on rounding.
                        if (part - part.round()).abs() > 1e-9 {
                            assert_eq!(place & 3, part as u32, "{point:?}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn rows_of_cells_that_are_not_held_are_dropped() {
        let mut grid = CellGrid::new([0.0; 2], [4.0, 1.0], [false; 2], 1.0, 1.0);
        let mut held = CellSet::empty(grid.len());
        held.insert_run(1..3);
        grid.hold(Some(held));
        let position = [vec![3.5, 1.5, 0.4, 2.6, 1.4], vec![0.5; 5]];
        assert_eq!(grid.build(&position, &[0, 1, 2, 3, 4], |_| true), Ok(&[1, 4, 3][..]));
        assert_eq!(grid.starts(), [0, 0, 2, 3, 3]);
        let outside = [vec![3.5, 4.5], vec![0.5; 2]];
        assert_eq!(grid.build(&outside, &[0, 1], |_| true), Err(1));
        grid.hold(None);
        assert_eq!(grid.build(&position, &[0, 1, 2, 3, 4], |_| true), Ok(&[2, 1, 4, 3, 0][..]));
    }

    #[test]
    fn first_row_outside_is_reported() {
        let mut grid = CellGrid::new([0.0; 2], [1.0; 2], [false; 2], 0.5, 0.5);
        let position = [vec![0.5, f64::NAN, 2.0, 0.1], vec![0.5; 4]];
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |_| true), Err(1));
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |row| row != 1), Err(2));
        assert_eq!(grid.build(&position, &[0, 1, 2, 3], |row| row == 3), Ok(&[3][..]));
    }
}
