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
use crate::math::linear::solve;
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

    /// Pressure at a point, Pa; None where no particle is near.
    pub fn pressure(&self, point: DVec3) -> Option<f64> {
        let particles = self.neighbours.particles;
        self.fit(point, |row| DVec4::new(particles.pressure[row].to_f64(), 0.0, 0.0, 0.0)).map(|fit| fit.x)
    }

    /// Velocity, pressure and density at a point; None where no particle is near.
    pub fn sample(&self, point: DVec3) -> Option<Sample> {
        let particles = self.neighbours.particles;
        let fit =
            self.fit(point, |row| particles.velocity_of(row).extend(particles.pressure[row].to_f64()))?;
        let density = self.fit(point, |row| DVec4::new(particles.density[row].to_f64(), 0.0, 0.0, 0.0))?;
        Some(Sample { velocity: fit.truncate(), pressure: fit.w, density: density.x })
    }

    /// Velocity along `normal` (m/s) and pressure (Pa) of the flow around a point of a section; None where no particle
    /// is near.
    ///
    /// The pressure is the kernel mean. The velocity is fitted by moving least squares with a basis that is linear along the normal
    /// and quadratic over the section: a kernel mean takes 3 % of the peak off a Poiseuille profile of 25 rows and
    /// lets the row at the wall run ahead, which no outlet can follow.
    pub fn section_flow(&self, point: DVec3, normal: DVec3, across: [DVec3; 2]) -> Option<(f64, f64)> {
        if D == 2 {
            self.fit_section(point, normal, |n, [s, _]| [1.0, n, s, s * s], across)
        } else {
            self.fit_section(point, normal, |n, [s, t]| [1.0, n, s, t, s * s, s * t, t * t], across)
        }
    }

    fn fit_section<const N: usize>(
        &self,
        point: DVec3,
        normal: DVec3,
        basis: impl Fn(f64, [f64; 2]) -> [f64; N],
        across: [DVec3; 2],
    ) -> Option<(f64, f64)> {
        let particles = self.neighbours.particles;
        let scale = 1.0 / self.pair.smoothing_length;
        let (mut moments, mut right) = ([[0.0; N]; N], [0.0; N]);
        let (mut velocity, mut pressure) = (0.0, 0.0);
        self.neighbours.for_each(std::array::from_fn(|axis| point[axis]), |row, x_ab, r_squared| {
            if !(self.sees)(particles.zone[row]) {
                return;
            }
            let mut offset = DVec3::ZERO;
            for axis in 0..D {
                offset[axis] = -x_ab[axis] * scale;
            }
            let functions = basis(offset.dot(normal), across.map(|along| offset.dot(along)));
            let w = self.pair.w(r_squared.sqrt());
            let v = particles.velocity_of(row).dot(normal);
            for i in 0..N {
                for j in 0..N {
                    moments[i][j] += w * functions[i] * functions[j];
                }
                right[i] += w * functions[i] * v;
            }
            velocity += w * v;
            pressure += w * particles.pressure[row].to_f64();
        });
        let weight = moments[0][0];
        if weight <= 0.0 {
            return None;
        }
        let fitted = solve(moments.map(|row| row.map(|m| m / weight)), right.map(|r| r / weight));
        Some((fitted.map_or(velocity / weight, |coefficients| coefficients[0]), pressure / weight))
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
        let shepard = DVec4::new(sums.x_axis.x, sums.y_axis.x, sums.z_axis.x, sums.w_axis.x) / total;
        let mut scaled = moments * (1.0 / total);
        for unused in D + 1..4 {
            scaled.col_mut(unused)[unused] = 1.0;
        }
        if scaled.determinant() < SMALLEST_DETERMINANT {
            return Some(shepard);
        }
        let inverse = scaled.inverse() * (1.0 / total);
        let first_row = inverse.row(0);
        Some(DVec4::new(
            first_row.dot(sums.x_axis),
            first_row.dot(sums.y_axis),
            first_row.dot(sums.z_axis),
            first_row.dot(sums.w_axis),
        ))
    }
}
