//! Contiguous columns of the particles, the authoritative state within a step.
//!
//! They are sorted by cell, inside a cell by strips along x (`math/grid/sort.rs`) and by particle
//! id. Particles of the reservoir are not in the arrays, since they have no neighbours. Between
//! steps the components of the world are authoritative.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::quantity::{ColumnElement, Quantity};
use super::saved::SavedRows;
use super::table::{Sort, When, columns};
use super::zone::Zone;
use crate::math::column::{ColumnMismatch, Columns};
use crate::math::real::Real;

// name: column => value of one particle, name in a checkpoint, when in use, sorting (spare column)
columns! {
    /// Number of the particle. No two particles have the same, except one that is about to be
    /// dropped.
    id: Vec<u32> => u32, "id", Always, Permute(ids);
    /// Zone; `Zone::Reservoir` marks a particle that the next sort drops.
    zone: Vec<Zone> => Zone, "zone", Always, PermuteUnlessUniform(zones);
    /// Index of the inlet, outlet or wall part that the particle belongs to; 0 for fluid.
    patch: Vec<u16> => u16, "patch", Always, PermuteUnlessUniform(patches);
    /// True if the next step of the particle is a corrective (Euler) step, because its role has
    /// just changed.
    needs_restart: Vec<bool> => bool, "fresh", Always, PermuteUnlessUniform(flags);
    /// Position, m.
    position: [Vec<f64>; D] => DVec3, "position", Always, Permute(positions);
    /// Velocity at the present time, m/s. For a wall: the velocity of its surface.
    velocity: [Vec<R>; D] => DVec3, "velocity", Always, Permute(reals);
    /// Velocity one step earlier (Verlet), half a step earlier where the pressure evolves, m/s.
    previous_velocity: [Vec<R>; D] => DVec3, "velocity_before", Always, Permute(reals);
    /// Density, kg/m³.
    density: Vec<R> => f64, "density", Always, Permute(reals);
    /// Pressure, Pa.
    pressure: Vec<R> => f64, "pressure", Always, Permute(reals);
    /// Evolved pressure half a step earlier, Pa.
    previous_pressure: Vec<R> => f64, "pressure_before", PressureEvolves, Permute(reals);
    /// Velocity that moved the particle in the last step in addition to its own, m/s, by shifting
    /// or the transport velocity.
    drift: [Vec<R>; D] => DVec3, "drift", ParticlesDrift, Permute(reals);
    /// Distance, m. Wall: d_w of the particle behind its surface. Others: to the nearest wall
    /// surface, infinite when none is in the support.
    wall_distance: Vec<R> => f64, "wall_distance", Always, PermuteIfWalls(reals);
    /// Wall: unit normal of its surface, into the fluid. Others: 0.
    wall_normal: [Vec<R>; D] => DVec3, "wall_normal", WallsExist, Permute(reals);
    /// Particle of a thin wall that is one-sided: thickness of the solid, m. Others: 0.
    wall_thickness: Vec<R> => f64, "wall_thickness", WallsAreThin, Permute(reals);
}

impl When {
    /// Returns true if a particle brings the column into use.
    fn begins_with(self, particle: &ParticleRow) -> bool {
        match self {
            When::WallsExist => particle.zone == Zone::Wall,
            When::WallsAreThin => particle.wall_thickness != 0.0,
            When::Always | When::PressureEvolves | When::ParticlesDrift => false,
        }
    }
}

impl<R: Real, const D: usize> ParticleArrays<R, D> {
    /// Returns the number of particles.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Returns true if there is no particle.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Returns true if columns with a condition are in use.
    fn is_used(&self, when: When) -> bool {
        match when {
            When::Always => true,
            When::PressureEvolves => self.evolves_pressure,
            When::ParticlesDrift => self.drifts,
            When::WallsExist => self.wall_normal.iter().any(|column| !column.is_empty()),
            When::WallsAreThin => !self.wall_thickness.is_empty(),
        }
    }

    /// Returns the numbers of values that columns with a condition may have when there are `rows`
    /// particles.
    fn lengths(&self, when: When, rows: usize) -> [usize; 2] {
        match when {
            When::Always => [rows; 2],
            When::PressureEvolves => [if self.evolves_pressure { rows } else { 0 }; 2],
            When::ParticlesDrift => [if self.drifts { rows } else { 0 }; 2],
            When::WallsExist | When::WallsAreThin => [rows, 0],
        }
    }

    /// Brings the columns of walls into use that have no wall particle here but elsewhere in the
    /// flow.
    pub fn use_wall_columns(&mut self, walls_exist: bool, walls_are_thin: bool) {
        let rows = self.len();
        if walls_exist {
            self.wall_normal.iter_mut().for_each(|column| column.resize(rows, R::default()));
        }
        if walls_are_thin {
            self.wall_thickness.resize(rows, R::default());
        }
    }

    /// Puts the rows into `order`, the row indices that
    /// [`CellGrid::build`](crate::math::grid::CellGrid::build) returned.
    ///
    /// Rows that it does not name are dropped.
    pub fn reorder(&mut self, order: &[u32], spare: &mut SpareColumns<R>) {
        let in_order = |(row, &from): (usize, &u32)| row == from as usize;
        if order.len() == self.len() && order.par_iter().with_min_len(CHUNK).enumerate().all(in_order) {
            return;
        }
        self.reorder_columns(order, spare);
    }
}

