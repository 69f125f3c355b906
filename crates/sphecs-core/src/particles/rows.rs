//! One row of the arrays, read and written as vectors in space.
//!
//! For boundaries, probes and transitions, which touch few rows; the pair passes read columns.

use glam::DVec3;

use super::arrays::ParticleArrays;
use super::zone::Zone;
use crate::math::real::Real;

/// Everything that the arrays hold of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row {
    /// Number of the particle.
    pub id: u32,
    /// Zone.
    pub zone: Zone,
    /// Index of inlet, outlet or wall part.
    pub patch: u16,
    /// Whether the next step is a plain one because the role has just changed.
    pub fresh: bool,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Velocity one step earlier, m/s.
    pub velocity_before: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Evolved pressure half a step earlier, Pa; 0 where the pressure does not evolve.
    pub pressure_before: f64,
    /// What the transport velocity has beyond the velocity, m/s; 0 where the pressure does not evolve.
    pub drift: DVec3,
    /// Wall: distance behind the surface, m.
    pub wall_distance: f64,
    /// Wall: unit normal into the fluid.
    pub wall_normal: DVec3,
}

/// A row of f64 columns as a vector.
#[inline]
pub fn vector<const D: usize>(columns: &[Vec<f64>; D], row: usize) -> DVec3 {
    let mut out = DVec3::ZERO;
    for axis in 0..D {
        out[axis] = columns[axis][row];
    }
    out
}

/// A row of columns in the precision of the pair sums as a vector.
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
    /// Position of a row, m.
    #[inline]
    pub fn position_of(&self, row: usize) -> DVec3 {
        vector(&self.position, row)
    }

    /// Velocity of a row, m/s.
    #[inline]
    pub fn velocity_of(&self, row: usize) -> DVec3 {
        real_vector(&self.velocity, row)
    }

    /// Velocity that moved a row in the last step, m/s: its own and its drift.
    pub fn carrying_velocity_of(&self, row: usize) -> DVec3 {
        let drift = if self.drifts { real_vector(&self.drift, row) } else { DVec3::ZERO };
        self.velocity_of(row) + drift
    }

    /// Acceleration of a row, m/s².
    pub fn acceleration_of(&self, row: usize) -> DVec3 {
        real_vector(&self.acceleration, row)
    }

    /// Appends a row at the end, outside the order of cells, until the next sort.
    pub fn push(&mut self, row: &Row) {
        self.id.push(row.id);
        self.zone.push(row.zone);
        self.patch.push(row.patch);
        self.fresh.push(row.fresh);
        for axis in 0..D {
            self.position[axis].push(row.position[axis]);
            self.velocity[axis].push(R::from_f64(row.velocity[axis]));
            self.velocity_before[axis].push(R::from_f64(row.velocity_before[axis]));
            self.acceleration[axis].push(R::default());
            let normal = &mut self.wall_normal[axis];
            if row.zone == Zone::Wall || !normal.is_empty() {
                // Rows before the first wall have none.
                normal.resize(self.id.len() - 1, R::default());
                normal.push(R::from_f64(row.wall_normal[axis]));
            }
        }
        self.density.push(R::from_f64(row.density));
        self.pressure.push(R::from_f64(row.pressure));
        self.wall_distance.push(R::from_f64(row.wall_distance));
        if self.evolves_pressure {
            self.pressure_before.push(R::from_f64(row.pressure_before));
        }
        if self.drifts {
            for axis in 0..D {
                self.drift[axis].push(R::from_f64(row.drift[axis]));
            }
        }
    }

    /// Makes room for that many rows more, and no further.
    pub fn reserve(&mut self, rows: usize) {
        self.id.reserve_exact(rows);
        self.zone.reserve_exact(rows);
        self.patch.reserve_exact(rows);
        self.fresh.reserve_exact(rows);
        for axis in 0..D {
            self.position[axis].reserve_exact(rows);
            for vector in [&mut self.velocity, &mut self.velocity_before, &mut self.acceleration] {
                vector[axis].reserve_exact(rows);
            }
        }
        for column in [&mut self.density, &mut self.pressure, &mut self.wall_distance] {
            column.reserve_exact(rows);
        }
        if self.evolves_pressure {
            self.pressure_before.reserve_exact(rows);
        }
        if self.drifts {
            for column in &mut self.drift {
                column.reserve_exact(rows);
            }
        }
    }

    /// A whole row.
    pub fn row(&self, row: usize) -> Row {
        Row {
            id: self.id[row],
            zone: self.zone[row],
            patch: self.patch[row],
            fresh: self.fresh[row],
            position: self.position_of(row),
            velocity: self.velocity_of(row),
            velocity_before: real_vector(&self.velocity_before, row),
            density: self.density[row].to_f64(),
            pressure: self.pressure[row].to_f64(),
            pressure_before: if self.evolves_pressure { self.pressure_before[row].to_f64() } else { 0.0 },
            drift: if self.drifts { real_vector(&self.drift, row) } else { DVec3::ZERO },
            wall_distance: self.wall_distance[row].to_f64(),
            wall_normal: if self.wall_normal[0].is_empty() {
                DVec3::ZERO
            } else {
                real_vector(&self.wall_normal, row)
            },
        }
    }

    /// Empties every column, keeping its memory.
    pub fn clear(&mut self) {
        self.id.clear();
        self.zone.clear();
        self.patch.clear();
        self.fresh.clear();
        for axis in 0..D {
            self.position[axis].clear();
            self.velocity[axis].clear();
            self.velocity_before[axis].clear();
            self.acceleration[axis].clear();
            self.wall_normal[axis].clear();
        }
        self.density.clear();
        self.pressure.clear();
        self.wall_distance.clear();
        self.pressure_before.clear();
        self.drift.iter_mut().for_each(Vec::clear);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_comes_back_as_it_was_pushed() {
        let mut arrays =
            ParticleArrays::<f64, 2> { evolves_pressure: true, drifts: true, ..Default::default() };
        let row = Row {
            id: 7,
            zone: Zone::Outflow,
            patch: 2,
            fresh: true,
            position: DVec3::new(1.0, 2.0, 0.0),
            velocity: DVec3::new(3.0, 4.0, 0.0),
            velocity_before: DVec3::new(5.0, 6.0, 0.0),
            density: 1000.0,
            pressure: -3.0,
            pressure_before: -4.0,
            drift: DVec3::new(0.5, -0.5, 0.0),
            wall_distance: 0.25,
            wall_normal: DVec3::ZERO,
        };
        let wall = Row { zone: Zone::Wall, wall_normal: DVec3::new(0.0, 1.0, 0.0), ..row };
        [row, wall, row].iter().for_each(|row| arrays.push(row));
        assert_eq!([0, 1, 2].map(|at| arrays.row(at)), [row, wall, row]);
        arrays.clear();
        assert!(arrays.is_empty());
    }
}
