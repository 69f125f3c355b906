//! The working set of a step: contiguous columns, sorted by cell, inside a cell by its parts along x (`math/grid/sort.rs`) and by
//! particle id.
//!
//! Reservoir particles are not in the arrays: they have no neighbours. Everything here is the
//! truth within a step; the components of the world are the truth between steps.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::zone::Zone;
use crate::math::real::Real;

/// Columns of all particles that can be somebody's neighbour, in `D` dimensions.
///
/// Positions are f64 always; the other columns are in the precision of the pair sums.
#[derive(Clone, Debug)]
pub struct ParticleArrays<R: Real, const D: usize> {
    /// Number of the particle: dense; no two rows but one that is to be dropped have the same.
    pub id: Vec<u32>,
    /// Zone of each row; `Zone::Reservoir` marks a row that the next sort drops.
    pub zone: Vec<Zone>,
    /// Index of the inlet, outlet or wall part that the row belongs to; 0 for fluid.
    pub patch: Vec<u16>,
    /// Whether the next step of a row is a plain one, because its role has just changed.
    pub fresh: Vec<bool>,
    /// Position, m.
    pub position: [Vec<f64>; D],
    /// Velocity at the present time, m/s. For a wall: the velocity of its surface.
    pub velocity: [Vec<R>; D],
    /// Velocity one step earlier (Verlet), half a step earlier where the pressure evolves, m/s.
    pub velocity_before: [Vec<R>; D],
    /// Rate of change of velocity, m/s²: written by a step between its sort and its kick, of no meaning at other times.
    pub acceleration: [Vec<R>; D],
    /// Density, kg/m³.
    pub density: Vec<R>,
    /// Pressure, Pa.
    pub pressure: Vec<R>,
    /// Whether the pressure evolves by an equation of its own: then the next column is in use, else empty.
    pub evolves_pressure: bool,
    /// Evolved pressure half a step earlier, Pa.
    pub pressure_before: Vec<R>,
    /// Whether particles are moved by more than their velocity: then the next column is in use, else empty.
    pub drifts: bool,
    /// What the velocity that moved a particle in the last step had beyond its own, m/s: that of the transport velocity, or of shifting.
    pub drift: [Vec<R>; D],
    /// Wall: distance d_w of the particle behind its surface, m. Others: distance to the nearest wall surface, m
    /// (`R::from_f64(f64::INFINITY)` when none is in the support).
    pub wall_distance: Vec<R>,
    /// Wall: unit normal of its surface, into the fluid. Others: 0. Empty if there is no wall.
    pub wall_normal: [Vec<R>; D],
}

impl<R: Real, const D: usize> Default for ParticleArrays<R, D> {
    fn default() -> Self {
        Self {
            id: Vec::new(),
            zone: Vec::new(),
            patch: Vec::new(),
            fresh: Vec::new(),
            position: std::array::from_fn(|_| Vec::new()),
            velocity: std::array::from_fn(|_| Vec::new()),
            velocity_before: std::array::from_fn(|_| Vec::new()),
            acceleration: std::array::from_fn(|_| Vec::new()),
            density: Vec::new(),
            pressure: Vec::new(),
            evolves_pressure: false,
            drifts: false,
            pressure_before: Vec::new(),
            drift: std::array::from_fn(|_| Vec::new()),
            wall_distance: Vec::new(),
            wall_normal: std::array::from_fn(|_| Vec::new()),
        }
    }
}

