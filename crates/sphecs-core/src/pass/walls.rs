//! Pressure and density of the wall particles, extrapolated from the flow.
//!
//! ```text
//! p_w = Σ_b [p_b + ρ_b (g − a_wall)·x_wb] W_wb / Σ_b W_wb,
//! ρ_w by the inverse of Tait, where the pressure is Tait's
//! ```
//!
//! This is Eq. 27 of Adami et al. (2012), summed over fluid, inflow and outflow. A wall particle
//! without such a neighbour has the reference state, since it is in no support.

use std::ops::Range;

use super::blocks::{GROUP, for_each_part};
use super::column_access::WallPressures;
use super::density::LEAST_Q2;
use super::pack::{ColumnList, Only, Pack, Source, Vector};
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::{PairColumns, PairSums};
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Smallest Σ w(q) to divide by; a smaller sum occurs only at the edge of the support, where
/// nothing contributes.
pub(super) const LEAST_WEIGHT: f64 = 1e-20;

/// Most columns of the pack besides the coordinates: density and pressure of the flow, facing.
const MOST_COLUMNS: usize = 5;

/// Sets pressure and density of the wall particles from the flow around them.
///
/// `force` returns g − a_wall at the wall particle of a row, m/s².
pub fn extrapolate_wall_pressure<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
    force: &WallForce<'_, R, D>,
) {
    sums.packs.prepare();
    if !sums.columns.find_walls(pair, particles) {
        return;
    }
    let PairColumns { wall_pressure, image_distance, walls_before, .. } = &mut sums.columns;
    wall_pressure.resize(particles.len(), R::default());
    let mut list = ColumnList::<R, D, MOST_COLUMNS>::empty();
    list.add_scalar(&particles.density);
    list.add_scalar(&particles.pressure);
    let sides = sums.sides.read(WallPressures);
    let facing = (!sides.facing[0].is_empty()).then(|| list.add_vector(&sides.facing));
    let input = PassInput {
        pair,
        grid,
        position: &particles.position,
        columns: list.as_slice(),
        only: Only::NotPositive(image_distance, walls_before),
        packs: &sums.packs,
    };
    input.run(&WallPressurePass { pair, particles: &*particles, force, facing }, &mut wall_pressure[..]);
    set_wall_states(pair, particles, wall_pressure, walls_before);
}

/// Sets pressure and density of the wall particles after the pass, which reads pressures while it
/// runs.
fn set_wall_states<R: Real, const D: usize>(
    pair: &PairSettings,
    particles: &mut ParticleArrays<R, D>,
    wall_pressure: &[R],
    walls_before: &[u32],
) {
    let zone = &particles.zone;
    let work = |rows: Range<usize>, [pressure, density]: [&mut [R]; 2]| {
        let first = rows.start;
        for start in rows.clone().step_by(GROUP) {
            let group = start..rows.end.min(start + GROUP);
            // Most groups of rows have no wall.
            if walls_before[group.start] == walls_before[group.end] {
                continue;
            }
            for row in group.filter(|&row| zone[row] == Zone::Wall) {
                pressure[row - first] = wall_pressure[row];
                if let Some(rho) = pair.density_at(wall_pressure[row].to_f64()) {
                    density[row - first] = R::from_f64(rho);
                }
            }
        }
    };
    for_each_part(0..zone.len(), [&mut particles.pressure[..], &mut particles.density[..]], &work);
}

/// Returns g − a_wall at the wall particle of a row, m/s².
type WallForce<'a, R, const D: usize> = dyn Fn(&ParticleArrays<R, D>, usize) -> [f64; D] + Sync + 'a;

struct WallPressurePass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
    force: &'a WallForce<'a, R, D>,
    /// Facing of the flow, only where a wall is thin.
    facing: Option<Vector>,
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for WallPressurePass<'a, R, D> {
    type Outputs = &'a mut [R];
    /// Pressure, Pa.
    type Sum = f64;

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.particles.zone[row] == Zone::Wall
    }

    /// The last of several wall layers has no flow in its support.
    #[inline(always)]
    fn isolated(&self) -> Option<f64> {
        Some(0.0)
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> f64 {
        let force = (self.force)(self.particles, row).map(|g| g * self.pair.discretisation.smoothing_length);
        let facing = self.facing.map(|facing| (facing, source.splat_vector::<L>(facing, row)));
        mean_pressure::<K, L, D>(pack, source.columns.len(), pack.relative(source, row), force, facing)
    }

    #[inline(always)]
    fn store(&self, _row: usize, slot: usize, sum: f64, pressure: &mut &'a mut [R]) {
        pressure[slot] = R::from_f64(sum);
    }
}

