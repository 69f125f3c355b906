//! Regions that a rank holds whole or not at all, such as those around openings.
//!
//! ```text
//! rank r is a member of the region k if R(own(r)) has a cell of core(k)
//! held(r) = R(own(r) ∪ cells(k) of all regions k of which r is a member)
//! ```
//!
//! R(C) are the cells of C and all in reach of them. A rank that is no member holds no particle of
//! the core. Every member holds all particles that work in the core reads, so all members can do
//! that work alike.

use std::ops::Range;

use super::Ranks;
use super::domains::{RankSet, set_of};
use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::{CellSet, append};

/// Cells that a rank holds whole or not at all.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Region {
    /// Cells whose holders are members.
    pub core: Vec<Range<usize>>,
    /// Cells that members hold, with what is in reach of them; those of the core are among them.
    pub cells: Vec<Range<usize>>,
}

impl Region {
    /// Divides cells, those of the core among them, into regions. Cells belong to one region if
    /// what is in reach of them overlaps or touches.
    pub fn divide<const D: usize>(
        grid: &CellGrid<D>,
        core: &[Range<usize>],
        cells: &[Range<usize>],
    ) -> Vec<Self> {
        let (core, cells) = (set_of(grid.len(), core), set_of(grid.len(), cells));
        let reached = grid.in_reach_of(&cells);
        let mut found = CellSet::empty(grid.len());
        let mut regions = Vec::new();
        for first in reached.iter() {
            if found.contains(first) {
                continue;
            }
            let mut connected = CellSet::empty(grid.len());
            let mut next = vec![first];
            connected.insert(first);
            while let Some(cell) = next.pop() {
                grid.for_each_around(cell, 1, |near| {
                    if reached.contains(near) && !connected.contains(near) {
                        connected.insert(near);
                        next.push(near);
                    }
                });
            }
            let mut region = Self::default();
            for cell in connected.iter() {
                found.insert(cell);
                if core.contains(cell) {
                    append(&mut region.core, cell);
                }
                if cells.contains(cell) {
                    append(&mut region.cells, cell);
                }
            }
            regions.push(region);
        }
        regions
    }

    /// Returns the ranks that are members by the rank of each cell, by rising number.
    pub(super) fn members<const D: usize>(
        &self,
        grid: &CellGrid<D>,
        owner: &[u16],
        ranks: usize,
    ) -> Vec<usize> {
        let mut members = RankSet::new(ranks);
        let near = grid.in_reach_of(&set_of(grid.len(), &self.core));
        near.iter().for_each(|cell| members.insert(usize::from(owner[cell])));
        let mut members: Vec<usize> = members.ranks().collect();
        members.sort_unstable();
        members
    }
}

/// Returns the cells that a rank holds, which owns the cells `own`, by the rank of each cell.
pub(super) fn held<const D: usize>(
    grid: &CellGrid<D>,
    own: &CellSet,
    (rank, owner, ranks): (usize, &[u16], usize),
    regions: &[Region],
) -> CellSet {
    let mut cells = own.clone();
    for region in regions {
        if region.members(grid, owner, ranks).contains(&rank) {
            cells.insert_all(&set_of(grid.len(), &region.cells));
        }
    }
    grid.in_reach_of(&cells)
}

impl Ranks {
    /// Returns the ranks that share the work at the points of a region, of which this one must be a
    /// member; without a region each rank does all of it.
    #[must_use]
    pub fn of_region(&self, region: Option<usize>) -> Self {
        Self { group: self.group.clone(), region }
    }

    /// Returns the first member of each region that has members, else rank 0; nothing on one rank
    /// alone and before the first sort.
    pub fn leaders(&self) -> Vec<usize> {
        self.of_regions(|members| members.first().copied().unwrap_or(0))
    }

    /// Returns for each region whether this rank is a member; nothing on one rank alone and before
    /// the first sort.
    pub fn memberships(&self) -> Vec<bool> {
        let rank = self.rank();
        self.of_regions(|members| members.contains(&rank))
    }

    fn of_regions<T>(&self, value: impl Fn(&[usize]) -> T) -> Vec<T> {
        let Some(group) = &self.group else { return Vec::new() };
        let state = group.state();
        let members = state.domains.iter().flat_map(|domains| &domains.members);
        members.map(|members| value(members)).collect()
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::math::grid::cell_set::runs_of;

    /// Returns a region of consecutive cells.
    pub(in crate::pass::ranks) fn region(core: Range<usize>, cells: Range<usize>) -> Region {
        let run = |cells: Range<usize>| std::iter::once(cells).collect();
        Region { core: run(core), cells: run(cells) }
    }

    #[test]
    fn regions_that_touch_are_one() {
        let grid = CellGrid::<2>::new([0.0; 2], [14.0, 1.0], [false; 2], 1.0, 1.0);
        let runs = |cells: &[usize]| runs_of(0..14, |cell| cells.contains(&cell));
        // In reach are 0 to 3, 4 to 7 and 10 to 13.
        let regions = Region::divide(&grid, &runs(&[1, 5, 12]), &runs(&[1, 2, 5, 6, 11, 12, 13]));
        assert_eq!(
            regions,
            [Region { core: vec![1..2, 5..6], cells: vec![1..3, 5..7] }, region(12..13, 11..14),]
        );
        assert_eq!(Region::divide(&grid, &[], &[]), []);
    }

    #[test]
    fn members_hold_a_cell_of_the_core() {
        let grid = CellGrid::<2>::new([0.0; 2], [12.0, 1.0], [false; 2], 1.0, 1.0);
        let owner: Vec<u16> = (0..12).map(|cell| cell / 4).collect();
        let core = |cell: usize| region(cell..cell + 1, cell..cell + 1);
        assert_eq!(core(1).members(&grid, &owner, 3), [0]);
        assert_eq!(core(3).members(&grid, &owner, 3), [0, 1]);
        assert_eq!(core(8).members(&grid, &owner, 3), [1, 2]);
    }
}
