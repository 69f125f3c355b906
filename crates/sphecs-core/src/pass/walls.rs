//! Pressure of the wall particles, extrapolated from the fluid.
//!
//! ```text
//! p_w = Σ_b [p_b + ρ_b (g − a_wall)·x_wb] W_wb / Σ_b W_wb,   ρ_w by the inverse of Tait, where the fluid's pressure is Tait's
//! ```
//!
//! Adami et al. (2012), Eq. 27, over fluid, inflow and outflow. A wall particle without such a neighbour has the
//! reference state: nobody can see it.

use std::marker::PhantomData;
use std::ops::Range;

use super::blocks::{for_each_block, for_each_part};
use super::density::LEAST_Q2;
use super::pack::{Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::{PairColumns, PairSums};
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Least Σ w(q) that is divided by: less is at the very edge of the support, where nothing is felt.
const LEAST_SUM: f64 = 1e-20;

/// Rows that are looked at together.
const GROUP: usize = 64;

/// Columns of the pack beside the coordinates: density and pressure of the flow.
const COLUMNS: usize = 2;

/// Sets pressure and density of the wall rows from the flow around them; `carried` is g − a_wall at a wall row, m/s².
pub fn extrapolate_wall_pressure<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
    carried: &(impl Fn(&ParticleArrays<R, D>, usize) -> [f64; D] + Sync),
) {
    sums.packs.prepare();
    if sums.columns.find_walls(pair, particles) == 0 {
        return;
    }
    sums.columns.wall_pressure.resize(particles.len(), R::default());
    pair.kernel.with_shape(WallPass { pair, grid, particles: &*particles, sums, carried });
    // Written only now: the extrapolation reads pressures while it runs.
    let PairColumns { wall_pressure, walls_before, .. } = &sums.columns;
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

struct WallPass<'a, F, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    sums: &'a mut PairSums<R, D>,
    carried: &'a F,
}

impl<F: Fn(&ParticleArrays<R, D>, usize) -> [f64; D] + Sync, R: Real, const D: usize> WithShape
    for WallPass<'_, F, R, D>
{
    type Output = ();

    fn run<K: KernelShape>(self) {
        let columns = &mut self.sums.columns;
        let neighbours: [&[R]; COLUMNS] = [&self.particles.density, &self.particles.pressure];
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &neighbours,
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::NotPositive(&columns.image_distance, &columns.walls_before),
        };
        let packs = &self.sums.packs;
        let work = |cells: Range<usize>, pressure: &mut [R]| {
            let block = WallBlock::<K, F, R, D> {
                pair: self.pair,
                carried: self.carried,
                source: &source,
                particles: self.particles,
                cells,
                pressure,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        for_each_block(self.grid, columns.wall_pressure.as_mut_slice(), &work, &|(), ()| ());
    }
}

struct WallBlock<'a, K, F, R: Real, const D: usize> {
    pair: &'a PairSettings,
    carried: &'a F,
    source: &'a Source<'a, R, D>,
    particles: &'a ParticleArrays<R, D>,
    cells: Range<usize>,
    pressure: &'a mut [R],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, F: Fn(&ParticleArrays<R, D>, usize) -> [f64; D], R: Real, const D: usize> Vectorised<R>
    for WallBlock<'_, K, F, R, D>
{
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        for cell in self.cells {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.particles.zone[row] == Zone::Wall) {
                continue;
            }
            let flow = self.pack.bounds::<L, D>();
            for row in rows {
                if self.particles.zone[row] != Zone::Wall {
                    continue;
                }
                let point = self.pack.relative(self.source, row);
                // Of several layers the last has no flow in its support.
                let pressure = if flow.out_of_reach(point, K::SUPPORT * K::SUPPORT) {
                    0.0
                } else {
                    let force = (self.carried)(self.particles, row).map(|g| g * self.pair.smoothing_length);
                    mean_pressure::<K, L, D>(self.pack, point, force)
                };
                self.pressure[row - first] = R::from_f64(pressure);
            }
        }
    }
}

/// Kernel mean of the packed flow's pressure carried to a point by `force` (m²/s²: force per mass times h).
#[inline(always)]
fn mean_pressure<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
    force: [f64; D],
) -> f64 {
    let zero = L::constant(0.0);
    let mut x_w = [zero; D];
    let mut force_w = [zero; D];
    for d in 0..D {
        x_w[d] = L::splat(point[d]);
        force_w[d] = L::constant(force[d]);
    }
    let mut sum = zero;
    let mut weights = zero;
    for entry in pack.entries::<L>(D + COLUMNS) {
        let mut x = [zero; D];
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            x[d] = x_w[d] - entry.column(d);
            q2 = x[d].mul_add(x[d], q2);
        }
        let weight = K::value(q2.roots().0);
        let pressure = entry.column(D).mul_add(dot(force_w, x), entry.column(D + 1));
        sum = pressure.mul_add(weight, sum);
        weights = weights + weight;
    }
    let weights = weights.sum().to_f64();
    if weights > LEAST_SUM { sum.sum().to_f64() / weights } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample, WATER, noise, settings};

    /// Fluid above a wall, its pressure given by height.
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
    fn hydrostatic_pressure_goes_on_into_the_wall() {
        for kernel in Kernel::ALL {
            let pair = settings(kernel, 2, 1.3);
            let hydrostatic = |height: f64| 50.0 - 1000.0 * 10.0 * height;
            let mut sample = over_a_wall(pair, hydrostatic);
            extrapolate(&mut sample, [0.0, -10.0]);
            let reach = sample.pair.support();
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
    fn wall_pressure_stays_within_the_fluids() {
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
