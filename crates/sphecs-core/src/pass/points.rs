//! The fluid's fields at the points that inlets and outlets ask for, by the [`fits`](super::fits).
//!
//! [`sampling`](super::sampling) does the same neighbour by neighbour for probes. Here there are thousands
//! of points a step: they are put into the order of the cells that they fall in, and those of one cell share its pack. What is found at a point depends on that pack alone, not on the other points.

use std::marker::PhantomData;

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::fits::{COLUMNS, PRESSURE, PointFit, PointFlow, VELOCITY, VOLUME};
use super::pack::{Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Points that a thread takes at a time.
const CHUNK: usize = 64;

/// Points with what was found at them, kept from step to step.
#[derive(Debug, Default)]
pub struct PointFlows<const D: usize> {
    /// The points, m.
    pub points: Vec<[f64; D]>,
    /// What was found at each; None where no fluid is near.
    pub found: Vec<Option<PointFlow>>,
    /// Number of each point behind bits of its cell's place, in their order: points of one cell follow each other.
    order: Vec<u64>,
    in_order: Vec<Option<PointFlow>>,
}

impl<const D: usize> PointFlows<D> {
    /// Fits the fluid's fields at the points.
    pub fn find<R: Real>(
        &mut self,
        fit: PointFit,
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) {
        self.find_in(fit, &particles.pressure, pair, grid, particles, sums);
    }

    /// Finds the kernel means of a column of the particles' over the fluid, as pressures.
    pub fn find_mean<R: Real>(
        &mut self,
        column: &[R],
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) {
        self.find_in(PointFit::Column, column, pair, grid, particles, sums);
    }

    fn find_in<R: Real>(
        &mut self,
        fit: PointFit,
        pressure: &[R],
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) {
        sums.packs.prepare();
        sums.columns.find_fluid_volume(pair, particles);
        self.order.clear();
        let cells = self.points.iter().map(|&point| place(grid.unwrapped_index(point)));
        self.order.extend(cells.zip(0_u64..).map(|(place, number)| place << u32::BITS | number));
        self.order.sort_unstable();
        self.in_order.resize(self.points.len(), None);
        pair.kernel.with_shape(PointPass { fit, pressure, pair, grid, particles, sums, flows: self });
        self.found.resize(self.points.len(), None);
        for (&at, &found) in self.order.iter().zip(&self.in_order) {
            self.found[number(at)] = found;
        }
    }
}

/// Bits of a cell's place along an axis that the order looks at.
const PLACE_BITS: u32 = 10;

/// The lowest bits of a cell's place along all axes. Cells far apart may share them: a cell is then only met more than once.
fn place<const D: usize>(cell: [i64; D]) -> u64 {
    cell.iter().rev().fold(0, |place, &along| place << PLACE_BITS | along as u64 & ((1 << PLACE_BITS) - 1))
}

/// The number of a point in the order.
fn number(at: u64) -> usize {
    at as u32 as usize
}

struct PointPass<'a, R: Real, const D: usize> {
    fit: PointFit,
    pressure: &'a [R],
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    sums: &'a PairSums<R, D>,
    flows: &'a mut PointFlows<D>,
}

impl<R: Real, const D: usize> WithShape for PointPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let mut columns: [&[R]; COLUMNS] = [&[]; COLUMNS];
        columns[VOLUME] = &self.sums.columns.fluid_volume;
        columns[PRESSURE] = self.pressure;
        for d in 0..D {
            columns[VELOCITY + d] = &self.particles.velocity[d];
        }
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &columns[..self.fit.columns(D)],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let PointFlows { points, order, in_order, .. } = self.flows;
        let points = &*points;
        let chunks = order.par_chunks(CHUNK).zip(in_order.par_chunks_mut(CHUNK));
        chunks.for_each(|(order, found)| {
            let block = PointBlock::<K, R, D> {
                fit: self.fit,
                source: &source,
                points,
                order,
                found,
                pack: &mut self.sums.packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        });
    }
}

