//! Particle columns in a checkpoint.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use super::arrays::ParticleArrays;
use super::zone::Zone;
use crate::math::column::{ColumnMismatch, Columns};
use crate::math::real::Real;

/// Order in which a checkpoint keeps the particles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Order {
    /// The present order: by cell, followed by those added since the last sort.
    AsTheyStand,
    /// By the number of the particle.
    ByNumber,
}

/// Adds every column that the next step depends on to a checkpoint.
///
/// Particles bound for the reservoir, which the next sort drops, are left out.
pub fn save<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, order: Order, to: &mut Columns) {
    arrays.save_columns(&SavedRows::new(&arrays.id, &arrays.zone, order), to);
}

/// Adds the columns of [`save`] in their order, and frees each once it is added.
pub fn save_owned<R: Real, const D: usize>(arrays: ParticleArrays<R, D>, to: &mut Columns) {
    let rows = SavedRows::new(&arrays.id, &arrays.zone, Order::AsTheyStand);
    arrays.give_columns(&rows, to);
}

/// Adds the columns of [`save`], of some rows alone.
pub fn save_rows<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>, rows: Vec<u32>, to: &mut Columns) {
    arrays.save_columns(&SavedRows(Some(rows)), to);
}

/// Takes the columns of [`save`] from a checkpoint.
///
/// # Errors
/// [`ColumnMismatch`] when a column is missing, of another type or length, or holds a number that
/// is not a zone.
pub fn restore<R: Real, const D: usize>(from: &mut Columns) -> Result<ParticleArrays<R, D>, ColumnMismatch> {
    ParticleArrays::restore_columns(from)
}

/// Rows that a thread picks at a time.
const CHUNK: usize = 8192;

/// Rows that a checkpoint keeps; None: all of them in their present order.
pub(super) struct SavedRows(Option<Vec<u32>>);

impl SavedRows {
    /// Returns some rows in this order.
    pub(super) fn of(rows: &[u32]) -> Self {
        Self(Some(rows.to_vec()))
    }

    fn new(id: &[u32], zone: &[Zone], order: Order) -> Self {
        if order == Order::AsTheyStand && zone.iter().all(|zone| *zone != Zone::Reservoir) {
            return Self(None);
        }
        let rows = (0_u32..).zip(zone).filter(|(_, zone)| **zone != Zone::Reservoir);
        let mut rows: Vec<u32> = rows.map(|(row, _)| row).collect();
        if order == Order::ByNumber {
            rows.par_sort_unstable_by_key(|&row| id[row as usize]);
        }
        Self(Some(rows))
    }

    /// Returns the values of the rows.
    pub(super) fn pick<T: Copy + Send + Sync>(&self, column: &[T]) -> Vec<T> {
        match &self.0 {
            None => column.par_iter().with_min_len(CHUNK).copied().collect(),
            Some(rows) => rows.par_iter().with_min_len(CHUNK).map(|&row| column[row as usize]).collect(),
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::arrays::SpareColumns;
    use super::super::rows::ParticleRow;
    use super::*;

    #[test]
    fn restored_arrays_equal_the_saved_without_particles_bound_for_the_reservoir() {
        let mut arrays = ParticleArrays::<f32, 3>::default();
        let row = |id: u32, zone: Zone| ParticleRow {
            id,
            zone,
            patch: id as u16,
            needs_restart: id == 1,
            position: DVec3::new(0.1, 0.2, f64::from(id)),
            velocity: DVec3::new(0.3, -0.0, 0.0),
            previous_velocity: DVec3::new(0.4, 0.0, f64::from(id)),
            density: 1000.0,
            pressure: -1.5,
            previous_pressure: 0.0,
            drift: DVec3::ZERO,
            wall_distance: f64::INFINITY,
            wall_normal: DVec3::ZERO,
            wall_thickness: 0.0,
        };
        let zones = [Zone::Fluid, Zone::Outflow, Zone::Reservoir, Zone::Wall, Zone::Inflow];
        (0..).zip(zones).for_each(|(id, zone)| arrays.push(&row(id, zone)));
        let mut columns = Columns::default();
        save(&arrays, Order::AsTheyStand, &mut columns);
        let back: ParticleArrays<f32, 3> = restore(&mut columns.clone()).expect("whole");
        assert_eq!(back.id, [0, 1, 3, 4]);
        for (at, before) in [0, 1, 3, 4].into_iter().enumerate() {
            assert_eq!(back.row(at), arrays.row(before));
        }
        let mut again = Columns::default();
        save(&back, Order::AsTheyStand, &mut again);
        assert_eq!(again, columns);
        assert!(restore::<f64, 3>(&mut columns.clone()).is_err(), "of another precision");
        arrays.reorder(&[3, 0, 4, 1], &mut SpareColumns::default());
        let mut by_number = Columns::default();
        save(&arrays, Order::ByNumber, &mut by_number);
        assert_eq!(by_number, columns);
        let (mut kept, mut given) = (Columns::default(), Columns::default());
        save(&arrays, Order::AsTheyStand, &mut kept);
        save_owned(arrays, &mut given);
        assert_eq!(given, kept);
        columns.take::<f32>("arrays.pressure").expect("there");
        let misfit = restore::<f32, 3>(&mut columns).expect_err("incomplete").to_string();
        assert!(misfit.contains("arrays.pressure"), "{misfit}");
    }
}
