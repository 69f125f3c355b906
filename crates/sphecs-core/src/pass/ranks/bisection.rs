//! Recursive bisection of the cells into domains of equal cost: Berger & Bokhari (1987).
//!
//! A part of the cells is cut across its longest extent, where the cost on both sides is in the
//! ratio of their numbers of ranks. The cut follows whole cells but not whole layers of them: in
//! the layer in which it lies, some cells belong to one side and some to the other. So domains are
//! of equal cost even if they are a few cells long.

use crate::math::grid::CellGrid;

/// Returns the rank of each cell; `costs` are those of the cells, of which those without particles
/// have none.
pub(super) fn bisect<const D: usize>(grid: &CellGrid<D>, costs: &[f64], ranks: usize) -> Vec<u16> {
    let mut owner = vec![0; grid.len()];
    let mut cells: Vec<u32> = (0..grid.len() as u32).collect();
    bisect_part(grid, costs, &mut cells, 0, ranks, &mut owner);
    owner
}

/// Shares cells among `ranks` ranks, the first of which is `first`.
fn bisect_part<const D: usize>(
    grid: &CellGrid<D>,
    costs: &[f64],
    cells: &mut [u32],
    first: usize,
    ranks: usize,
    owner: &mut [u16],
) {
    if ranks == 1 {
        cells.iter().for_each(|&cell| owner[cell as usize] = first as u16);
        return;
    }
    let layers = Layers::along(longest_axis(grid, costs, cells), grid, costs, cells);
    let low_ranks = ranks / 2;
    let middle = layers.split(low_ranks as f64 / ranks as f64, grid, costs, cells);
    let (low, high) = cells.split_at_mut(middle);
    bisect_part(grid, costs, low, first, low_ranks, owner);
    bisect_part(grid, costs, high, first + low_ranks, ranks - low_ranks, owner);
}

/// Layers of cells across an axis.
struct Layers {
    axis: usize,
    /// Cost of each layer.
    costs: Vec<f64>,
}

impl Layers {
    fn along<const D: usize>(axis: usize, grid: &CellGrid<D>, costs: &[f64], cells: &[u32]) -> Self {
        let mut of_layer = vec![0.0; grid.cells()[axis]];
        for &cell in cells {
            of_layer[grid.index_of(cell as usize)[axis] as usize] += costs[cell as usize];
        }
        Self { axis, costs: of_layer }
    }

    /// Puts those of the cells, which are in their order, in front that together have a share of
    /// the cost, and returns their number; both parts keep their order.
    fn split<const D: usize>(
        &self,
        share: f64,
        grid: &CellGrid<D>,
        costs: &[f64],
        cells: &mut [u32],
    ) -> usize {
        let wanted = share * self.costs.iter().sum::<f64>();
        let mut below = 0.0;
        let cut = self.costs.iter().position(|cost| {
            below += cost;
            below >= wanted
        });
        let cut = cut.unwrap_or(self.costs.len());
        let mut below: f64 = self.costs[..cut].iter().sum();
        let mut high = Vec::new();
        let mut low = 0;
        for at in 0..cells.len() {
            let cell = cells[at];
            let layer = grid.index_of(cell as usize)[self.axis] as usize;
            let is_low = layer < cut
                || layer == cut && {
                    let before = below;
                    below += costs[cell as usize];
                    // The cell on the cut belongs to the side with its larger part.
                    before + 0.5 * costs[cell as usize] < wanted
                };
            if is_low {
                cells[low] = cell;
                low += 1;
            } else {
                high.push(cell);
            }
        }
        cells[low..].copy_from_slice(&high);
        low
    }
}

/// Returns the axis along which the cells with particles extend the farthest.
fn longest_axis<const D: usize>(grid: &CellGrid<D>, costs: &[f64], cells: &[u32]) -> usize {
    let (mut low, mut high) = ([i64::MAX; D], [i64::MIN; D]);
    for &cell in cells.iter().filter(|&&cell| costs[cell as usize] > 0.0) {
        let index = grid.index_of(cell as usize);
        for axis in 0..D {
            low[axis] = low[axis].min(index[axis]);
            high[axis] = high[axis].max(index[axis]);
        }
    }
    let size = grid.cell_size();
    let extent = |axis: usize| high[axis].saturating_sub(low[axis]) as f64 * size[axis];
    // Of equal ones the last, which leaves the longest runs of consecutive cells.
    (0..D).fold(0, |longest, axis| if extent(axis) >= extent(longest) { axis } else { longest })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn domains_have_equal_costs_and_are_compact() {
        let grid = CellGrid::<2>::new([0.0; 2], [40.0, 10.0], [false; 2], 1.0, 1.0);
        // Cells of the right half cost three times as much; a frame is empty.
        let cost = |cell: usize| {
            let [x, y] = grid.index_of(cell);
            let is_inside = (1..39).contains(&x) && (1..9).contains(&y);
            if !is_inside {
                0.0
            } else if x < 20 {
                1.0
            } else {
                3.0
            }
        };
        let costs: Vec<f64> = (0..grid.len()).map(cost).collect();
        let total: f64 = costs.iter().sum();
        for ranks in [1, 2, 3, 5, 8] {
            let owner = bisect(&grid, &costs, ranks);
            for rank in 0..ranks {
                let own = |cell: &usize| usize::from(owner[*cell]) == rank;
                let share: f64 = (0..grid.len()).filter(own).map(|cell| costs[cell]).sum();
                assert!((share - total / ranks as f64).abs() <= 3.0, "{rank} of {ranks}: {share}");
            }
            // Sides between domains: a cut across the box is 10 cells long, and one cell more
            // where it jumps.
            let differ = |a: usize, b: usize| usize::from(owner[a] != owner[b]);
            let sides: usize = (0..grid.len())
                .map(|cell| {
                    let [x, y] = grid.index_of(cell);
                    let right = if x < 39 { differ(cell, cell + 1) } else { 0 };
                    right + if y < 9 { differ(cell, cell + 40) } else { 0 }
                })
                .sum();
            assert!(sides <= 12 * (ranks - 1), "{ranks} ranks: {sides} sides");
        }
    }

    #[test]
    fn more_ranks_than_particles_are_served() {
        let grid = CellGrid::<2>::new([0.0; 2], [4.0, 4.0], [false; 2], 1.0, 1.0);
        let mut costs = vec![0.0; grid.len()];
        costs[5] = 1.0;
        let owner = bisect(&grid, &costs, 7);
        assert!(owner.iter().all(|&rank| rank < 7));
        assert!(bisect(&grid, &vec![0.0; grid.len()], 3).iter().all(|&rank| rank < 3));
    }
}
