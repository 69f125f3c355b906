//! Density by summation, and where it follows from it the pressure by Tait, in one sweep.
//!
//! Under Tait's equation the fluid's alone: a condition sets the pressure of walls and zones, and the density follows. Where the
//! pressure evolves, a condition's pressure says nothing of the volumes: inflow and outflow are summed too, and walls have
//! the reference density, which is the sum over their lattice: their own would be cut off behind the last layer.

use std::ops::Range;

use super::blocks::for_each_block;
use super::pack::{
    CULLED_DIMENSIONS, CoveredLanes, Entry, MaskBuilder, NeighbourMask, Only, Pack, Source, mask_len,
};
use super::settings::{PairSettings, PressureLaw};
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::density;

/// Least r²/h² under a root: a particle meets itself, and 1/√0 would spoil its own share of the sum.
pub(super) const LEAST_Q2: f64 = 1e-30;

/// Sums the density of the rows that the settings name over all rows, themselves included, and sets the pressure of the fluid
/// where it is Tait's.
pub fn sum_density<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    sums.near.resize(mask_len::<D>(particles.len()), NeighbourMask::ALL);
    sums.columns.forget_densities();
    pair.kernel.with_shape(DensityPass { pair, grid, particles, sums });
}

struct DensityPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a mut ParticleArrays<R, D>,
    sums: &'a mut PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for DensityPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &[],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let zone = &self.particles.zone;
        let packs = &self.sums.packs;
        let outputs =
            ([&mut self.particles.density[..], &mut self.particles.pressure[..]], &mut self.sums.near[..]);
        let work = |cells: Range<usize>, ([density, pressure], near): Outputs<R>| {
            let block = DensityBlock::<K, R, D> {
                pair: self.pair,
                source: &source,
                zone,
                cells,
                density,
                pressure,
                near,
                pack: &mut packs.of_this_thread(),
                shape: std::marker::PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        for_each_block(self.grid, outputs, &work, &|(), ()| ());
    }
}

/// Density and pressure of a block's rows, and what is near them.
type Outputs<'a, R> = ([&'a mut [R]; 2], &'a mut [NeighbourMask]);

struct DensityBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    cells: Range<usize>,
    density: &'a mut [R],
    pressure: &'a mut [R],
    near: &'a mut [NeighbourMask],
    pack: &'a mut Pack<R>,
    shape: std::marker::PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for DensityBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.pair.sums_density(self.zone[row])) {
                continue;
            }
            for row in rows {
                if self.pair.sums_density(self.zone[row]) {
                    let point = self.pack.relative(self.source, row);
                    let (sum, near) = kernel_sum::<K, L, D>(self.pack, point);
                    self.density[row - first] = sum;
                    if let Some(slot) = self.near.get_mut(row - first) {
                        *slot = near;
                    }
                }
            }
        }
        let rows = first..grid.rows(self.cells.end - 1).end;
        finish(self.pair, &self.zone[rows], self.density, self.pressure);
    }
}

/// Makes densities and pressures of the kernel sums of rows. Apart from the sums: one row's chain of dependent
/// operations would hold up the next row's sum. Without a branch, so that the loop becomes one over vectors: what has no sum keeps what it has.
#[inline(always)]
pub(super) fn finish<R: Real>(pair: &PairSettings, zone: &[Zone], density: &mut [R], pressure: &mut [R]) {
    let scale = pair.kernel_scale();
    let by_tait = pair.pressure == PressureLaw::Tait;
    let of_walls = R::from_f64(pair.tait.reference_density);
    for ((density, pressure), &zone) in density.iter_mut().zip(pressure).zip(zone) {
        let is_summed = pair.sums_density(zone);
        let sum = density.to_f64() * scale;
        let rho = density::from_kernel_sum(sum, pair.mass, pair.lattice.density);
        let unsummed = if (zone == Zone::Wall) & !by_tait { of_walls } else { *density };
        *density = if is_summed { R::from_f64(rho) } else { unsummed };
        let found = R::from_f64(pair.tait.pressure(rho));
        *pressure = if is_summed & by_tait { found } else { *pressure };
    }
}

