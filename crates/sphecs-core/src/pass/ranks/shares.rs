//! Particles that each of a number of ranks would own and hold.

use super::bisection::bisect;
use super::regions::{Region, held};
use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::CellSet;

/// Particles of a rank.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Share {
    /// Particles that it sums for.
    pub own: u64,
    /// Particles that it holds, its own included.
    pub held: u64,
}

/// Returns the shares of ranks in particles at positions, m, of a number of ranks with domains of
/// equal numbers of particles.
pub fn shares<const D: usize>(
    grid: &CellGrid<D>,
    positions: impl Iterator<Item = [f64; D]>,
    regions: &[Region],
    ranks: usize,
) -> Vec<Share> {
    let mut counts = vec![0_u32; grid.len()];
    positions.filter_map(|place| grid.cell_of(place)).for_each(|cell| counts[cell] += 1);
    let costs: Vec<f64> = counts.iter().map(|&count| f64::from(count)).collect();
    let owner = bisect(grid, &costs, ranks);
    let share = |rank: usize| {
        let is_own = |&cell: &usize| usize::from(owner[cell]) == rank;
        let mut own = CellSet::empty(grid.len());
        (0..grid.len()).filter(is_own).for_each(|cell| own.insert(cell));
        let held = held(grid, &own, (rank, &owner, ranks), regions);
        let count = |set: &CellSet| {
            (0..grid.len()).filter(|&cell| set.contains(cell)).map(|cell| u64::from(counts[cell])).sum()
        };
        Share { own: count(&own), held: count(&held) }
    };
    (0..ranks).map(share).collect()
}

#[cfg(test)]
mod tests {
    use super::super::regions::tests::region;
    use super::*;

    #[test]
    fn shares_are_those_of_slices_with_their_neighbours() {
        let grid = CellGrid::<2>::new([0.0; 2], [12.0, 1.0], [false; 2], 1.0, 1.0);
        // Two particles in each cell.
        let places = || (0..24).map(|at| [0.5 * f64::from(at) + 0.25, 0.5]);
        let share = |own: u64, held: u64| Share { own, held };
        assert_eq!(shares(&grid, places(), &[], 3), [share(8, 10), share(8, 12), share(8, 10)]);
        assert_eq!(
            shares(&grid, places(), &[region(4..5, 3..6)], 3),
            [share(8, 14), share(8, 14), share(8, 10)]
        );
        assert_eq!(shares(&grid, places(), &[], 1), [share(24, 24)]);
    }
}
