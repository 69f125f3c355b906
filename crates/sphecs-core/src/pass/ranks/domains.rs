//! Domains of the ranks: the cells that each owns and those whose rows it holds besides.
//!
//! A rank holds what is in reach of its own cells and the [regions](super::regions) of which it is
//! a member.

use std::ops::Range;
use std::sync::Arc;

use super::regions::Region;
use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::{CellSet, append};

/// Domains of all ranks, as one of them sees them.
#[derive(Debug)]
pub(super) struct Domains {
    /// Rank that sees them.
    rank: usize,
    /// Rank of each cell.
    owner: Vec<u16>,
    /// Members of each region, by rising number.
    pub members: Vec<Vec<usize>>,
    /// Cells that the members of a region hold.
    shared: CellSet,
    /// Regions of these cells, in the order of the cells.
    regions: Vec<(Range<usize>, usize)>,
    /// Consecutive cells of one kind, in their order; cells of other ranks as long as they have one
    /// owner.
    pub runs: Vec<Run>,
    /// Runs of the cells of each rank.
    pub owned: Vec<Vec<Range<usize>>>,
    /// Cells of this rank.
    pub own: Arc<CellSet>,
    /// Cells that this rank holds.
    pub held: CellSet,
    /// Own cells that each other rank holds.
    sent: Vec<Vec<Range<usize>>>,
    /// Cells of each other rank that this one holds.
    received: Vec<Vec<Range<usize>>>,
    /// Own cells that another rank does not hold, but some cell in reach of them: only their rows
    /// can enter what it holds in a step.
    pub bordering: Vec<Range<usize>>,
    /// Cells in reach of the bordering ones, in their order, each with its place in `holders`.
    near: Vec<(usize, usize)>,
    /// Sets of ranks that hold a cell together.
    holders: Vec<Vec<usize>>,
}

impl Domains {
    /// Returns the domains by the rank of each cell.
    pub(super) fn new<const D: usize>(
        grid: &CellGrid<D>,
        owner: Vec<u16>,
        (rank, ranks): (usize, usize),
        regions: &[Region],
    ) -> Self {
        let cells = grid.len();
        let mut owned = vec![Vec::new(); ranks];
        (0..cells).for_each(|cell| append(&mut owned[usize::from(owner[cell])], cell));
        let own = set_of(cells, &owned[rank]);
        let members: Vec<_> = regions.iter().map(|region| region.members(grid, &owner, ranks)).collect();
        let mut held = grid.in_reach_of(&own);
        let mut shared = CellSet::empty(cells);
        let mut region_of = Vec::new();
        for (index, region) in regions.iter().enumerate() {
            let reached = grid.in_reach_of(&set_of(cells, &region.cells));
            shared.insert_all(&reached);
            region_of.extend(runs_in(&reached).into_iter().map(|run| (run, index)));
            if members[index].contains(&rank) {
                held.insert_all(&reached);
            }
        }
        region_of.sort_unstable_by_key(|(run, _)| run.start);
        let mut domains = Self {
            rank,
            owner,
            members,
            shared,
            regions: region_of,
            runs: Vec::new(),
            owned,
            own: Arc::new(own),
            held,
            sent: vec![Vec::new(); ranks],
            received: vec![Vec::new(); ranks],
            bordering: Vec::new(),
            near: Vec::new(),
            holders: Vec::new(),
        };
        domains.find_neighbours(grid);
        domains.find_runs(cells);
        domains
    }

