//! What a pack is made from, and which rows it takes up.

use std::ops::Range;

use crate::math::grid::CellGrid;

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
    /// Those that have more than 0 in this column; how many those before each row are, and all at the end, or nothing.
    Positive(&'a [R], &'a [u32]),
    /// Those that have not.
    NotPositive(&'a [R], &'a [u32]),
}

impl<'a, R> Only<'a, R> {
    pub(super) fn column(self) -> Option<&'a [R]> {
        match self {
            Only::All => None,
            Only::Positive(column, _) | Only::NotPositive(column, _) => Some(column),
        }
    }

    /// Whether any of the rows is packed, as far as the numbers before each row tell.
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
