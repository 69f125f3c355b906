//! Rates of the fluid where the pressure evolves: one fused pair loop for everything that the step needs.
//!
//! The equations stand in `physics/edac.rs`: Negi et al. (2020), Eqs. 6–11. The body force is the integrator's.
//! Lengths in the loop are in units of h, volumes in units of that of the lattice, the kernel without its norm: the
//! dimensions come back once per row.

pub mod body;
mod row;
#[cfg(test)]
mod tests;

use std::marker::PhantomData;
use std::ops::Range;

use row::{Layout, PairLoop};

use super::blocks::for_each_block;
use super::pack::{Near, Only, Pack, Source};
use super::rates::larger;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::edac::Edac;

/// The largest of what the time step and the monitor ask for, over all fluid rows. A value that is not a number shows
/// as such.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdacSummary {
    /// Largest |v|, m/s.
    pub speed: f64,
    /// Largest |∇·v|, 1/s.
    pub divergence: f64,
    /// Largest rate at which a dissipative term damps a particle's velocity or pressure among neighbours that keep theirs, 1/s.
    pub damping: f64,
}

impl EdacSummary {
    /// The larger of each, whatever the order.
    fn join(self, other: Self) -> Self {
        Self {
            speed: larger(self.speed, other.speed),
            divergence: larger(self.divergence, other.divergence),
            damping: larger(self.damping, other.damping),
        }
    }
}

/// Sums acceleration, rate of pressure, acceleration by the background pressure and divergence of the fluid rows over
/// all rows.
pub fn sum_rates<R: Real, const D: usize>(
    pair: &PairSettings,
    edac: &Edac,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) -> EdacSummary {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    for column in sums.shift.iter_mut().chain([&mut sums.divergence, &mut sums.pressure_rate]) {
        column.resize(particles.len(), R::default());
    }
    let layout = Layout::new::<D>(pair, has_walls);
    pair.kernel.with_shape(EdacPass { pair, edac, layout, grid, particles, sums })
}

struct EdacPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    edac: &'a Edac,
    layout: Layout,
    grid: &'a CellGrid<D>,
    particles: &'a mut ParticleArrays<R, D>,
    sums: &'a mut PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for EdacPass<'_, R, D> {
    type Output = EdacSummary;

    fn run<K: KernelShape>(self) -> EdacSummary {
        let ParticleArrays {
            zone,
            position,
            velocity,
            drift,
            acceleration,
            density,
            pressure,
            wall_distance,
            wall_normal,
            ..
        } = self.particles;
        let PairSums {
            shift,
            divergence,
            pressure_rate,
            velocity_seen,
            body_force,
            near,
            columns,
            packs,
            ..
        } = self.sums;
        let (body_force, near) = (&*body_force, &*near);
        let layout = self.layout;
        let images = &columns.image_distance;
        let vectors = [&*velocity, &*drift, &*wall_normal, &*velocity_seen];
        let (neighbours, count) = layout.in_order(vectors, [&*density, &*pressure], images);
        let source = Source {
            grid: self.grid,
            position,
            columns: &neighbours[..count],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let work = |cells: Range<usize>, (acceleration, shift, scalars): Outputs<R, D>| {
            let block = EdacBlock::<K, R, D> {
                pair: self.pair,
                edac: self.edac,
                layout,
                source: &source,
                zone,
                wall_distance,
                body_force,
                near,
                cells,
                outputs: (acceleration, shift, scalars),
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block)
        };
        let outputs = (
            acceleration.each_mut().map(Vec::as_mut_slice),
            shift.each_mut().map(Vec::as_mut_slice),
            [pressure_rate.as_mut_slice(), divergence.as_mut_slice()],
        );
        for_each_block(self.grid, outputs, &work, &EdacSummary::join)
    }
}

/// Acceleration, acceleration by the background pressure, and rate of pressure with divergence of a block's rows.
type Outputs<'a, R, const D: usize> = ([&'a mut [R]; D], [&'a mut [R]; D], [&'a mut [R]; 2]);

struct EdacBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    edac: &'a Edac,
    layout: Layout,
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    wall_distance: &'a [R],
    body_force: &'a [Vec<R>; D],
    near: &'a [Near],
    cells: Range<usize>,
    outputs: Outputs<'a, R, D>,
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for EdacBlock<'_, K, R, D> {
    type Output = EdacSummary;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> EdacSummary {
        let pair_loop = PairLoop::<L, D>::new(self.pair, self.edac, self.layout, self.body_force);
        match (pair_loop.is_plain(), pair_loop.has_walls()) {
            (true, false) => self.sweep::<L, true, false>(&pair_loop),
            (true, true) => self.sweep::<L, true, true>(&pair_loop),
            (false, _) => self.sweep::<L, false, false>(&pair_loop),
        }
    }
}

impl<K: KernelShape, R: Real, const D: usize> EdacBlock<'_, K, R, D> {
    /// All fluid rows of the block; `PLAIN` and `WALLS` as the loop says.
    #[inline(always)]
    fn sweep<L: Lanes<Real = R>, const PLAIN: bool, const WALLS: bool>(
        self,
        pair_loop: &PairLoop<L, D>,
    ) -> EdacSummary {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let (acceleration, shift, [pressure_rate, divergence]) = self.outputs;
        let mut summary = EdacSummary::default();
        for cell in self.cells {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.zone[row] == Zone::Fluid) {
                continue;
            }
            // Of each cell apart: see `pass/rates/mod.rs`.
            let mut of_cell = EdacSummary::default();
            for row in rows {
                if self.zone[row] != Zone::Fluid {
                    continue;
                }
                let point = self.pack.relative(self.source, row);
                let distance = self.wall_distance[row].to_f64();
                let near = Near::of_row(self.near, row);
                let rates = pair_loop.sum::<K, PLAIN, WALLS, false>(
                    self.pack,
                    self.source,
                    point,
                    row,
                    near,
                    distance,
                );
                let mut speed = 0.0;
                for d in 0..D {
                    acceleration[d][row - first] = R::from_f64(rates.acceleration[d]);
                    shift[d][row - first] = R::from_f64(rates.background[d]);
                    let v = self.source.columns[d][row].to_f64();
                    speed += v * v;
                }
                pressure_rate[row - first] = R::from_f64(rates.pressure_rate);
                divergence[row - first] = R::from_f64(rates.divergence);
                of_cell = of_cell.join(EdacSummary {
                    speed,
                    divergence: rates.divergence.abs(),
                    damping: rates.damping,
                });
            }
            summary = summary.join(of_cell);
        }
        // The root of the largest square is the largest root: one root a block.
        summary.speed = summary.speed.sqrt();
        summary
    }
}
