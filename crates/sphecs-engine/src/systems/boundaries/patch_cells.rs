//! The rows of the cells near inlets and outlets: nothing farther away belongs to a zone or can cross a plane within a step.

use std::ops::Range;

use glam::DVec3;

use sphecs_core::math::grid::CellGrid;
use sphecs_scene::model::{Patch, Scene};

/// Layers beyond the support of the zone's first particles from which a hybrid outlet knows the fluid: so long its mean has time
/// to settle. No condition asks for fluid farther before its plane.
pub const LAYERS_BEYOND_REACH: f64 = 3.0;

/// Rows of the cells near a patch, valid from one sort to the next.
#[derive(Clone, Debug, Default)]
pub struct NearRows {
    /// Runs of cells near a patch: found once, since neither grid nor patches move.
    cells: Option<Vec<Range<usize>>>,
    /// First row of each run.
    starts: Vec<usize>,
    /// How many of the rows there are before each run, and all at the end.
    before: Vec<usize>,
}

impl NearRows {
    /// Finds the rows in arrays that are sorted by the grid.
    pub fn find<const D: usize>(&mut self, scene: &Scene, grid: &CellGrid<D>) {
        let cells = self.cells.get_or_insert_with(|| cells_near(scene, grid));
        self.starts.clear();
        self.before.clear();
        self.before.push(0);
        let mut total = 0;
        for run in cells {
            let (start, end) = (grid.rows(run.start).start, grid.rows(run.end - 1).end);
            total += end - start;
            self.starts.push(start);
            self.before.push(total);
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.before.last().copied().unwrap_or(0)
    }

    /// The rows from one to another, counted among themselves, in their order.
    pub fn rows(&self, part: Range<usize>) -> impl Iterator<Item = usize> {
        let first = self.before.partition_point(|&before| before <= part.start).max(1) - 1;
        let end = part.end;
        (first..self.starts.len()).take_while(move |&run| self.before[run] < end).flat_map(move |run| {
            let here = self.before[run]..self.before[run + 1];
            let row = |at: usize| self.starts[run] + at.clamp(here.start, here.end) - here.start;
            row(part.start)..row(part.end)
        })
    }
}

/// Runs of consecutive cells in which a particle may stand that belongs to a zone, that crosses a plane before the next sort or that an
/// outlet asks for. A slab along each patch's plane, over the whole domain: particles of a zone may drift sideways.
fn cells_near<const D: usize>(scene: &Scene, grid: &CellGrid<D>) -> Vec<Range<usize>> {
    let support = scene.scheme.support(scene.spacing);
    // No particle moves by as much as the support in a step.
    let slab = |patch: &Patch, before: f64, behind: f64| (patch.clone(), -before - support, behind + support);
    let inlets = scene.inlets.iter().map(|inlet| slab(&inlet.patch, inlet.patch.depth, 0.0));
    let reach = support + LAYERS_BEYOND_REACH * scene.spacing;
    let outlets = scene.outlets.iter().map(|outlet| slab(&outlet.patch, reach, outlet.patch.depth));
    let slabs: Vec<_> = inlets.chain(outlets).collect();
    let mut runs: Vec<Range<usize>> = Vec::new();
    for cell in 0..grid.len() {
        let corner = grid.corner(grid.index_of(cell));
        let (mut centre, mut half) = (DVec3::ZERO, DVec3::ZERO);
        for d in 0..D {
            half[d] = 0.5 * grid.cell_size()[d];
            centre[d] = corner[d] + half[d];
        }
        let near = slabs.iter().any(|(patch, from, to)| {
            let (along, extent) = (patch.along(centre), half.dot(patch.towards.abs()));
            along + extent > *from && along - extent < *to
        });
        match runs.last_mut() {
            _ if !near => {}
            Some(last) if last.end == cell => last.end += 1,
            _ => runs.push(cell..cell + 1),
        }
    }
    runs
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_of_the_rows_are_all_of_them_in_order() {
        let near = NearRows { cells: None, starts: vec![3, 10, 10, 20], before: vec![0, 4, 4, 7, 9] };
        let all = [3, 4, 5, 6, 10, 11, 12, 20, 21];
        assert_eq!(near.count(), all.len());
        for cut in 0..=all.len() {
            for end in cut..=all.len() {
                assert_eq!(near.rows(cut..end).collect::<Vec<_>>(), all[cut..end]);
            }
        }
        assert_eq!(NearRows::default().rows(0..0).count(), 0);
    }
}
