//! Search for the points near to a place, by sorted cells.

use glam::DVec3;

use super::model::Scene;
use sphecs_core::math::grid::CellGrid;

/// Size of a cell of the search over its reach.
const CELL: f64 = 0.35;

/// A box with periodic directions.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Region {
    /// Lower corner, m.
    pub(crate) low: DVec3,
    /// Upper corner, m.
    pub(crate) high: DVec3,
    /// Directions in which the box repeats.
    pub(crate) periodic: [bool; 3],
}

impl Region {
    /// Returns the box from `low` to `high` (m) or, in periodic directions of a scene, of a period.
    pub(crate) fn of(scene: &Scene, low: DVec3, high: DVec3) -> Self {
        let mut region = Self { low, high, periodic: [false; 3] };
        for (axis, period) in scene.periodic.iter().enumerate() {
            if let Some((low, high)) = period {
                (region.low[axis], region.high[axis], region.periodic[axis]) = (*low, *high, true);
            }
        }
        region
    }

    /// Returns a point, m, in the box if it left it through a periodic side.
    pub(crate) fn wrapped(&self, mut point: DVec3) -> DVec3 {
        for axis in (0..3).filter(|axis| self.periodic[*axis]) {
            let length = self.high[axis] - self.low[axis];
            point[axis] = self.low[axis] + (point[axis] - self.low[axis]).rem_euclid(length);
        }
        point
    }
}

/// Points sorted by cells, to find those near to a place.
pub(crate) struct NearPoints<const D: usize> {
    grid: CellGrid<D>,
    positions: Vec<[f64; D]>,
}

impl<const D: usize> NearPoints<D> {
    /// Creates a search for points up to a distance `reach`, m, in a region.
    pub(crate) fn new(region: &Region, reach: f64) -> Self {
        let periodic = std::array::from_fn(|axis| region.periodic[axis]);
        let corner = |point: DVec3| std::array::from_fn(|axis| point[axis]);
        let grid = CellGrid::new(corner(region.low), corner(region.high), periodic, reach, CELL * reach);
        Self { grid, positions: Vec::new() }
    }

    /// Sorts the points; those outside of the box are left out.
    pub(crate) fn sort(&mut self, points: impl IntoIterator<Item = DVec3>) {
        let mut columns: [Vec<f64>; D] = std::array::from_fn(|_| Vec::new());
        for point in points {
            let at = std::array::from_fn(|axis| point[axis]);
            if self.grid.cell_of(at).is_some() {
                columns.iter_mut().zip(at).for_each(|(column, value)| column.push(value));
            }
        }
        let numbers: Vec<u32> = (0..columns[0].len() as u32).collect();
        self.positions = match self.grid.build(&columns, &numbers, |_| true) {
            Ok(order) => {
                let at = |row: &u32| std::array::from_fn(|axis| columns[axis][*row as usize]);
                order.iter().map(at).collect()
            }
            // Excluded above.
            Err(_) => Vec::new(),
        };
    }

    /// Calls `visit` with the vector and the distance, m, from each point within reach to a
    /// point.
    #[inline(always)]
    pub(crate) fn for_each_near(&self, point: DVec3, mut visit: impl FnMut([f64; D], f64)) {
        let at: [f64; D] = std::array::from_fn(|axis| point[axis]);
        let reach = self.grid.support().powi(2);
        self.grid.for_each_run_near(at, at, |rows, shift| {
            for other in &self.positions[rows] {
                // Plain loops: closures over arrays are calls in builds without full optimisation.
                let (mut way, mut square) = ([0.0; D], 0.0);
                for axis in 0..D {
                    way[axis] = at[axis] - other[axis] - shift[axis];
                    square += way[axis] * way[axis];
                }
                if square < reach {
                    visit(way, square.sqrt());
                }
            }
        });
    }
}
