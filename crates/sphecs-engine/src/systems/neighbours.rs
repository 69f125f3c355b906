//! The cell grid and the sorted arrays.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};

use super::boundaries::rows::PatchRows;
use super::failure::Failure;
use super::pair::Pair;
use super::rates::Sums;
use super::setup::SceneInUse;
use crate::arrays::Arrays;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::SpareColumns;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::settings::PairSettings;
use sphecs_core::pass::wall_distance::find_wall_distance;
use sphecs_scene::model::{ParticleSeed, Scene};

/// The grid of the scene: its box and cells never change.
#[derive(Resource, Debug)]
pub struct Grid<const D: usize>(pub CellGrid<D>);

/// Spare columns for sorting.
#[derive(Resource, Default)]
pub struct Spare<R: Real>(pub SpareColumns<R>);

/// How far the grid reaches beyond the particles of the start, in supports: a particle that leaves it is lost.
const MARGIN_IN_SUPPORTS: f64 = 1.5;

/// The grid of a scene, from the positions of the start.
pub fn scene_grid<const D: usize>(scene: &Scene, pair: &PairSettings, seeds: &[ParticleSeed]) -> CellGrid<D> {
    let (support, cell_size) = (pair.support(), pair.cell_size());
    let mut lower = [f64::INFINITY; D];
    let mut upper = [f64::NEG_INFINITY; D];
    for seed in seeds.iter().filter(|seed| seed.zone != Zone::Reservoir) {
        for axis in 0..D {
            lower[axis] = lower[axis].min(seed.position[axis]);
            upper[axis] = upper[axis].max(seed.position[axis]);
        }
    }
    let mut periodic = [false; D];
    for axis in 0..D {
        if let Some((from, to)) = scene.periodic[axis] {
            (lower[axis], upper[axis]) = (from, to);
            periodic[axis] = true;
        } else {
            lower[axis] -= MARGIN_IN_SUPPORTS * support;
            upper[axis] += MARGIN_IN_SUPPORTS * support;
        }
    }
    CellGrid::new(lower, upper, periodic, support, cell_size)
}

/// Sorts the arrays into cells, finds the distances to the walls and the rows of each patch.
pub fn sort_particles<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    pair: Res<Pair>,
    mut grid: ResMut<Grid<D>>,
    mut spare: ResMut<Spare<R>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut rows: ResMut<PatchRows>,
    mut failure: ResMut<Failure>,
) {
    let arrays = &mut **arrays;
    sums.0.forget_order();
    let zone = std::mem::take(&mut arrays.zone);
    let built = grid.0.build(&arrays.position, &arrays.id, |row| zone[row] != Zone::Reservoir);
    arrays.zone = zone;
    match built {
        Ok(order) => arrays.reorder(order, &mut spare.0),
        Err(row) => {
            failure.outside_grid(arrays, row, pair.0.support());
            return;
        }
    }
    find_wall_distance(&pair.0, &grid.0, arrays, &mut sums.0);
    rows.collect(&scene.0, &grid.0, arrays);
}
