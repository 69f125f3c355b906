//! One particle of the arrays, read and written as vectors in space.
//!
//! This access is for boundaries, probes and transitions, which need few particles; the pair passes
//! read columns.

use glam::DVec3;

use super::arrays::ParticleArrays;
pub use super::arrays::ParticleRow;
use crate::math::real::Real;

/// Returns the vector in a row of f64 columns.
#[inline]
pub fn vector<const D: usize>(columns: &[Vec<f64>; D], row: usize) -> DVec3 {
    let mut out = DVec3::ZERO;
    for axis in 0..D {
        out[axis] = columns[axis][row];
    }
    out
}

/// Returns the vector in a row of columns in the precision of the pair sums.
#[inline]
pub fn real_vector<R: Real, const D: usize>(columns: &[Vec<R>; D], row: usize) -> DVec3 {
    let mut out = DVec3::ZERO;
    for axis in 0..D {
        out[axis] = columns[axis][row].to_f64();
    }
    out
}

/// Writes a vector into a row of columns.
#[inline]
pub fn set_real_vector<R: Real, const D: usize>(columns: &mut [Vec<R>; D], row: usize, value: DVec3) {
    for axis in 0..D {
        columns[axis][row] = R::from_f64(value[axis]);
    }
}

impl<R: Real, const D: usize> ParticleArrays<R, D> {
    /// Returns the position of the particle of a row, m.
    #[inline]
    pub fn position_of(&self, row: usize) -> DVec3 {
        vector(&self.position, row)
    }

    /// Returns the velocity of the particle of a row, m/s.
    #[inline]
    pub fn velocity_of(&self, row: usize) -> DVec3 {
        real_vector(&self.velocity, row)
    }

    /// Returns the velocity that moved the particle of a row in the last step, m/s: its own and its
    /// drift.
    pub fn carrying_velocity_of(&self, row: usize) -> DVec3 {
        let drift = if self.drifts { real_vector(&self.drift, row) } else { DVec3::ZERO };
        self.velocity_of(row) + drift
    }

    /// Returns the acceleration of the particle of a row, m/s².
    pub fn acceleration_of(&self, row: usize) -> DVec3 {
        real_vector(&self.acceleration, row)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::particles::zone::Zone;

    #[test]
    fn a_particle_is_read_as_it_was_pushed() {
        let mut arrays =
            ParticleArrays::<f64, 2> { evolves_pressure: true, drifts: true, ..Default::default() };
        let row = ParticleRow {
            id: 7,
            zone: Zone::Outflow,
            patch: 2,
            needs_restart: true,
            position: DVec3::new(1.0, 2.0, 0.0),
            velocity: DVec3::new(3.0, 4.0, 0.0),
            previous_velocity: DVec3::new(5.0, 6.0, 0.0),
            density: 1000.0,
            pressure: -3.0,
            previous_pressure: -4.0,
            drift: DVec3::new(0.5, -0.5, 0.0),
            wall_distance: 0.25,
            wall_normal: DVec3::ZERO,
            wall_thickness: 0.0,
        };
        let wall = ParticleRow { zone: Zone::Wall, wall_normal: DVec3::new(0.0, 1.0, 0.0), ..row };
        [row, wall, row].iter().for_each(|row| arrays.push(row));
        assert_eq!([0, 1, 2].map(|at| arrays.row(at)), [row, wall, row]);
        arrays.clear();
        assert!(arrays.is_empty());
    }
}