struct PointBlock<'a, K, R: Real, const D: usize> {
    fit: PointFit,
    source: &'a Source<'a, R, D>,
    points: &'a [[f64; D]],
    order: &'a [u64],
    found: &'a mut [Option<PointFlow>],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for PointBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let mut packed = None;
        for (&at, found) in self.order.iter().zip(self.found) {
            let point = self.points[number(at)];
            *found = None;
            if !point.iter().all(|x| x.is_finite()) {
                continue;
            }
            let cell = self.source.grid.unwrapped_index(point);
            if packed != Some(cell) {
                self.pack.fill_around::<L, D>(self.source, cell);
                packed = Some(cell);
            }
            let at = self.pack.relative_to(self.source, point);
            *found = self.fit.at::<K, L, D>(self.pack, at, self.source.inverse_h);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::math::kernel::Kernel;
    use crate::math::lanes::InstructionSet;
    use crate::particles::zone::Zone;
    use crate::pass::samples::{SPACING, Sample, settings};

    /// Fits in a stirred box without periodic sides whose fields are those given, at its corner, an edge, its middle, and far
    /// away; every seventh particle is a wall's, with nonsense for its fields.
    fn fitted<R: Real, const D: usize>(
        set: InstructionSet,
        fit: PointFit,
        velocity: impl Fn([f64; D]) -> f64,
        pressure: impl Fn([f64; D]) -> f64,
    ) -> Vec<([f64; D], Option<PointFlow>)> {
        let mut pair = settings(Kernel::WendlandC2, D, 1.7);
        pair.lanes = set;
        let mut sample = Sample::<R, D>::lattice(pair, [9; D], false);
        sample.stir(0.2, 0.0);
        let Sample { pair, grid, particles, sums } = &mut sample;
        for row in 0..particles.len() {
            let x = std::array::from_fn(|d| particles.position[d][row]);
            particles.velocity[0][row] = R::from_f64(velocity(x));
            particles.pressure[row] = R::from_f64(pressure(x));
            if particles.id[row] % 7 == 3 {
                particles.zone[row] = Zone::Wall;
                particles.pressure[row] = R::from_f64(1e5);
                particles.velocity[0][row] = R::from_f64(-77.0);
            }
        }
        let mut flows = PointFlows::default();
        let edge = std::array::from_fn(|d| -0.3 + SPACING * if d == 0 { 5.3 } else { 0.2 });
        flows.points.extend([[-0.3; D], edge, [-0.3 + 4.6 * SPACING; D], [1e3; D], [f64::NAN; D]]);
        flows.find(fit, pair, grid, particles, sums);
        flows.points.into_iter().zip(flows.found).collect()
    }

    fn check<R: Real, const D: usize>(set: InstructionSet, tolerance: f64) {
        let sum = |x: [f64; D]| x.iter().zip([2.0, -3.0, 5.0]).map(|(x, slope)| slope * x).sum::<f64>();
        let linear = fitted::<R, D>(set, PointFit::Pressure, |_| 0.0, |x| 7.0 + sum(x));
        let section = PointFit::Section { normal: DVec3::X, across: [DVec3::Y, DVec3::Z] };
        let parabola = |x: [f64; D]| 1.0 + sum(x) + x[1] * x[1] - if D == 3 { x[1] * x[2] } else { 0.0 };
        let quadratic = fitted::<R, D>(set, section, parabola, |_| 4.0);
        for (found, is_near) in linear.iter().zip([true, true, true, false, false]) {
            assert_eq!(found.1.is_some(), is_near, "{:?}", found.0);
            if let (at, Some(flow)) = *found {
                assert!((flow.pressure - 7.0 - sum(at)).abs() < tolerance, "{} at {at:?}", flow.pressure);
            }
        }
        for (found, is_near) in quadratic.iter().zip([true, true, true, false, false]) {
            assert_eq!(found.1.is_some(), is_near, "{:?}", found.0);
            if let (at, Some(flow)) = *found {
                assert!((flow.velocity - parabola(at)).abs() < tolerance, "{} at {at:?}", flow.velocity);
                assert!((flow.pressure - 4.0).abs() < tolerance);
            }
        }
    }

    fn check_images<R: Real, const D: usize>(set: InstructionSet, tolerance: f64) {
        let normal = DVec3::new(0.8, -0.6, 0.0);
        let sum = |x: [f64; D]| x.iter().zip([2.0, -3.0, 5.0]).map(|(x, slope)| slope * x).sum::<f64>();
        let (velocity, pressure) = (|x: [f64; D]| 1.0 - 0.5 * sum(x), |x: [f64; D]| 7.0 + sum(x));
        let images = fitted::<R, D>(set, PointFit::Image { normal }, velocity, pressure);
        for (at, found) in &images[..3] {
            let image = found.expect("fluid").image;
            let slope = 2.0 * 0.8 + 3.0 * 0.6;
            let near = |found: f64, expected: f64| {
                assert!((found - expected).abs() < tolerance, "{found}, not {expected} at {at:?}");
            };
            near(image.pressure, pressure(*at));
            near(image.pressure_slope, slope);
            near(image.velocity.x, velocity(*at));
            near(image.velocity_slope.x, -0.5 * slope);
        }
        assert!(images[3].1.is_none());
        let means = fitted::<R, D>(set, PointFit::Mean { normal }, |_| 2.0, |_| 4.0);
        for (at, found) in &means[..3] {
            let flow = found.expect("fluid");
            let off = (flow.pressure - 4.0).abs().max((flow.velocity - 1.6).abs());
            assert!(off < tolerance, "{flow:?} at {at:?}");
        }
        assert!(means[3].1.is_none());
    }

    #[test]
    fn images_of_linear_fields_and_means_of_even_ones_are_exact_at_a_cut_support() {
        for set in InstructionSet::available() {
            check_images::<f64, 2>(set, 1e-9);
            check_images::<f64, 3>(set, 1e-9);
            check_images::<f32, 2>(set, 2e-3);
            check_images::<f32, 3>(set, 2e-3);
        }
    }

    #[test]
    fn fits_are_exact_at_a_cut_support_and_see_no_walls() {
        for set in InstructionSet::available() {
            check::<f64, 2>(set, 1e-10);
            check::<f64, 3>(set, 1e-10);
            check::<f32, 2>(set, 2e-3);
            check::<f32, 3>(set, 2e-3);
        }
    }
}
