//! Compression of inflow zones.
//!
//! Where the density follows from the pressure, an inflow zone is a compressible column behind its
//! plane:
//!
//! ```text
//! s = s0 ρ0/ρ,   ds0/dt = U
//! ```
//!
//! s is the distance along the normal from the plane, negative in the zone, U the prescribed
//! velocity and ρ the mean density of the zone. So the inlet carries the mass flow ρ0 U, and a row
//! that crosses the plane has the distance to the next that belongs to its density. With rows a
//! spacing apart at any pressure, each crossing is a jump of the summed density.
//!
//! The column has one density. With one for each particle, the lines of a lattice fall out of step
//! and drive sound across the channel, which grows.

use bevy_ecs::resource::Resource;
use glam::DVec3;
use serde::{Deserialize, Serialize};

use sphecs_core::boundary::patch::Patch;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::pass::pair_real::PairReal;

/// Columns of the inlets, then of the emitters, in the order of the scene.
#[derive(Resource, Serialize, Deserialize, Default)]
#[serde(transparent)]
pub struct InflowColumns(Vec<InflowColumn>);

/// Compression of the zone of an inlet.
#[derive(Clone, Copy, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct InflowColumn {
    /// Distance of two rows over that at the reference density, ρ0/ρ.
    stretch: f64,
    /// The stretch that belongs to the present pressures.
    next: f64,
}

impl Default for InflowColumn {
    fn default() -> Self {
        Self { stretch: 1.0, next: 1.0 }
    }
}

impl InflowColumns {
    /// Returns the column of an inlet.
    pub fn column(&mut self, inlet: usize) -> &mut InflowColumn {
        if self.0.len() <= inlet {
            self.0.resize_with(inlet + 1, InflowColumn::default);
        }
        &mut self.0[inlet]
    }

    /// Returns the numbers of a column, which other ranks need.
    pub(crate) fn numbers(&self, inlet: usize) -> [f64; 2] {
        let InflowColumn { stretch, next } = self.0.get(inlet).copied().unwrap_or_default();
        [stretch, next]
    }

    /// Sets the numbers of a column to those of another rank.
    pub(crate) fn set_numbers(&mut self, inlet: usize, [stretch, next]: [f64; 2]) {
        *self.column(inlet) = InflowColumn { stretch, next };
    }

    /// Returns the distance of two rows of the zone of an inlet, over that at the reference
    /// density.
    pub fn stretch(&self, inlet: usize) -> f64 {
        self.0.get(inlet).map_or(1.0, |column| column.stretch)
    }
}

impl InflowColumn {
    /// Finds the stretch that belongs to the densities of the rows of the zone, for the reference
    /// density ρ0 (kg/m³).
    pub fn follow<R: PairReal<D>, const D: usize>(
        &mut self,
        reference: f64,
        rows: &[u32],
        arrays: &ParticleArrays<R, D>,
    ) {
        if !rows.is_empty() {
            let sum: f64 = rows.iter().map(|&row| arrays.density[row as usize].to_f64()).sum();
            self.next = reference * rows.len() as f64 / sum;
        }
    }

    /// Takes the stretch that belongs to the present pressures, and returns it.
    pub fn update(&mut self) -> f64 {
        self.stretch = self.next;
        self.stretch
    }

    /// Moves the rows of the zone to the distances from the plane that belong to the present
    /// pressures.
    pub fn compress<R: PairReal<D>, const D: usize>(
        &mut self,
        patch: &Patch,
        rows: &[u32],
        arrays: &mut ParticleArrays<R, D>,
    ) {
        let rise = self.next / self.stretch - 1.0;
        self.stretch = self.next;
        for &row in rows {
            let row = row as usize;
            let way = patch.towards * (patch.along(arrays.position_of(row)) * rise);
            for axis in 0..D {
                arrays.position[axis][row] += way[axis];
            }
        }
    }

    /// Returns the velocity at which a row moves that has a prescribed velocity, m/s: its part
    /// along the normal times the stretch.
    pub fn moved(&self, patch: &Patch, velocity: DVec3) -> DVec3 {
        velocity + patch.towards * (velocity.dot(patch.towards) * (self.stretch - 1.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_distance_of_the_rows_belongs_to_their_density() {
        let (sine, cosine) = 0.3_f64.sin_cos();
        let patch = Patch {
            name: "inlet".to_owned(),
            at: DVec3::new(0.3, -0.2, 0.0),
            towards: DVec3::new(cosine, sine, 0.0),
            across: [DVec3::new(-sine, cosine, 0.0), DVec3::ZERO],
            half_extent: [0.08, 0.0],
            depth: 0.05,
            area: 0.16,
            perimeter: 2.0,
            raster: None,
        };
        let mut arrays = ParticleArrays::<f64, 2>::default();
        for (row, density) in [1010.0, 1030.0].into_iter().enumerate() {
            let at = patch.at - patch.towards * (0.01 * (row + 1) as f64);
            arrays.position[0].push(at.x);
            arrays.position[1].push(at.y);
            arrays.density.push(density);
        }
        let mut columns = InflowColumns::default();
        assert!((columns.stretch(1) - 1.0).abs() < 1e-15, "the lattice at the start");
        let column = columns.column(1);
        column.follow(1000.0, &[0, 1], &arrays);
        column.compress(&patch, &[0, 1], &mut arrays);
        let along = [0, 1].map(|row| patch.along(arrays.position_of(row)));
        assert!((along[0] + 0.01 / 1.02).abs() < 1e-15 && (along[1] + 0.02 / 1.02).abs() < 1e-15);
        let moved = column.moved(&patch, 0.3 * patch.towards + 0.1 * patch.across[0]);
        assert!((moved - 0.3 / 1.02 * patch.towards - 0.1 * patch.across[0]).length() < 1e-15);
        assert!((columns.stretch(1) - 1.0 / 1.02).abs() < 1e-15);
    }
}
