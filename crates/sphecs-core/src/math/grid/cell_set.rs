//! Sets of cells.

use std::ops::Range;

use super::CellGrid;

/// Set of cells of a grid.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct CellSet {
    bits: Vec<u64>,
}

impl CellSet {
    /// Returns the empty set of a grid of `cells` cells.
    pub fn empty(cells: usize) -> Self {
        Self { bits: vec![0; cells.div_ceil(u64::BITS as usize)] }
    }

    /// Returns true if a cell is in the set.
    #[inline]
    pub fn contains(&self, cell: usize) -> bool {
        let (word, bit) = place(cell);
        self.bits[word] & bit != 0
    }

    /// Adds a cell.
    #[inline]
    pub fn insert(&mut self, cell: usize) {
        let (word, bit) = place(cell);
        self.bits[word] |= bit;
    }

    /// Adds consecutive cells.
    pub fn insert_run(&mut self, cells: Range<usize>) {
        cells.for_each(|cell| self.insert(cell));
    }

    /// Adds the cells of another set of the same grid.
    pub fn insert_all(&mut self, other: &Self) {
        self.bits.iter_mut().zip(&other.bits).for_each(|(bits, other)| *bits |= other);
    }
}

/// Returns word and bit of a cell.
#[inline]
fn place(cell: usize) -> (usize, u64) {
    (cell / u64::BITS as usize, 1 << (cell % u64::BITS as usize))
}

/// Returns the runs of consecutive cells of a range for which `is_wanted` is true.
pub fn runs_of(cells: Range<usize>, is_wanted: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut runs: Vec<Range<usize>> = Vec::new();
    for cell in cells.filter(|&cell| is_wanted(cell)) {
        match runs.last_mut() {
            Some(last) if last.end == cell => last.end += 1,
            _ => runs.push(cell..cell + 1),
        }
    }
    runs
}

impl<const D: usize> CellGrid<D> {
    /// Returns the cells of a set and all cells that may have a neighbour in one of them.
    pub fn in_reach_of(&self, set: &CellSet) -> CellSet {
        let mut reached = set.clone();
        // One axis after the other makes a box of cells around each.
        for axis in 0..D {
            let before = reached.clone();
            for cell in (0..self.len()).filter(|&cell| before.contains(cell)) {
                let index = self.index_of(cell);
                for step in -self.reach[axis]..=self.reach[axis] {
                    let mut other = index;
                    other[axis] += step;
                    if let Some(other) = self.wrapped_cell(other) {
                        reached.insert(other);
                    }
                }
            }
        }
        reached
    }

    /// Returns the cell of an unwrapped index; None outside the box.
    fn wrapped_cell(&self, index: [i64; D]) -> Option<usize> {
        let mut cell = 0;
        for axis in (0..D).rev() {
            let cells = self.cells[axis] as i64;
            let along = if self.periodic[axis] { index[axis].rem_euclid(cells) } else { index[axis] };
            if !(0..cells).contains(&along) {
                return None;
            }
            cell = cell * self.cells[axis] + along as usize;
        }
        Some(cell)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_in_reach_are_the_boxes_around_cells() {
        let grid = CellGrid::new([0.0; 2], [8.0, 6.0], [true, false], 1.0, 1.0);
        let mut set = CellSet::empty(grid.len());
        set.insert(0);
        let reached = grid.in_reach_of(&set);
        let found: Vec<usize> = (0..grid.len()).filter(|&cell| reached.contains(cell)).collect();
        assert_eq!(found, [0, 1, 7, 8, 9, 15]);
        assert_eq!(runs_of(0..grid.len(), |cell| reached.contains(cell)), [0..2, 7..10, 15..16]);
    }

    #[test]
    fn set_has_the_cells_that_were_inserted() {
        let (mut set, mut other) = (CellSet::empty(200), CellSet::empty(200));
        set.insert_run(60..70);
        other.insert(199);
        set.insert_all(&other);
        let found: Vec<usize> = (0..200).filter(|&cell| set.contains(cell)).collect();
        assert_eq!(found, (60..70).chain([199]).collect::<Vec<_>>());
    }
}
