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

    /// Returns the cells in their order.
    pub fn iter(&self) -> impl Iterator<Item = usize> + '_ {
        let width = u64::BITS as usize;
        self.bits.iter().enumerate().filter(|(_, bits)| **bits != 0).flat_map(move |(word, &bits)| {
            (0..width).filter(move |bit| bits >> bit & 1 != 0).map(move |bit| width * word + bit)
        })
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
    let mut runs = Vec::new();
    cells.filter(|&cell| is_wanted(cell)).for_each(|cell| append(&mut runs, cell));
    runs
}

/// Appends a cell behind all others to runs of consecutive cells.
pub fn append(runs: &mut Vec<Range<usize>>, cell: usize) {
    match runs.last_mut() {
        Some(last) if last.end == cell => last.end += 1,
        _ => runs.push(cell..cell + 1),
    }
}

impl<const D: usize> CellGrid<D> {
    /// Returns the cells of a set and all cells that may have a neighbour in one of them.
    pub fn in_reach_of(&self, set: &CellSet) -> CellSet {
        let mut reached = set.clone();
        // One axis after the other makes a box of cells around each.
        for axis in 0..D {
            let before = reached.clone();
            for cell in before.iter() {
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

    /// Calls `visit` with a cell and all cells around it, up to `reaches` times the reach; in a
    /// short period some are visited twice.
    pub fn for_each_around(&self, cell: usize, reaches: i64, mut visit: impl FnMut(usize)) {
        let index = self.index_of(cell);
        let layers = self.reach.map(|reach| reaches * reach);
        let mut step = layers.map(|layers| -layers);
        loop {
            if let Some(other) = self.wrapped_cell(std::array::from_fn(|axis| index[axis] + step[axis])) {
                visit(other);
            }
            // The next step of the box, the first axis fastest.
            let Some(axis) = (0..D).find(|&axis| step[axis] < layers[axis]) else { return };
            step[axis] += 1;
            for before in 0..axis {
                step[before] = -layers[before];
            }
        }
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
        let mut around = Vec::new();
        grid.for_each_around(0, 1, |cell| around.push(cell));
        assert_eq!(around, [7, 0, 1, 15, 8, 9]);
        around.clear();
        grid.for_each_around(20, 2, |cell| around.push(cell));
        assert_eq!((around.len(), around[0], around[24]), (25, 2, 38));
        assert_eq!(runs_of(0..grid.len(), |cell| reached.contains(cell)), [0..2, 7..10, 15..16]);
    }

    #[test]
    fn set_has_the_cells_that_were_inserted() {
        let (mut set, mut other) = (CellSet::empty(200), CellSet::empty(200));
        set.insert_run(60..70);
        other.insert(199);
        set.insert_all(&other);
        let found: Vec<usize> = (0..200).filter(|&cell| set.contains(cell)).collect();
        assert!(set.iter().eq(found.iter().copied()));
        assert_eq!(found, (60..70).chain([199]).collect::<Vec<_>>());
    }
}