/// Returns the kernel mean of the flow's pressure, Pa, continued to a point by `force` (force per
/// mass times h, m²/s²).
#[inline(always)]
fn mean_pressure<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    columns: usize,
    point: [L::Real; D],
    force: [f64; D],
    facing: Option<(Vector, [L; D])>,
) -> f64 {
    let zero = L::constant(0.0);
    let x_w = splat::<L, D>(point);
    let mut force_w = [zero; D];
    for d in 0..D {
        force_w[d] = L::constant(force[d]);
    }
    let mut sum = zero;
    let mut weights = zero;
    for entry in pack.entries::<L>(D + columns) {
        let mut x = [zero; D];
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            x[d] = x_w[d] - entry.column(d);
            q2 = x[d].mul_add(x[d], q2);
        }
        let mut weight = K::value(q2.roots().0);
        if let Some((facing, own)) = facing {
            // The flow on the other side of a thin wall does not count.
            let depth = (-dot(entry.vector_at(facing), own)).max(zero);
            let behind = L::select(zero.less(dot(x, own)), depth, zero);
            weight = L::select(zero.less(behind), zero, weight);
        }
        let pressure = entry.column(D).mul_add(dot(force_w, x), entry.column(D + 1));
        sum = pressure.mul_add(weight, sum);
        weights = weights + weight;
    }
    let weights = weights.sum().to_f64();
    if weights > LEAST_WEIGHT { sum.sum().to_f64() / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample, WATER, noise, settings};

    /// Returns fluid above a wall with a pressure that depends on height.
    fn over_a_wall(pair: PairSettings, pressure: impl Fn(f64) -> f64) -> Sample<f64, 2> {
        let mut sample = Sample::<f64, 2>::lattice(pair, [12, 14], false);
        for row in 0..sample.particles.len() {
            let height = sample.particles.position[1][row] + 0.3;
            if height < 5.0 * SPACING {
                sample.particles.zone[row] = Zone::Wall;
                sample.particles.pressure[row] = 1e6;
                sample.particles.wall_distance[row] = 5.0 * SPACING - height;
            } else {
                sample.particles.pressure[row] = pressure(height);
            }
        }
        sample
    }

    fn extrapolate(sample: &mut Sample<f64, 2>, force: [f64; 2]) {
        let carried = |_: &ParticleArrays<f64, 2>, _| force;
        extrapolate_wall_pressure(
            &sample.pair,
            &sample.grid,
            &mut sample.particles,
            &mut sample.sums,
            &carried,
        );
    }

    #[test]
    fn hydrostatic_pressure_is_continued_into_the_wall() {
        for kernel in Kernel::ALL {
            let pair = settings(kernel, 2, 1.3);
            let hydrostatic = |height: f64| 50.0 - 1000.0 * 10.0 * height;
            let mut sample = over_a_wall(pair, hydrostatic);
            extrapolate(&mut sample, [0.0, -10.0]);
            let reach = sample.pair.discretisation.support;
            for row in 0..sample.particles.len() {
                let height = sample.particles.position[1][row] + 0.3;
                let found = sample.particles.pressure[row];
                let below = 5.5 * SPACING - height;
                let expected = if below < reach { hydrostatic(height) } else { 0.0 };
                assert!((found - expected).abs() < 1e-9, "{kernel:?} at {height} m: {found} Pa");
                if sample.particles.zone[row] == Zone::Wall {
                    assert_eq!(sample.particles.density[row], WATER.density(found));
                }
            }
        }
    }

    #[test]
    fn wall_pressure_stays_within_the_range_of_the_fluid() {
        let mut sample = over_a_wall(settings(Kernel::WendlandC2, 2, 1.3), |_| 0.0);
        for row in 0..sample.particles.len() {
            if sample.particles.zone[row] == Zone::Fluid {
                sample.particles.pressure[row] = 100.0 + noise(row as u32);
            }
        }
        extrapolate(&mut sample, [0.0; 2]);
        for row in 0..sample.particles.len() {
            let pressure = sample.particles.pressure[row];
            assert!((99.0..=101.0).contains(&pressure) || pressure == 0.0, "{pressure} Pa");
        }
    }
}
