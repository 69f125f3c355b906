//! Force and torque on a body by the sums of `Wcsph`.

use super::VelocityLevel;
use super::layout::{Fields, Layout};
use super::row::PairLoop;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::pass::body::{Body, BodySum, RowForce, RowLoop, sum_body};
use crate::pass::pack::{Near, Pack, Source};
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;

/// Sums force and torque of the fluid on a body, with what the rates of the present step are made of.
pub fn sum_body_force<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
    body: &mut Body,
) -> BodySum {
    sums.packs.prepare();
    if !sums.columns.find_images(pair, particles) {
        return BodySum::default();
    }
    sums.columns.find_body(body.part, particles);
    let layout = Layout::new::<D>(pair, true);
    pair.kernel.with_shape(BodyPass { pair, layout, grid, particles, level, sums, body })
}

struct BodyPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    layout: Layout,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &'a PairSums<R, D>,
    body: &'a mut Body,
}

impl<R: Real, const D: usize> WithShape for BodyPass<'_, R, D> {
    type Output = BodySum;

    fn run<K: KernelShape>(self) -> BodySum {
        let (particles, sums) = (self.particles, self.sums);
        let velocity = match self.layout.sees_dummies(self.pair) {
            true => &sums.velocity_seen,
            false => self.level.columns(particles),
        };
        let (columns, count) = self.layout.in_order(Fields {
            velocity,
            scalars: [&particles.density, &particles.pressure],
            strain: &sums.strain,
            image_distance: &sums.columns.image_distance,
            wall_normal: &particles.wall_normal,
            stress: &sums.stress,
            crowding: &sums.crowding,
            fluid_volume: &sums.columns.fluid_volume,
        });
        let row_loop = OfRow {
            pair: self.pair,
            layout: self.layout,
            wall_distance: &particles.wall_distance,
            body_force: &sums.body_force,
        };
        sum_body::<K, R, D>(self.pair, self.grid, particles, &columns[..count], sums, &row_loop, self.body)
    }
}

/// The pair loop of a row, with all terms that the scene has.
struct OfRow<'a, R, const D: usize> {
    pair: &'a PairSettings,
    layout: Layout,
    wall_distance: &'a [R],
    body_force: &'a [Vec<R>; D],
}

impl<R: Real, const D: usize> RowLoop<R, D> for OfRow<'_, R, D> {
    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        point: [R; D],
        row: usize,
    ) -> RowForce<D> {
        let pair_loop = PairLoop::<L, D>::new(self.pair, self.layout, self.body_force);
        let distance = self.wall_distance[row].to_f64();
        let rates = pair_loop.sum::<K, false, false, false, false, true>(
            pack,
            source,
            point,
            row,
            Near::ALL,
            distance,
        );
        RowForce { acceleration: rates.acceleration, pressure: rates.split.0, moment: rates.split.1 }
    }
}
