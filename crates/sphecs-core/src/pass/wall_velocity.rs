//! Velocities in the viscous term of the fluid where walls are dummy particles.
//!
//! ```text
//! ṽ_w = Σ_b v_b W_wb / Σ_b W_wb   over fluid, inflow and outflow;
//! velocity of the dummy: physics/wall/dummy.rs
//! ```
//!
//! These are Eqs. 22 and 23 of Adami et al. (2012). All other particles enter with their own
//! velocity. A wall particle without such a neighbour has the velocity of its wall, since it is in
//! no support.

use std::ops::Range;

use super::density::squared_distance;
use super::pack::{Only, Pack, Source};
use super::rates::TimeLevel;
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::walls::LEAST_WEIGHT;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::wall::dummy;

/// Writer of the velocities in the viscous term.
#[derive(Debug)]
pub struct WallVelocity(());

/// Finds the velocities of all particles in the viscous term, from those of a level, into
/// `sums.velocity_seen`.
pub fn find_velocity_seen<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if !sums.columns.find_walls(pair, particles) {
        return;
    }
    let PairSums { velocity_seen, columns, packs, .. } = sums;
    let velocity_seen = velocity_seen.write(WallVelocity(()));
    for column in velocity_seen.iter_mut() {
        column.resize(particles.len(), R::default());
    }
    let velocity = level.columns(particles);
    let input = PassInput {
        pair,
        grid,
        position: &particles.position,
        columns: &velocity.each_ref().map(Vec::as_slice),
        only: Only::NotPositive(&columns.image_distance, &columns.walls_before),
        packs,
    };
    let outputs = velocity_seen.each_mut().map(Vec::as_mut_slice);
    input.run(&WallVelocityPass { pair, particles, velocity }, outputs);
}

struct WallVelocityPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
    velocity: &'a [Vec<R>; D],
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for WallVelocityPass<'a, R, D> {
    type Outputs = [&'a mut [R]; D];
    /// Kernel mean of the flow's velocity, m/s; None where there is no flow.
    type Sum = Option<[f64; D]>;

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.particles.zone[row] == Zone::Wall
    }

    #[inline(always)]
    fn isolated(&self) -> Option<Self::Sum> {
        Some(None)
    }

    #[inline(always)]
    fn begin(&self, rows: Range<usize>, seen: &mut Self::Outputs) {
        for (seen, velocity) in seen.iter_mut().zip(self.velocity) {
            seen[..rows.len()].copy_from_slice(&velocity[rows.clone()]);
        }
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> Self::Sum {
        mean_velocity::<K, L, D>(pack, pack.relative(source, row))
    }

    #[inline(always)]
    fn store(&self, row: usize, slot: usize, sum: Self::Sum, seen: &mut Self::Outputs) {
        let Some(mean) = sum else { return };
        let wall = std::array::from_fn(|d| self.velocity[d][row].to_f64());
        let dummy = if self.pair.wall_part(self.particles.patch[row]).free_slip {
            let normal = std::array::from_fn(|d| self.particles.wall_normal[d][row].to_f64());
            dummy::free_slip(wall, mean, normal)
        } else {
            dummy::no_slip(wall, mean)
        };
        for d in 0..D {
            seen[d][slot] = R::from_f64(dummy[d]);
        }
    }
}

/// Returns the kernel mean of the packed flow's velocity at a point, m/s; None where there is no
/// flow.
#[inline(always)]
fn mean_velocity<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
) -> Option<[f64; D]> {
    let zero = L::constant(0.0);
    let x_w = splat::<L, D>(point);
    let mut sum = [zero; D];
    let mut weights = zero;
    for entry in pack.entries::<L>(2 * D) {
        let weight = K::value(squared_distance(x_w, entry).roots().0);
        for d in 0..D {
            sum[d] = entry.column(D + d).mul_add(weight, sum[d]);
        }
        weights = weights + weight;
    }
    let weights = weights.sum().to_f64();
    let sums = lanes::sums(sum);
    (weights > LEAST_WEIGHT).then(|| sums.map(|sum| sum / weights))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::column_access::AfterPasses;
    use crate::pass::samples::{SPACING, Sample, dummy_velocity, noise, settings};
    use crate::pass::settings::WallPartSettings;

    /// Disordered fluid over a moving, partly free-slip wall, checked particle by particle.
    fn check<R: Real, const D: usize>(kernel: Kernel, counts: [usize; D], tolerance: f64) {
        let free_slip = WallPartSettings { free_slip: true, ..Default::default() };
        let pair = PairSettings {
            wall_parts: [WallPartSettings::default(), free_slip].into(),
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
        find_velocity_seen(pair, grid, particles, TimeLevel::Present, sums);
        let mut walls = 0;
        for row in 0..sample.particles.len() {
            let expected = dummy_velocity(&sample, row);
            for d in 0..D {
                let found = sample.sums.velocity_seen.read(AfterPasses)[d][row].to_f64();
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
    fn dummy_velocities_agree_with_the_formula_and_the_flow_keeps_its_own() {
        for kernel in Kernel::ALL {
            check::<f64, 2>(kernel, [12, 14], 1e-12);
            check::<f64, 3>(kernel, [6, 9, 5], 1e-12);
            check::<f32, 2>(kernel, [12, 14], 1e-5);
        }
    }
}