/// Rows that a thread moves at a time.
const CHUNK: usize = 8192;

/// Rows that are moved at once where they were consecutive before, as most were: few leave their
/// cell in a step.
const RUN: usize = 8;

/// One spare column of each type, so that sorting the arrays every step allocates nothing.
#[derive(Clone, Debug, Default)]
pub struct SpareColumns<R> {
    ids: Vec<u32>,
    zones: Vec<Zone>,
    patches: Vec<u16>,
    flags: Vec<bool>,
    positions: Vec<f64>,
    reals: Vec<R>,
}

/// Puts the columns of a quantity into `order`, unless they are not in use.
fn reorder<Q: Quantity>(
    quantity: &mut Q,
    sort: Sort,
    has_walls: bool,
    order: &[u32],
    spare: &mut Vec<Q::Element>,
) {
    for column in quantity.columns_mut().iter_mut().filter(|column| !column.is_empty()) {
        match sort {
            Sort::Permute => permute(column, order, spare),
            Sort::PermuteIfWalls if has_walls => permute(column, order, spare),
            Sort::PermuteIfWalls => column.truncate(order.len()),
            Sort::PermuteUnlessUniform => permute_unless_uniform(column, order, spare),
        }
    }
}

/// Fills the spare column in order and swaps it with the column.
fn permute<T: ColumnElement>(column: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>) {
    spare.resize(order.len(), T::default());
    let from: &[T] = column;
    spare.par_chunks_mut(CHUNK).zip(order.par_chunks(CHUNK)).for_each(|(to, order)| {
        let (whole, rest) = order.as_chunks::<RUN>();
        let (to, last) = to.split_at_mut(RUN * whole.len());
        for (to, rows) in to.as_chunks_mut::<RUN>().0.iter_mut().zip(whole) {
            let first = rows[0] as usize;
            let run = rows.iter().zip(rows[0]..).fold(true, |run, (row, next)| run & (*row == next));
            match from.get(first..).and_then(|from| from.first_chunk::<RUN>()) {
                Some(from) if run => *to = *from,
                // A loop, since `map` would be a function call.
                _ => {
                    for (to, &row) in to.iter_mut().zip(rows) {
                        *to = from[row as usize];
                    }
                }
            }
        }
        for (to, &row) in last.iter_mut().zip(rest) {
            *to = from[row as usize];
        }
    });
    std::mem::swap(column, spare);
}

/// Permutes a column unless all its values are equal, when it needs neither an order nor a spare
/// column.
fn permute_unless_uniform<T: ColumnElement>(column: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>) {
    let first = column.first().copied().unwrap_or_default();
    // There is no early return within a chunk, so that the compiler vectorises the loop.
    let uniform = |chunk: &[T]| chunk.iter().fold(true, |uniform, value| uniform & (*value == first));
    if column.par_chunks(CHUNK).all(uniform) {
        column.truncate(order.len());
    } else {
        permute(column, order, spare);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reorder_permutes_every_column_and_drops_the_rest() {
        let count = |from: usize| (0..4).map(|row| (10 * from + row) as f64).collect::<Vec<f64>>();
        let mut arrays = ParticleArrays::<f64, 2> {
            id: vec![0, 1, 2, 3],
            zone: vec![Zone::Fluid, Zone::Wall, Zone::Reservoir, Zone::Outflow],
            patch: vec![0, 1, 2, 3],
            needs_restart: vec![false, true, false, true],
            position: [count(1), count(2)],
            velocity: [count(3), count(4)],
            previous_velocity: [count(5), count(6)],
            acceleration: [count(0), count(0)],
            density: count(7),
            pressure: count(8),
            evolves_pressure: true,
            drifts: true,
            previous_pressure: count(12),
            drift: [count(13), count(14)],
            wall_distance: count(9),
            wall_normal: [count(10), count(11)],
            wall_thickness: count(15),
        };
        arrays.reorder(&[3, 0, 1], &mut SpareColumns::default());
        assert_eq!(arrays.id, [3, 0, 1]);
        assert_eq!(arrays.zone, [Zone::Outflow, Zone::Fluid, Zone::Wall]);
        assert_eq!(arrays.patch, [3, 0, 1]);
        assert_eq!(arrays.needs_restart, [true, false, true]);
        assert!(arrays.acceleration.iter().all(|column| column.len() == 3));
        let columns = [
            &arrays.position[0],
            &arrays.position[1],
            &arrays.velocity[0],
            &arrays.velocity[1],
            &arrays.previous_velocity[0],
            &arrays.previous_velocity[1],
            &arrays.density,
            &arrays.pressure,
            &arrays.wall_distance,
            &arrays.wall_normal[0],
            &arrays.wall_normal[1],
            &arrays.previous_pressure,
            &arrays.drift[0],
            &arrays.drift[1],
            &arrays.wall_thickness,
        ];
        for (column, from) in columns.into_iter().zip(1..) {
            let base = f64::from(10 * from);
            assert_eq!(*column, [base + 3.0, base, base + 1.0]);
        }
    }
}