    /// Finds what the ranks send each other.
    fn find_neighbours<const D: usize>(&mut self, grid: &CellGrid<D>) {
        let own = Arc::clone(&self.own);
        let near_shared = grid.in_reach_of(&self.shared);
        // Cells that are not near others have only own cells within twice the reach.
        let twice = |cells: &CellSet| grid.in_reach_of(&grid.in_reach_of(cells));
        let mut others = CellSet::empty(grid.len());
        twice(&own).iter().filter(|&cell| !own.contains(cell)).for_each(|cell| others.insert(cell));
        let near_others = twice(&others);
        let mut around_shared = CellSet::empty(grid.len());
        let is_around = |&cell: &usize| !self.shared.contains(cell);
        near_shared.iter().filter(is_around).for_each(|cell| around_shared.insert(cell));
        let near_edge = grid.in_reach_of(&around_shared);
        let (mut holders, mut bordering) = (RankSet::new(self.owned.len()), RankSet::new(self.owned.len()));
        for cell in own.iter().filter(|&cell| near_others.contains(cell) || near_shared.contains(cell)) {
            if !near_others.contains(cell) && !near_edge.contains(cell) {
                // All cells in reach are in the same region and of this rank.
                let members = &self.members[self.region_of(cell)];
                members.iter().filter(|&&member| member != self.rank).for_each(|&member| {
                    append(&mut self.sent[member], cell);
                });
                continue;
            }
            self.find_holders(grid, cell, &mut holders);
            holders.ranks().filter(|&other| other != self.rank).for_each(|other| {
                append(&mut self.sent[other], cell);
            });
            bordering.clear();
            // Who holds a cell in reach owns one within twice the reach or is a member of its
            // region.
            grid.for_each_around(cell, 2, |near| bordering.insert(usize::from(self.owner[near])));
            if near_shared.contains(cell) {
                grid.for_each_around(cell, 1, |near| self.insert_members(near, &mut bordering));
            }
            if bordering.ranks().any(|other| other != self.rank && !holders.has(other)) {
                append(&mut self.bordering, cell);
            }
        }
        for cell in self.held.iter().filter(|&cell| !own.contains(cell)) {
            append(&mut self.received[usize::from(self.owner[cell])], cell);
        }
        for cell in grid.in_reach_of(&set_of(grid.len(), &self.bordering)).iter() {
            self.find_holders(grid, cell, &mut holders);
            let mut ranks: Vec<usize> = holders.ranks().collect();
            ranks.sort_unstable();
            let known = self.holders.iter().rposition(|known| *known == ranks);
            self.near.push((cell, known.unwrap_or(self.holders.len())));
            if known.is_none() {
                self.holders.push(ranks);
            }
        }
    }

    /// Finds the runs of cells of one kind in a grid of `cells` cells.
    fn find_runs(&mut self, cells: usize) {
        let mut sent = CellSet::empty(cells);
        self.sent.iter().flatten().for_each(|run| sent.insert_run(run.clone()));
        let own = self.owned[self.rank].iter().flat_map(Clone::clone);
        let kind = |cell: usize| if sent.contains(cell) { Kind::Sent } else { Kind::Inner };
        let others = self.owned.iter().enumerate().filter(|(rank, _)| *rank != self.rank);
        let others = others.flat_map(|(_, runs)| runs.iter().cloned());
        let mut runs: Vec<Run> = others.map(|cells| Run { cells, kind: Kind::Other }).collect();
        let mut last: Option<Run> = None;
        for cell in own {
            match &mut last {
                Some(run) if run.cells.end == cell && run.kind == kind(cell) => run.cells.end += 1,
                _ => runs.extend(last.replace(Run { cells: cell..cell + 1, kind: kind(cell) })),
            }
        }
        runs.extend(last);
        runs.sort_unstable_by_key(|run| run.cells.start);
        self.runs = runs;
    }

    /// Returns the ranks that hold the cell `to` but not the bordering cell `from`; None if `to` is
    /// out of reach of all bordering cells.
    pub(super) fn new_holders(&self, from: usize, to: usize) -> Option<impl Iterator<Item = usize>> {
        let place = |cell: usize| {
            let found = self.near.binary_search_by_key(&cell, |(cell, _)| *cell).ok()?;
            Some(self.near[found].1)
        };
        let (from, to) = (&self.holders[place(from)?], &self.holders[place(to)?]);
        Some(to.iter().copied().filter(|rank| from.binary_search(rank).is_err()))
    }

