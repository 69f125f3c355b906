//! Columns and rows that a pack is made from.

use std::ops::Range;

use crate::math::grid::CellGrid;

/// Columns that a neighbourhood is packed from.
#[derive(Clone, Copy, Debug)]
pub struct Source<'a, R, const D: usize> {
    /// Grid that the rows are sorted by.
    pub grid: &'a CellGrid<D>,
    /// Position, m.
    pub position: &'a [Vec<f64>; D],
    /// Further columns, in the order in which the pair loop uses them.
    pub columns: &'a [&'a [R]],
    /// 1/h, 1/m.
    pub inverse_h: f64,
    /// Radius of the support over h.
    pub support_ratio: f64,
    /// Rows that are packed.
    pub only: Only<'a, R>,
}

/// Rows that are packed. A pass over walls alone, or over all other particles, has shorter loops.
#[derive(Clone, Copy, Debug)]
pub enum Only<'a, R> {
    /// All rows.
    All,
    /// Rows with a positive number in the first column. The second has the number of such rows
    /// before each row, and of all at the end; it may be empty.
    Positive(&'a [R], &'a [u32]),
    /// Rows without a positive number in the first column; the second as above.
    NotPositive(&'a [R], &'a [u32]),
}

impl<'a, R> Only<'a, R> {
    /// Returns the column that selects the rows.
    pub(super) fn column(self) -> Option<&'a [R]> {
        match self {
            Only::All => None,
            Only::Positive(column, _) | Only::NotPositive(column, _) => Some(column),
        }
    }

    /// Returns true if any of the rows is packed; true where the numbers before each row are not
    /// given.
    #[inline(always)]
    pub(super) fn any(self, rows: &Range<usize>) -> bool {
        let positive = |before: &[u32]| (before[rows.end] - before[rows.start]) as usize;
        match self {
            Only::All => true,
            Only::Positive(_, before) => before.is_empty() || positive(before) > 0,
            Only::NotPositive(_, before) => before.is_empty() || positive(before) < rows.len(),
        }
    }
}
