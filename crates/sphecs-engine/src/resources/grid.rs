//! Cell grid of a scene and the buffers for sorting.

use bevy_ecs::resource::Resource;

use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::SpareColumns;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::settings::PairSettings;
use sphecs_scene::fill::wall_thickness;
use sphecs_scene::model::{ParticleSeed, Scene};

/// Cell grid of the scene; its box and cells never change during a run.
#[derive(Resource, Debug)]
pub struct Grid<const D: usize>(pub CellGrid<D>);

/// Spare columns into which the particle arrays are sorted.
#[derive(Resource, Default)]
pub struct SortBuffers<R: Real>(pub SpareColumns<R>);

/// Distance from the initial particles to the bounds of the grid, in supports. A particle that
/// leaves the grid is lost.
const MARGIN_IN_SUPPORTS: f64 = 1.5;

/// Creates the grid of a scene from the initial positions and the way of walls that move.
pub(crate) fn scene_grid<const D: usize>(
    scene: &Scene,
    pair: &PairSettings,
    seeds: &[ParticleSeed],
) -> CellGrid<D> {
    let (support, cell_size) = (pair.discretisation.support, pair.discretisation.cell_size());
    let mut lower = [f64::INFINITY; D];
    let mut upper = [f64::NEG_INFINITY; D];
    for seed in seeds.iter().filter(|seed| seed.zone != Zone::Reservoir) {
        for axis in 0..D {
            lower[axis] = lower[axis].min(seed.position[axis]);
            upper[axis] = upper[axis].max(seed.position[axis]);
        }
    }
    if let Some((low, high)) = scene.swept_box(wall_thickness(scene)) {
        for axis in 0..D {
            (lower[axis], upper[axis]) = (lower[axis].min(low[axis]), upper[axis].max(high[axis]));
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