/// Σ w(q) over a pack, and which of its vectors have something in the support.
#[inline(always)]
fn kernel_sum<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
) -> (L::Real, NeighbourMask) {
    let mut x_a = [L::constant(0.0); D];
    for d in 0..D {
        x_a[d] = L::splat(point[d]);
    }
    let mut sum = L::constant(0.0);
    let mut near = NeighbourMask::ALL;
    let mut covered = CoveredLanes::default();
    let limit = L::constant(K::SUPPORT * K::SUPPORT);
    for tile in pack.tiles::<L, D>(D) {
        let builder = if finds_neighbours_first::<K, L, D>() {
            let builder = tile.find_neighbours(x_a, limit);
            for lane in tile.start_lanes(builder, &mut covered) {
                sum = K::add_value(squared_distance(x_a, tile.at_lane(lane)).roots().0, sum);
            }
            builder
        } else {
            let mut builder = MaskBuilder::default();
            for vector in 0..tile.len() {
                let q2 = squared_distance(x_a, tile.at(vector));
                builder.add::<L, D>(q2, limit);
                sum = K::add_value(q2.roots().0, sum);
            }
            builder
        };
        tile.store_mask(builder, &mut near);
    }
    (sum.sum(), near)
}

/// Whether what is near is found before its values are. It spares roots and values of what is not, and costs distances twice and a wrong guess
/// a row: in single precision, whose vectors are fewer and whose roots are cheap, about as much as it spares, or more.
const fn finds_neighbours_first<K: KernelShape, L: Lanes, const D: usize>() -> bool {
    let is_double = size_of::<L::Real>() == size_of::<f64>();
    D < CULLED_DIMENSIONS && is_double && (L::COSTLY_ROOTS || K::COSTLY_VALUE)
}

/// q² of the neighbours of a vector.
#[inline(always)]
pub(super) fn squared_distance<L: Lanes, const D: usize>(x_a: [L; D], neighbours: Entry<'_, L>) -> L {
    let mut q2 = L::constant(LEAST_Q2);
    for x in neighbours.seen_from(x_a) {
        q2 = x.mul_add(x, q2);
    }
    q2
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::math::lanes::InstructionSet;
    use crate::pass::samples::{SPACING, Sample, WATER, settings};

    fn check_uniform<const D: usize>(kernel: Kernel, ratio: f64, counts: [usize; D]) {
        for set in InstructionSet::available() {
            let mut pair = settings(kernel, D, ratio);
            pair.lanes = set;
            let mut sample = Sample::<f64, D>::lattice(pair, counts, true);
            sample.density();
            for row in 0..sample.particles.len() {
                let error = sample.particles.density[row] / WATER.reference_density - 1.0;
                assert!(error.abs() < 1e-12, "{kernel:?}, {} lanes: {error}", set.name());
                let pressure = sample.particles.pressure[row];
                assert!(pressure.abs() < 1e-10 * 1000.0 * 16.0, "p = {pressure} Pa");
            }
            sample.rates();
            for column in sample.particles.acceleration.iter() {
                for acceleration in column {
                    assert!(acceleration.abs() < 1e-11 * 16.0 / SPACING, "dv/dt = {acceleration} m/s²");
                }
            }
        }
    }

    #[test]
    fn uniform_fill_has_the_reference_density_and_no_force() {
        check_uniform(Kernel::WendlandC2, 1.3, [24, 17]);
        check_uniform(Kernel::WendlandC2, 2.0, [11, 3]);
        check_uniform(Kernel::QuinticSpline, 1.2, [12, 13]);
        check_uniform(Kernel::WendlandC2, 2.02, [9, 10, 1]);
        check_uniform(Kernel::QuinticSpline, 1.0, [5, 8, 7]);
    }

    #[test]
    fn sum_is_that_over_all_neighbours() {
        for kernel in Kernel::ALL {
            let mut sample = Sample::<f64, 3>::lattice(settings(kernel, 3, 1.3), [7, 6, 9], false);
            sample.stir(0.4, 1.0);
            sample.particles.zone[5] = Zone::Wall;
            sample.density();
            assert_eq!(
                sample.particles.density[5], WATER.reference_density,
                "a wall's density is not summed"
            );
            let neighbours = crate::pass::neighbours::Neighbours::new(&sample.grid, &sample.particles);
            for row in (0..sample.particles.len()).filter(|&row| row != 5) {
                let mut sum = 0.0;
                let point = std::array::from_fn(|d| sample.particles.position[d][row]);
                neighbours.for_each(point, |_, _, r2| {
                    sum += kernel.value(3, sample.pair.smoothing_length, r2.sqrt());
                });
                let expected = sum * sample.pair.mass / sample.pair.lattice.density;
                let found = sample.particles.density[row];
                assert!((found / expected - 1.0).abs() < 1e-13, "{found}, not {expected}");
            }
        }
    }
}
