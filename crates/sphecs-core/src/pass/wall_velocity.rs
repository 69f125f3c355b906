//! Velocities as the viscous term of the fluid sees them, where walls are dummy particles.
//!
//! ```text
//! ṽ_w = Σ_b v_b W_wb / Σ_b W_wb   over fluid, inflow and outflow;   what is seen: physics/wall/dummy.rs
//! ```
//!
//! Adami et al. (2012), Eqs. 22 and 23. All other rows are seen as they move. A wall particle without such a neighbour has the
//! velocity of its wall: nobody can see it.

use std::marker::PhantomData;
use std::ops::Range;

use super::blocks::for_each_block;
use super::density::LEAST_Q2;
use super::pack::{Only, Pack, Source};
use super::rates::VelocityLevel;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{self, Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::wall::dummy;

/// Least Σ w(q) that is divided by: less is at the very edge of the support, where nothing is felt.
const LEAST_SUM: f64 = 1e-20;

/// Finds the velocities that are seen, from those of a level, into `sums.velocity_seen`.
pub fn find_velocity_seen<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if sums.columns.find_walls(pair, particles) == 0 {
        return;
    }
    for column in &mut sums.velocity_seen {
        column.resize(particles.len(), R::default());
    }
    pair.kernel.with_shape(SeenPass { pair, grid, particles, level, sums });
}

struct SeenPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &'a mut PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for SeenPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let PairSums { velocity_seen, columns, packs, .. } = self.sums;
        let velocity = self.level.columns(self.particles);
        let neighbours: [&[R]; D] = velocity.each_ref().map(Vec::as_slice);
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &neighbours,
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::NotPositive(&columns.image_distance, &columns.walls_before),
        };
        let work = |cells: Range<usize>, seen: [&mut [R]; D]| {
            let block = SeenBlock::<K, R, D> {
                pair: self.pair,
                source: &source,
                particles: self.particles,
                cells,
                seen,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        for_each_block(self.grid, velocity_seen.each_mut().map(Vec::as_mut_slice), &work, &|(), ()| ());
    }
}

struct SeenBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    particles: &'a ParticleArrays<R, D>,
    cells: Range<usize>,
    seen: [&'a mut [R]; D],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for SeenBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(mut self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            for (seen, velocity) in self.seen.iter_mut().zip(self.source.columns) {
                seen[rows.start - first..rows.end - first].copy_from_slice(&velocity[rows.clone()]);
            }
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.particles.zone[row] == Zone::Wall) {
                continue;
            }
            let flow = self.pack.bounds::<L, D>();
            for row in rows {
                if self.particles.zone[row] != Zone::Wall {
                    continue;
                }
                let point = self.pack.relative(self.source, row);
                if flow.out_of_reach(point, K::SUPPORT * K::SUPPORT) {
                    continue;
                }
                let Some(mean) = mean_velocity::<K, L, D>(self.pack, point) else { continue };
                let wall = std::array::from_fn(|d| self.source.columns[d][row].to_f64());
                let seen = if self.pair.wall_part(self.particles.patch[row]).free_slip {
                    let normal = std::array::from_fn(|d| self.particles.wall_normal[d][row].to_f64());
                    dummy::free_slip(wall, mean, normal)
                } else {
                    dummy::no_slip(wall, mean)
                };
                for d in 0..D {
                    self.seen[d][row - first] = R::from_f64(seen[d]);
                }
            }
        }
    }
}

/// Kernel mean of the packed flow's velocity at a point, m/s; None where there is no flow.
#[inline(always)]
fn mean_velocity<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
) -> Option<[f64; D]> {
    let zero = L::constant(0.0);
    let mut x_w = [zero; D];
    for d in 0..D {
        x_w[d] = L::splat(point[d]);
    }
    let mut sum = [zero; D];
    let mut weights = zero;
    for entry in pack.entries::<L>(2 * D) {
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            let x = x_w[d] - entry.column(d);
            q2 = x.mul_add(x, q2);
        }
        let weight = K::value(q2.roots().0);
        for d in 0..D {
            sum[d] = entry.column(D + d).mul_add(weight, sum[d]);
        }
        weights = weights + weight;
    }
    let weights = weights.sum().to_f64();
    let sums = lanes::sums(sum);
    (weights > LEAST_SUM).then(|| sums.map(|sum| sum / weights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample, dummy_velocity, noise, settings};
    use crate::pass::settings::WallPartSettings;

    /// Stirred fluid over a wall that moves and in parts lets the fluid slip, checked row by row against the formula.
    fn check<R: Real, const D: usize>(kernel: Kernel, counts: [usize; D], tolerance: f64) {
        let free_slip = WallPartSettings { free_slip: true, ..Default::default() };
        let pair = PairSettings {
            wall_parts: vec![WallPartSettings::default(), free_slip],
            ..settings(kernel, D, 1.3)
        };
        let mut sample = Sample::<R, D>::lattice(pair, counts, false);
        sample.stir(0.2, 1.0);
        for row in 0..sample.particles.len() {
            let height = sample.particles.position[1][row] + 0.3;
            if height < 4.0 * SPACING {
                sample.particles.zone[row] = Zone::Wall;
                sample.particles.patch[row] = u16::from(noise(8 * sample.particles.id[row]) > 0.0);
                sample.particles.wall_distance[row] = R::from_f64(4.0 * SPACING - height);
                sample.particles.wall_normal[0][row] = R::from_f64(0.6);
                sample.particles.wall_normal[1][row] = R::from_f64(0.8);
            }
        }
        let Sample { pair, grid, particles, sums } = &mut sample;
        find_velocity_seen(pair, grid, particles, VelocityLevel::Present, sums);
        let mut walls = 0;
        for row in 0..sample.particles.len() {
            let expected = dummy_velocity(&sample, row);
            for d in 0..D {
                let found = sample.sums.velocity_seen[d][row].to_f64();
                assert!(
                    (found - expected[d]).abs() < tolerance,
                    "{kernel:?} {row}: {found}, not {expected:?}"
                );
            }
            walls += usize::from(sample.particles.velocity[0][row].to_f64() != expected[0]);
        }
        assert!(walls >= 2 * counts[0], "{walls} wall particles see the fluid");
    }

    #[test]
    fn walls_are_seen_as_the_formula_has_them_and_the_flow_as_it_moves() {
        for kernel in Kernel::ALL {
            check::<f64, 2>(kernel, [12, 14], 1e-12);
            check::<f64, 3>(kernel, [6, 9, 5], 1e-12);
            check::<f32, 2>(kernel, [12, 14], 1e-5);
        }
    }
}
