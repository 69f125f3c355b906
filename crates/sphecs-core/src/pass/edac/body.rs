//! Force and torque on a body by the sums of `EdacTvf`.

use super::row::{Layout, PairLoop};
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::pass::body::{Body, BodySum, RowForce, RowLoop, sum_body};
use crate::pass::pack::{Near, Pack, Source};
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;
use crate::physics::edac::Edac;

/// Sums force and torque of the fluid on a body, with what the rates of the present step are made of.
pub fn sum_body_force<R: Real, const D: usize>(
    pair: &PairSettings,
    edac: &Edac,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
    body: &mut Body,
) -> BodySum {
    sums.packs.prepare();
    if !sums.columns.find_images(pair, particles) {
        return BodySum::default();
    }
    sums.columns.find_body(body.part, particles);
    let layout = Layout::new::<D>(pair, true);
    pair.kernel.with_shape(BodyPass { pair, edac, layout, grid, particles, sums, body })
}

struct BodyPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    edac: &'a Edac,
    layout: Layout,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    sums: &'a PairSums<R, D>,
    body: &'a mut Body,
}

impl<R: Real, const D: usize> WithShape for BodyPass<'_, R, D> {
    type Output = BodySum;

    fn run<K: KernelShape>(self) -> BodySum {
        let (particles, sums) = (self.particles, self.sums);
        let vectors = [&particles.velocity, &particles.drift, &particles.wall_normal, &sums.velocity_seen];
        let scalars: [&[R]; 2] = [&particles.density, &particles.pressure];
        let (columns, count) = self.layout.in_order(vectors, scalars, &sums.columns.image_distance);
        let row_loop = OfRow {
            pair: self.pair,
            edac: self.edac,
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
    edac: &'a Edac,
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
        let pair_loop = PairLoop::<L, D>::new(self.pair, self.edac, self.layout, self.body_force);
        let distance = self.wall_distance[row].to_f64();
        let rates = pair_loop.sum::<K, false, false, true>(pack, source, point, row, Near::ALL, distance);
        RowForce { acceleration: rates.acceleration, pressure: rates.split.0, moment: rates.split.1 }
    }
}
