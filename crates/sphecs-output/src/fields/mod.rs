//! Fields of the flow on regular grids, `fields.nc`, and their means over time.
//!
//! - [`snapshot`]: the fields at one time
//! - [`averages`]: means and Reynolds stresses, accumulated during a run
//! - `quantities`: names and units
//! - [`packing`]: the file of all times
//! - [`resampling`]: grids from the frames of a run that wrote none

//!
//! A node inside a wall, or around which less than half of the space between the walls is filled,
//! has no values. The fits themselves are in [`grid_rows`](sphecs_core::pass::grid_rows).

pub mod averages;
pub mod packing;
pub(crate) mod quantities;
pub mod resampling;

pub mod snapshot;

use glam::DVec3;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use sphecs_core::pass::grid_rows::{NodeFields, NodeRow, RowSink};
use sphecs_scene::field_grid::FieldGrid;
use sphecs_scene::fill::periodic_distance;
use sphecs_scene::geometry::Shape;
use sphecs_scene::model::Scene;

/// Fluid fraction below which a node has no values: that of the surface of a resting fluid.
const LEAST_FRACTION: f64 = 0.5;

/// Returns true if a node has enough fluid around it for values.
fn is_filled(node: &NodeFields) -> bool {
    node.fraction >= LEAST_FRACTION && node.pressure.is_finite()
}

/// Samples rows of nodes into the sink of each.
pub type SampleRows<'a> = dyn FnMut(&[NodeRow], &mut [&mut dyn RowSink]) + 'a;

/// Nodes of all grids of a scene in rows, without those inside walls.
#[derive(Clone, Debug, Default)]
pub struct FieldNodes {
    dimensions: usize,
    tagged: bool,
    grids: Vec<FieldGrid>,
    /// Rows of all grids, one grid after the other.
    rows: Vec<NodeRow>,
    /// Nodes of each row that no wall at rest covers; empty if all walls rest or move together.
    outside_casing: Vec<Vec<bool>>,
    /// True if walls move, so that the nodes inside them change.
    has_moving_walls: bool,
}

impl FieldNodes {
    /// Returns the nodes of the gridded fields of a scene; without them there are none.
    pub fn new(scene: &Scene) -> Self {
        Self::over(scene, scene.field_grids())
    }

    /// Returns the nodes of grids in the domain of a scene.
    pub(crate) fn over(scene: &Scene, grids: Vec<FieldGrid>) -> Self {
        let inside = |point| periodic_distance(&scene.domain, &scene.periodic, point) < 0.0;
        let row = |grid: &FieldGrid, row: usize| NodeRow {
            start: grid.row_start(row),
            step: grid.row_step(),
            wanted: grid.row_points(row).map(inside).collect(),
        };
        let rows_of = |grid: &FieldGrid| -> Vec<NodeRow> {
            (0..grid.rows()).into_par_iter().with_max_len(4).map(|index| row(grid, index)).collect()
        };
        let rows: Vec<NodeRow> = grids.iter().flat_map(rows_of).collect();
        let has_moving_walls = scene.has_moving_walls();
        // The distance to a casing of triangles takes far longer than that to the movers.
        let is_casing_at_rest = has_moving_walls && scene.casing_motion.is_none();
        let outside_casing =
            rows.iter().filter(|_| is_casing_at_rest).map(|row| row.wanted.clone()).collect();
        let (dimensions, tagged) = (scene.dimensions, scene.has_tags());
        let mut nodes = Self { dimensions, tagged, grids, rows, outside_casing, has_moving_walls };
        nodes.update(scene, 0.0);
        nodes
    }

    /// Returns true without any grid.
    pub fn is_empty(&self) -> bool {
        self.grids.is_empty()
    }

    /// Returns true if the passive scalar is sampled.
    pub fn tagged(&self) -> bool {
        self.tagged
    }

    /// Finds the nodes outside walls at a time, s, if walls move.
    pub fn update(&mut self, scene: &Scene, time: f64) {
        if !self.has_moving_walls {
            return;
        }
        let poses = scene.wall_poses(time);
        let everywhere = Shape::Ball { center: DVec3::ZERO, radius: f64::INFINITY };
        let casing = if self.outside_casing.is_empty() { &scene.layout.casing.domain } else { &everywhere };
        let outside_casing = &self.outside_casing;
        self.rows.par_iter_mut().enumerate().with_max_len(4).for_each(|(index, row)| {
            for node in 0..row.wanted.len() {
                let point = row.start + node as f64 * row.step;
                row.wanted[node] = outside_casing.get(index).is_none_or(|outside| outside[node])
                    && scene.nearest_wall(casing, &poses, point).0 < 0.0;
            }
        });
    }
}

/// Returns mutable slices of the columns of a grid for each of its rows.
fn row_slices<'a, T: Send>(
    columns: &'a mut [Vec<T>],
    row_length: usize,
    rows: usize,
) -> Vec<Vec<&'a mut [T]>> {
    let mut slices: Vec<Vec<&'a mut [T]>> = (0..rows).map(|_| Vec::with_capacity(columns.len())).collect();
    for column in columns {
        for (row, slice) in slices.iter_mut().zip(column.chunks_mut(row_length)) {
            row.push(slice);
        }
    }
    slices
}
