//! Domains of the ranks: the cells that each owns and those whose rows it holds besides.
//!
//! ```text
//! held(r) = R(own(r) ∪ S),   R(C): the cells of C and all in reach of them
//! ```
//!
//! S are cells that all ranks hold, such as those near openings, so that everything there can be
//! done by every rank alike.

use std::ops::Range;
use std::sync::Arc;

use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::{CellSet, runs_of};

/// Domains of all ranks, as one of them sees them.
#[derive(Debug)]
pub(super) struct Domains {
    /// Rank that sees them.
    rank: usize,
    /// Consecutive cells of one rank, in their order.
    pub runs: Vec<(Range<usize>, usize)>,
    /// Runs of the cells of each rank.
    pub owned: Vec<Vec<Range<usize>>>,
    /// Cells of this rank.
    pub own: Arc<CellSet>,
    /// Cells that each rank holds.
    pub held: Vec<CellSet>,
    /// Own cells that each other rank holds.
    sent: Vec<Vec<Range<usize>>>,
    /// Cells of each other rank that this one holds.
    received: Vec<Vec<Range<usize>>>,
    /// Own cells that each other rank does not hold, but some cell in reach of them: only their
    /// rows can enter what it holds in a step.
    pub bordering: Vec<Vec<Range<usize>>>,
}

impl Domains {
    /// Returns the domains by the rank of each cell; all ranks hold the cells `everywhere`.
    pub(super) fn new<const D: usize>(
        grid: &CellGrid<D>,
        owner: &[u16],
        (rank, ranks): (usize, usize),
        everywhere: &[Range<usize>],
    ) -> Self {
        let cells = grid.len();
        let of = |rank: usize| move |cell: usize| usize::from(owner[cell]) == rank;
        let owned: Vec<_> = (0..ranks).map(|rank| runs_of(0..cells, of(rank))).collect();
        let mut runs: Vec<_> = (0..)
            .zip(&owned)
            .flat_map(|(rank, own)| own.iter().map(move |run| (run.clone(), rank)))
            .collect();
        runs.sort_unstable_by_key(|(run, _)| run.start);
        let set = |runs: &[Range<usize>]| set_of(cells, runs);
        let everywhere = set(everywhere);
        let held: Vec<CellSet> = owned.iter().map(|own| held_with(grid, &set(own), &everywhere)).collect();
        let others = |runs: &dyn Fn(usize) -> Vec<Range<usize>>| {
            (0..ranks).map(|other| if other == rank { Vec::new() } else { runs(other) }).collect::<Vec<_>>()
        };
        let is_own = of(rank);
        Self {
            rank,
            sent: others(&|other| runs_of(0..cells, |cell| is_own(cell) && held[other].contains(cell))),
            received: others(&|other| {
                let is_theirs = of(other);
                runs_of(0..cells, |cell| is_theirs(cell) && held[rank].contains(cell))
            }),
            bordering: others(&|other| {
                let near = grid.in_reach_of(&held[other]);
                let borders = |cell| is_own(cell) && !held[other].contains(cell) && near.contains(cell);
                runs_of(0..cells, borders)
            }),
            own: Arc::new(set(&owned[rank])),
            runs,
            owned,
            held,
        }
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

/// Returns the cells that a rank holds that owns the cells `own`, where all ranks hold `everywhere`.
pub(super) fn held_with<const D: usize>(grid: &CellGrid<D>, own: &CellSet, everywhere: &CellSet) -> CellSet {
    let mut cells = own.clone();
    cells.insert_all(everywhere);
    grid.in_reach_of(&cells)
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

    /// A row of 12 cells, of which three ranks own four each.
    fn of_rank(rank: usize, everywhere: &[usize]) -> Domains {
        let grid = CellGrid::<2>::new([0.0; 2], [12.0, 1.0], [false; 2], 1.0, 1.0);
        let owner: Vec<u16> = (0..12).map(|cell| cell / 4).collect();
        Domains::new(&grid, &owner, (rank, 3), &runs_of(0..12, |cell| everywhere.contains(&cell)))
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
        assert_eq!(cells(&domains.bordering[0]), [5]);
        assert_eq!(cells(domains.sent_to(0, true)), [4, 5, 6, 7]);
        assert_eq!(cells(domains.sent_to(2, true)), [7]);
        assert_eq!(cells(of_rank(0, &[]).received_from(2, true)), [8, 9, 10, 11]);
        assert!(of_rank(0, &[]).received_from(2, false).is_empty());
    }

    #[test]
    fn cells_everywhere_are_held_with_their_neighbours() {
        let domains = of_rank(1, &[10]);
        assert_eq!(cells(domains.received_from(2, false)), [8, 9, 10, 11]);
        assert_eq!(cells(domains.sent_to(0, false)), [4]);
        assert_eq!(cells(of_rank(0, &[10]).received_from(2, false)), [9, 10, 11]);
    }

    #[test]
    fn both_sides_name_the_same_cells() {
        for everywhere in [vec![], vec![0, 6, 7]] {
            for from in 0..3 {
                for to in (0..3).filter(|to| *to != from) {
                    for observed in [false, true] {
                        let (sender, receiver) = (of_rank(from, &everywhere), of_rank(to, &everywhere));
                        assert_eq!(sender.sent_to(to, observed), receiver.received_from(from, observed));
                    }
                }
            }
        }
    }
}