    /// Finds the ranks that hold a cell.
    pub(super) fn find_holders<const D: usize>(
        &self,
        grid: &CellGrid<D>,
        cell: usize,
        holders: &mut RankSet,
    ) {
        holders.clear();
        self.insert_members(cell, holders);
        grid.for_each_around(cell, 1, |near| holders.insert(usize::from(self.owner[near])));
    }

    /// Adds the members of the region of a cell, if it is in one.
    fn insert_members(&self, cell: usize, to: &mut RankSet) {
        if self.shared.contains(cell) {
            self.members[self.region_of(cell)].iter().for_each(|&member| to.insert(member));
        }
    }

    /// Returns the region of a cell that is in one.
    fn region_of(&self, cell: usize) -> usize {
        self.regions[self.regions.partition_point(|(run, _)| run.end <= cell)].1
    }

    /// Returns the own cells whose rows another rank holds; rank 0 holds all where `observed`.
    pub(super) fn sent_to(&self, other: usize, observed: bool) -> &[Range<usize>] {
        if observed && other == 0 && self.rank != 0 { &self.owned[self.rank] } else { &self.sent[other] }
    }

    /// Returns the cells of another rank whose rows this one holds; rank 0 holds all where
    /// `observed`.
    pub(super) fn received_from(&self, other: usize, observed: bool) -> &[Range<usize>] {
        if observed && self.rank == 0 && other != 0 { &self.owned[other] } else { &self.received[other] }
    }
}

/// Consecutive cells of one kind.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Run {
    pub cells: Range<usize>,
    pub kind: Kind,
}

/// Kind of a cell, as a rank sees it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    /// Own cell that another rank holds.
    Sent,
    /// Own cell that no other rank holds.
    Inner,
    /// Cell of another rank.
    Other,
}

/// Set of ranks that is filled often.
#[derive(Debug)]
pub(super) struct RankSet {
    has: Vec<bool>,
    ranks: Vec<usize>,
}

impl RankSet {
    /// Returns the empty set of a number of ranks.
    pub(super) fn new(ranks: usize) -> Self {
        Self { has: vec![false; ranks], ranks: Vec::new() }
    }

    /// Returns true if a rank is in the set.
    pub(super) fn has(&self, rank: usize) -> bool {
        self.has[rank]
    }

    /// Returns the ranks of the set.
    pub(super) fn ranks(&self) -> impl Iterator<Item = usize> + '_ {
        self.ranks.iter().copied()
    }

    fn clear(&mut self) {
        self.ranks.drain(..).for_each(|rank| self.has[rank] = false);
    }

    pub(super) fn insert(&mut self, rank: usize) {
        if !std::mem::replace(&mut self.has[rank], true) {
            self.ranks.push(rank);
        }
    }
}

/// Returns the runs of consecutive cells of a set.
fn runs_in(cells: &CellSet) -> Vec<Range<usize>> {
    let mut runs = Vec::new();
    cells.iter().for_each(|cell| append(&mut runs, cell));
    runs
}

