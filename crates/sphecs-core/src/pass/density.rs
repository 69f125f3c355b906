//! Density by summation, and the pressure by Tait's equation where it follows from the density.
//!
//! ```text
//! ρ_a = m Σ_b W_ab / C,   C: the same sum on the initial lattice;   p_a = p(ρ_a) by Tait
//! ```
//!
//! Under Tait's equation only the fluid is summed: a condition sets the pressure of walls and
//! zones, and their density follows from it. Where the pressure evolves, the pressure of a
//! condition does not determine the volumes, so inflow and outflow are summed too. Walls then have
//! the reference density, which is the sum over their lattice: their own sum would be cut off
//! behind the last layer.

use std::ops::Range;

use super::pack::{
    CULLED_DIMENSIONS, CoveredLanes, Entry, MaskBuilder, NeighbourMask, Only, Pack, Source, mask_len,
};
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::{PairSettings, PressureLaw};
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::summed_density;

/// Smallest r²/h² under a root: a particle is its own neighbour, and 1/√0 would corrupt its own
/// term of the sum.
pub(super) const LEAST_Q2: f64 = 1e-30;

/// Sums the density of the particles that the settings name over all particles, themselves
/// included.
///
/// Sets the pressure of the fluid where it follows from Tait's equation.
pub fn sum_density<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    sums.near.resize(mask_len::<D>(particles.len()), NeighbourMask::ALL);
    sums.columns.forget_densities();
    let ParticleArrays { zone, position, density, pressure, .. } = particles;
    let input = PassInput { pair, grid, position, columns: &[], only: Only::All, packs: &sums.packs };
    let outputs = ([&mut density[..], &mut pressure[..]], &mut sums.near[..]);
    input.run(&DensityPass { pair, zone }, outputs);
}

struct DensityPass<'a> {
    pair: &'a PairSettings,
    zone: &'a [Zone],
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for DensityPass<'a> {
    /// Density and pressure, and the vectors of the pack with a neighbour in the support.
    type Outputs = ([&'a mut [R]; 2], &'a mut [NeighbourMask]);
    type Sum = (R, NeighbourMask);

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.pair.sums_density(self.zone[row])
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> (R, NeighbourMask) {
        kernel_sum::<K, L, D>(pack, pack.relative(source, row))
    }

    #[inline(always)]
    fn store(
        &self,
        _row: usize,
        slot: usize,
        (sum, near): (R, NeighbourMask),
        ([density, _], masks): &mut Self::Outputs,
    ) {
        density[slot] = sum;
        if let Some(mask) = masks.get_mut(slot) {
            *mask = near;
        }
    }

    #[inline(always)]
    fn finish(&self, rows: Range<usize>, ([density, pressure], _): &mut Self::Outputs) {
        finish(self.pair, &self.zone[rows], density, pressure);
    }
}

/// Turns the kernel sums of particles into densities and pressures; a particle without a sum keeps
/// its values.
///
/// It is a separate loop because the dependent operations of one particle would delay the sum of
/// the next. It has no branch, so that the compiler vectorises it.
#[inline(always)]
pub(super) fn finish<R: Real>(pair: &PairSettings, zone: &[Zone], density: &mut [R], pressure: &mut [R]) {
    let scale = pair.discretisation.kernel_scale();
    let by_tait = pair.pressure == PressureLaw::Tait;
    let of_walls = R::from_f64(pair.tait.reference_density);
    for ((density, pressure), &zone) in density.iter_mut().zip(pressure).zip(zone) {
        let is_summed = pair.sums_density(zone);
        let sum = density.to_f64() * scale;
        let rho = summed_density::from_kernel_sum(sum, pair.discretisation.mass, pair.lattice.density);
        let unsummed = if (zone == Zone::Wall) & !by_tait { of_walls } else { *density };
        *density = if is_summed { R::from_f64(rho) } else { unsummed };
        let found = R::from_f64(pair.tait.pressure(rho));
        *pressure = if is_summed & by_tait { found } else { *pressure };
    }
}

/// Returns Σ w(q) over a pack, and its vectors with a neighbour in the support.
#[inline(always)]
fn kernel_sum<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
) -> (L::Real, NeighbourMask) {
    let x_a = splat::<L, D>(point);
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

/// Returns true if the neighbours in the support are found before their kernel values are computed.
///
/// That saves the roots and values of all others but computes every distance twice and mispredicts
/// a branch per particle. In single precision, with fewer vectors and cheap roots, it costs as much
/// as it saves, or more.
const fn finds_neighbours_first<K: KernelShape, L: Lanes, const D: usize>() -> bool {
    let is_double = size_of::<L::Real>() == size_of::<f64>();
    D < CULLED_DIMENSIONS && is_double && (L::COSTLY_ROOTS || K::COSTLY_VALUE)
}

/// Returns q² of the neighbours of a vector.
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
    fn sum_equals_the_sum_over_all_neighbours() {
        for kernel in Kernel::ALL {
            let mut sample = Sample::<f64, 3>::lattice(settings(kernel, 3, 1.3), [7, 6, 9], false);
            sample.stir(0.4, 1.0);
            sample.particles.zone[5] = Zone::Wall;
            sample.density();
            assert_eq!(
                sample.particles.density[5], WATER.reference_density,
                "the density of a wall is not summed"
            );
            let neighbours = crate::pass::neighbours::Neighbours::new(&sample.grid, &sample.particles);
            for row in (0..sample.particles.len()).filter(|&row| row != 5) {
                let mut sum = 0.0;
                let point = std::array::from_fn(|d| sample.particles.position[d][row]);
                neighbours.for_each(point, |_, _, r2| {
                    sum += kernel.value(3, sample.pair.discretisation.smoothing_length, r2.sqrt());
                });
                let expected = sum * sample.pair.discretisation.mass / sample.pair.lattice.density;
                let found = sample.particles.density[row];
                assert!((found / expected - 1.0).abs() < 1e-13, "{found}, not {expected}");
            }
        }
    }
}
