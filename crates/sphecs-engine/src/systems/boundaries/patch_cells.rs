//! Grid cells near inlets, emitters and outlets.
//!
//! Particles of other cells neither belong to a zone nor can cross a plane within a step.

use std::ops::Range;

use glam::DVec3;

use super::patch_rows::ADJACENT_LAYERS;
use sphecs_core::boundary::outlet::method::Needs;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::grid::cell_set::runs_of;
use sphecs_scene::emitters::swept_region::SweptRegion;
use sphecs_scene::model::{Patch, Scene};

/// Cells near a patch, with their rows, which are valid until the next sort.
#[derive(Clone, Debug, Default)]
pub struct PatchCells {
    /// First row of each run.
    starts: Vec<usize>,
    /// Number of rows before each run, and of all rows at the end.
    before: Vec<usize>,
}

impl PatchCells {
    /// Finds the rows of runs of cells in arrays that are sorted by the grid.
    pub fn find<const D: usize>(&mut self, cells: &[Range<usize>], grid: &CellGrid<D>) {
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

    /// Returns the number of rows.
    pub fn count(&self) -> usize {
        self.before.last().copied().unwrap_or(0)
    }

    /// Returns a range of the rows, counted from the first row of the first cell, in their order.
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

/// Finds the runs of consecutive cells that may hold particles of a zone, particles that cross a
/// plane before the next sort, or particles that an outlet follows. Each patch has a slab along its
/// plane over the whole domain, since particles of a zone may drift sideways.
pub(super) fn cells_near_openings<const D: usize>(
    scene: &Scene,
    needs: &[Needs],
    grid: &CellGrid<D>,
) -> Vec<Range<usize>> {
    let support = scene.discretisation.support;
    // No particle moves as far as the support in a step.
    let slab = |patch: &Patch, before: f64, behind: f64| (patch.clone(), -before - support, behind + support);
    let inlets = scene.inlets.iter().map(|inlet| slab(&inlet.patch, inlet.patch.depth, 0.0));
    let outlets = scene.outlets.iter().zip(needs).map(|(outlet, needs)| {
        let reach = support + needs.upstream_layers.unwrap_or(0.0).max(ADJACENT_LAYERS) * scene.spacing;
        slab(&outlet.patch, reach, outlet.patch.depth)
    });
    cells_of(scene, &inlets.chain(outlets).collect::<Vec<_>>(), grid)
}

/// Returns the cells of which the members of a region hold the rows: those near openings and those
/// whose rows a condition may read at the mirror images of its particles.
pub(super) fn cells_of_members<const D: usize>(
    scene: &Scene,
    needs: &[Needs],
    grid: &CellGrid<D>,
) -> Vec<Range<usize>> {
    let support = scene.discretisation.support;
    let reach = |patch: &Patch, layers: f64| {
        let reach = patch.depth + 2.0 * support + layers * scene.spacing;
        (patch.clone(), -reach, reach)
    };
    let inlets = scene.inlets.iter().map(|inlet| reach(&inlet.patch, ADJACENT_LAYERS));
    let outlets = scene.outlets.iter().zip(needs).map(|(outlet, needs)| {
        reach(&outlet.patch, needs.upstream_layers.unwrap_or(0.0).max(ADJACENT_LAYERS))
    });
    cells_of(scene, &inlets.chain(outlets).collect::<Vec<_>>(), grid)
}

/// Finds the runs of consecutive cells in slabs, which are planes with two distances along their
/// normal, m, or near emitters.
fn cells_of<const D: usize>(
    scene: &Scene,
    slabs: &[(Patch, f64, f64)],
    grid: &CellGrid<D>,
) -> Vec<Range<usize>> {
    let support = scene.discretisation.support;
    let emitters: Vec<SweptRegion> =
        scene.emitters.iter().map(|emitter| emitter.swept_region(scene)).collect();
    runs_of(0..grid.len(), |cell| {
        let corner = grid.corner(grid.index_of(cell));
        let (mut centre, mut half) = (DVec3::ZERO, DVec3::ZERO);
        for d in 0..D {
            half[d] = 0.5 * grid.cell_size()[d];
            centre[d] = corner[d] + half[d];
        }
        let is_in_slab = slabs.iter().any(|(patch, from, to)| {
            let (along, extent) = (patch.along(centre), half.dot(patch.towards.abs()));
            along + extent > *from && along - extent < *to
        });
        is_in_slab || emitters.iter().any(|region| region.distance(scene, centre) < support + half.length())
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_together_are_all_rows_in_order() {
        let near = PatchCells { starts: vec![3, 10, 10, 20], before: vec![0, 4, 4, 7, 9] };
        let all = [3, 4, 5, 6, 10, 11, 12, 20, 21];
        assert_eq!(near.count(), all.len());
        for cut in 0..=all.len() {
            for end in cut..=all.len() {
                assert_eq!(near.rows(cut..end).collect::<Vec<_>>(), all[cut..end]);
            }
        }
        assert_eq!(PatchCells::default().rows(0..0).count(), 0);
    }
}
