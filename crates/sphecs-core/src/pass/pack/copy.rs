//! Filling of a pack, run by run and vector by vector, all columns of one vector before the next.

use std::ops::Range;

use super::{Only, Pack, Run, Source};
use crate::math::lanes::{Lanes, MOST_LANES};
use crate::math::real::Real;

impl<R: Real> Pack<R> {
    /// Copies the runs one after another; returns the number of their particles.
    #[inline(always)]
    pub(super) fn copy_all<L: Lanes<Real = R>, const D: usize>(&mut self, source: &Source<R, D>) -> usize {
        let total = source.position[0].len();
        let base = self.storage[self.begin..].as_mut_ptr();
        let mut len = 0;
        for &Run { start, end, shift } in &self.runs {
            let mut origin = [0.0; D];
            for d in 0..D {
                origin[d] = self.centre[d] - shift[d];
            }
            // SAFETY: `reserve` reserved space for all candidates, each run rounded up to whole
            // vectors.
            unsafe {
                let to = base.add(len);
                // The last rows of the arrays are copied before they are read.
                if start + (end - start).next_multiple_of(L::COUNT) <= total {
                    copy_run::<L, D, true>(source, start..end, origin, to, self.stride);
                } else {
                    copy_run::<L, D, false>(source, start..end, origin, to, self.stride);
                }
            }
            len += end - start;
        }
        len
    }

    /// Copies the wanted particles of the runs within reach of a box of this `size`, m, about the
    /// centre; returns their number.
    #[inline(always)]
    pub(super) fn copy_near<L: Lanes<Real = R>, const D: usize>(
        &mut self,
        source: &Source<R, D>,
        size: [f64; D],
    ) -> usize {
        let base = self.storage[self.begin..].as_mut_ptr();
        let limit = L::constant(source.support_ratio * source.support_ratio);
        let mut half = [L::constant(0.0); D];
        for d in 0..D {
            // The margin covers the rounding of f32 coordinates.
            half[d] = L::constant(0.5 * size[d] * source.inverse_h + 1e-5);
        }
        let zero = L::constant(0.0);
        let columns = source.columns.len();
        let mut len = 0;
        for &Run { start, end, shift } in &self.runs {
            let mut row = start;
            while row < end {
                let count = L::COUNT.min(end - row);
                let mut x = [zero; D];
                let mut beyond = zero;
                for d in 0..D {
                    let origin = self.centre[d] - shift[d];
                    x[d] = load_relative_rows(&source.position[d], row, origin, source.inverse_h);
                    let outside = (x[d].abs() - half[d]).max(zero);
                    beyond = outside.mul_add(outside, beyond);
                }
                let wanted = match source.only {
                    Only::All => beyond,
                    Only::Positive(column, _) => L::select(zero.less(L::read(&column[row..])), beyond, limit),
                    Only::NotPositive(column, _) => {
                        L::select(zero.less(L::read(&column[row..])), limit, beyond)
                    }
                };
                let near = wanted.less(limit);
                let kept = (L::bits(near) & ((1u32 << count) - 1)).count_ones() as usize;
                if kept > 0 {
                    for column in 0..D + columns {
                        let values =
                            if column < D { x[column] } else { L::read(&source.columns[column - D][row..]) };
                        // SAFETY: `reserve` reserved space for all candidates, each run rounded up
                        // to whole vectors.
                        unsafe { values.compress(near, base.add(column * self.stride + len)) };
                    }
                }
                len += kept;
                row += L::COUNT;
            }
        }
        len
    }
}

/// Copies the rows of a run to `to`, all columns `stride` apart; `WHOLE`: whole vectors can be read
/// from the first row on.
///
/// # Safety
/// If `WHOLE`, the columns must have enough rows for whole vectors. There must be space for whole
/// vectors at `to`.
#[inline(always)]
unsafe fn copy_run<L: Lanes, const D: usize, const WHOLE: bool>(
    source: &Source<L::Real, D>,
    rows: Range<usize>,
    origin: [f64; D],
    to: *mut L::Real,
    stride: usize,
) {
    for (vector, row) in rows.step_by(L::COUNT).enumerate() {
        let scale = source.inverse_h;
        // The columns are the inner loop: their number is constant, so only the end of a run is
        // mispredicted. SAFETY: the caller guarantees it.
        unsafe {
            let mut to = to.add(vector * L::COUNT);
            for d in 0..D {
                let positions = &source.position[d];
                let x: L = if WHOLE {
                    L::load_relative(positions.as_ptr().add(row), origin[d], scale)
                } else {
                    load_relative_rows(positions, row, origin[d], scale)
                };
                x.store(to);
                to = to.add(stride);
            }
            for column in source.columns {
                let values: L =
                    if WHOLE { L::load(column.as_ptr().add(row)) } else { L::read(&column[row..]) };
                values.store(to);
                to = to.add(stride);
            }
        }
    }
}

/// Returns the positions from a row on relative to an origin, in units of 1/`scale`.
#[inline(always)]
fn load_relative_rows<L: Lanes>(positions: &[f64], row: usize, origin: f64, scale: f64) -> L {
    // SAFETY: `COUNT` numbers follow `row`, or a padded copy is read.
    unsafe {
        if row + L::COUNT <= positions.len() {
            L::load_relative(positions.as_ptr().add(row), origin, scale)
        } else {
            L::load_relative(padded(&positions[row..]).as_ptr(), origin, scale)
        }
    }
}

/// Returns the numbers followed by zeros, for the last rows of the arrays.
#[inline(always)]
fn padded(numbers: &[f64]) -> [f64; MOST_LANES] {
    let mut copy = [0.0; MOST_LANES];
    let count = numbers.len().min(MOST_LANES);
    copy[..count].copy_from_slice(&numbers[..count]);
    copy
}
