//! The fluid's fields at arbitrary points, first-order consistent.
//!
//! ```text
//! minimise Σ_b V_b W_b (f_b − c0 − c·(x_b − x)/h)²   →   f(x) = c0
//! ```
//!
//! Moving least squares with a linear basis: Liu & Liu (2006), as Negi et al. (2020), Eq. 22, use it for their mirror
//! points. A linear field comes back exactly, next to a boundary too (test `linear_fields_are_exact_at_a_cut_support`). Where
//! the neighbours do not span the directions, the Shepard mean is taken.

use glam::{DMat4, DVec3, DVec4};

use super::neighbours::Neighbours;
use super::settings::PairSettings;
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::sample::Sample;
use crate::particles::zone::Zone;

/// Below this determinant of the scaled moments the neighbours do not span all directions: a full support has
/// about 0.1^D.
const SMALLEST_DETERMINANT: f64 = 1e-6;

/// Samples the fields of sorted particles.
pub struct Sampler<'a, R: Real, const D: usize> {
    neighbours: Neighbours<'a, R, D>,
    pair: &'a PairSettings,
    sees: fn(Zone) -> bool,
}

impl<'a, R: Real, const D: usize> Sampler<'a, R, D> {
    /// A sampler that sees the particles of the zones that `sees` accepts.
    pub fn new(
        grid: &'a CellGrid<D>,
        particles: &'a ParticleArrays<R, D>,
        pair: &'a PairSettings,
        sees: fn(Zone) -> bool,
    ) -> Self {
        Self { neighbours: Neighbours::new(grid, particles), pair, sees }
    }

    /// Velocity, pressure and density at a point; None where no particle is near.
    pub fn sample(&self, point: DVec3) -> Option<Sample> {
        let particles = self.neighbours.particles;
        let fit =
            self.fit(point, |row| particles.velocity_of(row).extend(particles.pressure[row].to_f64()))?;
        let density = self.fit(point, |row| DVec4::new(particles.density[row].to_f64(), 0.0, 0.0, 0.0))?;
        Some(Sample { velocity: fit.truncate(), pressure: fit.w, density: density.x })
    }

    /// The fitted values of four fields at once.
    fn fit(&self, point: DVec3, fields: impl Fn(usize) -> DVec4) -> Option<DVec4> {
        let particles = self.neighbours.particles;
        let scale = 1.0 / self.pair.smoothing_length;
        let mut moments = DMat4::ZERO;
        let mut sums = DMat4::ZERO;
        let coordinates: [f64; D] = std::array::from_fn(|axis| point[axis]);
        self.neighbours.for_each(coordinates, |row, x_ab, r_squared| {
            if !(self.sees)(particles.zone[row]) {
                return;
            }
            let weight = self.pair.mass / particles.density[row].to_f64() * self.pair.w(r_squared.sqrt());
            let mut basis = DVec4::new(1.0, 0.0, 0.0, 0.0);
            for axis in 0..D {
                basis[axis + 1] = -x_ab[axis] * scale;
            }
            let weighted = basis * weight;
            let values = fields(row);
            for column in 0..4 {
                *moments.col_mut(column) += weighted * basis[column];
                *sums.col_mut(column) += weighted * values[column];
            }
        });
        let total = moments.x_axis.x;
        if total <= 0.0 {
            return None;
        }
        Some(DVec4::from_array([0, 1, 2, 3].map(|field| {
            let right = sums.col(field).to_array();
            solve_linear(moments.to_cols_array_2d(), right, D)
        })))
    }
}

/// The value at the point of a linear fit with these moments (of 1 and the `dimensions` coordinates over h) and right-hand side; the
/// Shepard mean where the neighbours do not span the directions. The first moment must not be zero.
pub(super) fn solve_linear(moments: [[f64; 4]; 4], right: [f64; 4], dimensions: usize) -> f64 {
    let total = moments[0][0];
    let mut scaled = DMat4::from_cols_array_2d(&moments) * (1.0 / total);
    for unused in dimensions + 1..4 {
        scaled.col_mut(unused)[unused] = 1.0;
    }
    if scaled.determinant() < SMALLEST_DETERMINANT {
        return right[0] / total;
    }
    scaled.inverse().row(0).dot(DVec4::from_array(right)) / total
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample as Particles, WATER, settings};

    fn check<const D: usize>() {
        let mut sample = Particles::<f64, D>::lattice(settings(Kernel::WendlandC2, D, 1.5), [9; D], false);
        sample.stir(0.2, 0.0);
        let linear = |x: f64| 3.0 - 7.0 * (x + 0.3);
        for row in 0..sample.particles.len() {
            let x = sample.particles.position[0][row];
            sample.particles.velocity[1][row] = linear(x);
            sample.particles.pressure[row] = 100.0 * linear(x);
            sample.particles.density[row] = WATER.reference_density + linear(x);
            if sample.particles.id[row] % 7 == 3 {
                sample.particles.zone[row] = Zone::Wall;
                sample.particles.pressure[row] = 1e5;
            }
        }
        let sees = |zone| zone == Zone::Fluid;
        let sampler = Sampler::new(&sample.grid, &sample.particles, &sample.pair, sees);
        for along in [0.0, 0.4, 4.6] {
            let mut point = DVec3::ZERO;
            for axis in 0..D {
                point[axis] = -0.3 + along * SPACING;
            }
            let found = sampler.sample(point).expect("fluid is near");
            assert!((found.velocity.y - linear(point.x)).abs() < 1e-10 && found.velocity.x.abs() < 1e-10);
            assert!((found.pressure - 100.0 * linear(point.x)).abs() < 1e-8, "{} Pa", found.pressure);
            assert!((found.density - WATER.reference_density - linear(point.x)).abs() < 1e-8);
        }
        assert!(sampler.sample(DVec3::splat(5.0)).is_none());
    }

    #[test]
    fn linear_fields_are_exact_at_a_cut_support() {
        check::<2>();
        check::<3>();
    }
}
