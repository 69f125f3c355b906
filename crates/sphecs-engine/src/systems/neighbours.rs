//! Sort of the particles into the cells of the grid.

use bevy_ecs::system::{Res, ResMut};

use super::boundaries::opening_regions::OpeningRegions;
use super::boundaries::outlet_records::share_outlets;
use super::boundaries::outlets::Outlets;
use super::boundaries::patch_rows::PatchRows;
use super::divergence::Failure;
use crate::arrays::Arrays;
use crate::resources::grid::{Grid, SortBuffers};
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// Sorts the arrays into cells, computes the distances to the walls and finds the rows of each
/// patch.
pub(crate) fn sort_particles<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    (mut grid, mut buffers): (ResMut<Grid<D>>, ResMut<SortBuffers<R>>),
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
    (mut rows, mut openings, mut outlets): (ResMut<PatchRows>, ResMut<OpeningRegions>, ResMut<Outlets<R, D>>),
    mut failure: ResMut<Failure>,
) {
    let arrays = &mut arrays.0;
    sums.0.forget_order();
    let ranks = &pair.0.ranks;
    openings.find(&scene.0, outlets.needs(), &grid.0);
    if ranks.size() > 1 {
        let regions = openings.regions(&scene.0, outlets.needs(), &grid.0);
        if !ranks.move_rows(&mut grid.0, arrays, regions) && ranks.rank() > 0 {
            failure.is_elsewhere = true;
            return;
        }
        if openings.are_outdated(ranks) {
            share_outlets(&scene.0, &mut outlets, &openings, ranks);
            openings.follow(ranks);
        }
    }
    let zone = std::mem::take(&mut arrays.zone);
    let built = grid.0.build(&arrays.position, &arrays.id, |row| zone[row] != Zone::Reservoir);
    arrays.zone = zone;
    match built {
        Ok(order) => arrays.reorder(order, &mut buffers.0),
        Err(row) => {
            failure.outside_grid(arrays, row, pair.0.discretisation.support);
            return;
        }
    }
    ranks.count_rows(&grid.0);
    R::find_wall_distance(&pair.0, &grid.0, arrays, &mut sums.0);
    let near = openings.near(ranks.has_all());
    rows.collect(&scene.0, outlets.needs(), (&grid.0, near), arrays);
}