/// Returns the cells of runs as a set of a grid of `cells` cells.
pub(super) fn set_of(cells: usize, runs: &[Range<usize>]) -> CellSet {
    let mut set = CellSet::empty(cells);
    runs.iter().for_each(|run| set.insert_run(run.clone()));
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::grid::cell_set::runs_of;

    /// A row of 12 cells, of which three ranks own four each, with regions around cells.
    fn of_rank(rank: usize, around: &[usize]) -> Domains {
        let grid = CellGrid::<2>::new([0.0; 2], [12.0, 1.0], [false; 2], 1.0, 1.0);
        let owner: Vec<u16> = (0..12).map(|cell| cell / 4).collect();
        let cells = runs_of(0..12, |cell| around.contains(&cell));
        Domains::new(&grid, owner, (rank, 3), &Region::divide(&grid, &cells, &cells))
    }

    fn cells(runs: &[Range<usize>]) -> Vec<usize> {
        runs.iter().flat_map(Clone::clone).collect()
    }

    #[test]
    fn ranks_hold_what_their_cells_reach() {
        let domains = of_rank(1, &[]);
        assert_eq!(cells(&domains.owned[1]), [4, 5, 6, 7]);
        assert_eq!(cells(domains.sent_to(0, false)), [4]);
        assert_eq!(cells(domains.sent_to(2, false)), [7]);
        assert_eq!(cells(domains.received_from(0, false)), [3]);
        assert_eq!(cells(&domains.bordering), [5, 6]);
        assert_eq!(cells(domains.sent_to(0, true)), [4, 5, 6, 7]);
        assert_eq!(cells(domains.sent_to(2, true)), [7]);
        assert_eq!(cells(of_rank(0, &[]).received_from(2, true)), [8, 9, 10, 11]);
        assert!(of_rank(0, &[]).received_from(2, false).is_empty());
    }

    #[test]
    fn runs_are_all_cells_by_their_kind() {
        let run = |cells: Range<usize>, kind: Kind| Run { cells, kind };
        assert_eq!(
            of_rank(1, &[]).runs,
            [
                run(0..4, Kind::Other),
                run(4..5, Kind::Sent),
                run(5..7, Kind::Inner),
                run(7..8, Kind::Sent),
                run(8..12, Kind::Other),
            ]
        );
    }

    #[test]
    fn members_of_a_region_hold_it_with_its_neighbours() {
        let domains = of_rank(1, &[9]);
        assert_eq!(domains.members, [[2]]);
        assert_eq!(cells(domains.received_from(2, false)), [8]);
        let domains = of_rank(1, &[8, 9]);
        assert_eq!(domains.members, [[1, 2]]);
        assert_eq!(cells(domains.received_from(2, false)), [8, 9, 10]);
        assert_eq!(cells(domains.sent_to(0, false)), [4]);
        assert_eq!(cells(domains.sent_to(2, false)), [7]);
        assert!(of_rank(0, &[8, 9]).received_from(2, false).is_empty());
        assert_eq!(cells(&domains.bordering), [5, 6]);
    }

    #[test]
    fn both_sides_name_the_same_cells_of_a_wide_region() {
        let grid = CellGrid::<2>::new([0.0; 2], [30.0, 20.0], [false, true], 1.0, 1.0);
        let owner = |cell: usize| if cell % 30 < 14 { cell / 30 / 10 } else { 2 };
        let wide = runs_of(0..grid.len(), |cell| (2..17).contains(&(cell % 30)));
        for core in [65, 30 * 5 + 15] {
            let regions = Region::divide(&grid, &runs_of(core..core + 1, |_| true), &wide);
            let of_rank = |rank: usize| {
                let owner = (0..grid.len()).map(|cell| owner(cell) as u16).collect();
                Domains::new(&grid, owner, (rank, 3), &regions)
            };
            let all = [0, 1, 2].map(of_rank);
            assert!(all[2].members[0].len() < 3, "{:?}", all[2].members);
            for from in 0..3 {
                for to in (0..3).filter(|to| *to != from) {
                    assert_eq!(all[from].sent_to(to, false), all[to].received_from(from, false));
                }
            }
        }
    }

    #[test]
    fn both_sides_name_the_same_cells() {
        for around in [vec![], vec![0, 6, 7], vec![1, 8]] {
            for from in 0..3 {
                for to in (0..3).filter(|to| *to != from) {
                    for observed in [false, true] {
                        let (sender, receiver) = (of_rank(from, &around), of_rank(to, &around));
                        assert_eq!(sender.sent_to(to, observed), receiver.received_from(from, observed));
                    }
                }
            }
        }
    }
}