impl<R: Real, const D: usize> ParticleArrays<R, D> {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.id.len()
    }

    /// Whether there is no row.
    pub fn is_empty(&self) -> bool {
        self.id.is_empty()
    }

    /// Puts the rows into `order`, the row indices that [`CellGrid::build`](crate::math::grid::CellGrid::build) returned.
    /// Rows that it does not name are dropped.
    pub fn reorder(&mut self, order: &[u32], spare: &mut SpareColumns<R>) {
        let in_order = |(row, &from): (usize, &u32)| row == from as usize;
        if order.len() == self.len() && order.par_iter().with_min_len(CHUNK).enumerate().all(in_order) {
            return;
        }
        permute(&mut self.id, order, &mut spare.ids);
        permute_unless_even(&mut self.zone, order, &mut spare.zones);
        permute_unless_even(&mut self.patch, order, &mut spare.patches);
        permute_unless_even(&mut self.fresh, order, &mut spare.flags);
        for column in &mut self.position {
            permute(column, order, &mut spare.positions);
        }
        for column in self.wall_normal.iter_mut().filter(|column| !column.is_empty()) {
            permute(column, order, &mut spare.reals);
        }
        for column in self.velocity.iter_mut().chain(&mut self.velocity_before) {
            permute(column, order, &mut spare.reals);
        }
        for column in &mut self.acceleration {
            column.resize(order.len(), R::default());
        }
        for column in [&mut self.density, &mut self.pressure] {
            permute(column, order, &mut spare.reals);
        }
        if self.wall_normal.iter().any(|column| !column.is_empty()) {
            permute(&mut self.wall_distance, order, &mut spare.reals);
        } else {
            // All are equally far from none.
            self.wall_distance.truncate(order.len());
        }
        if self.evolves_pressure {
            permute(&mut self.pressure_before, order, &mut spare.reals);
        }
        if self.drifts {
            for column in &mut self.drift {
                permute(column, order, &mut spare.reals);
            }
        }
    }
}

/// Rows that a thread moves at a time.
const CHUNK: usize = 8192;

/// Rows that are moved at once where they were one behind another before: most were, since few leave their cell in a step.
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

/// Fills the spare column in order and swaps it with the column.
fn permute<T: Copy + Default + Send + Sync>(column: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>) {
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
                // Not by `map`, which would be a call.
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

/// The same for a column that may have one value alone, as zones in a box of fluid have: then its order is any, and it needs no
/// spare.
fn permute_unless_even<T>(column: &mut Vec<T>, order: &[u32], spare: &mut Vec<T>)
where
    T: Copy + Default + PartialEq + Send + Sync,
{
    let first = column.first().copied().unwrap_or_default();
    // Without a way out within a chunk: so it is a loop over vectors.
    let even = |chunk: &[T]| chunk.iter().fold(true, |even, value| even & (*value == first));
    if column.par_chunks(CHUNK).all(even) {
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
            fresh: vec![false, true, false, true],
            position: [count(1), count(2)],
            velocity: [count(3), count(4)],
            velocity_before: [count(5), count(6)],
            acceleration: [count(0), count(0)],
            density: count(7),
            pressure: count(8),
            evolves_pressure: true,
            drifts: true,
            pressure_before: count(12),
            drift: [count(13), count(14)],
            wall_distance: count(9),
            wall_normal: [count(10), count(11)],
        };
        arrays.reorder(&[3, 0, 1], &mut SpareColumns::default());
        assert_eq!(arrays.id, [3, 0, 1]);
        assert_eq!(arrays.zone, [Zone::Outflow, Zone::Fluid, Zone::Wall]);
        assert_eq!(arrays.patch, [3, 0, 1]);
        assert_eq!(arrays.fresh, [true, false, true]);
        assert!(arrays.acceleration.iter().all(|column| column.len() == 3));
        let columns = [
            &arrays.position[0],
            &arrays.position[1],
            &arrays.velocity[0],
            &arrays.velocity[1],
            &arrays.velocity_before[0],
            &arrays.velocity_before[1],
            &arrays.density,
            &arrays.pressure,
            &arrays.wall_distance,
            &arrays.wall_normal[0],
            &arrays.wall_normal[1],
            &arrays.pressure_before,
            &arrays.drift[0],
            &arrays.drift[1],
        ];
        for (column, from) in columns.into_iter().zip(1..) {
            let base = f64::from(10 * from);
            assert_eq!(*column, [base + 3.0, base, base + 1.0]);
        }
    }
}
