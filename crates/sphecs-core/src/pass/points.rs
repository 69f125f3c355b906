//! Fields of the fluid at the points of inlets and outlets, by the [`fits`](super::fits).
//!
//! [`sampling`](super::sampling) does the same neighbour by neighbour for probes. Here there are
//! thousands of points per step. They are sorted by cell, and the points of one cell share its
//! pack. The result at a point depends on that pack alone, not on the other points.

use super::fits::{COLUMNS, PRESSURE, PointFit, PointFlow, VELOCITY, VOLUME};
use super::pack::{Only, Pack, Source};
use super::pair_real::PairReal;
use super::ranks::PointResult;
use super::row_pass::{PassInput, PointPass};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Points and the flow found at them, kept from step to step.
#[derive(Debug, Default)]
pub struct PointFlows<const D: usize> {
    /// The points, m.
    pub points: Vec<[f64; D]>,
    /// Flow at each point; None where no fluid is in the support.
    pub found: Vec<Option<PointFlow>>,
    /// Number of each point behind the bits of its cell, sorted, so that points of one cell follow
    /// each other.
    order: Vec<u64>,
    /// Flow at each point in that order.
    in_order: Vec<Option<PointFlow>>,
}

impl<const D: usize> PointFlows<D> {
    /// Fits the fluid's fields at the points.
    pub fn find<R: PairReal<D>>(
        &mut self,
        fit: PointFit,
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) {
        R::fit_points(self, fit, &particles.pressure, pair, grid, particles, sums);
    }

    /// Finds the kernel means of a particle column over the fluid, as pressures.
    pub fn find_mean<R: PairReal<D>>(
        &mut self,
        column: &[R],
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) {
        R::fit_points(self, PointFit::Column, column, pair, grid, particles, sums);
    }
}

/// Fits a pressure column and the velocity of the fluid at the points.
pub fn fit_points<R: Real, const D: usize>(
    flows: &mut PointFlows<D>,
    fit: PointFit,
    pressure: &[R],
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    sums.columns.find_fluid_volume(pair, particles);
    let PointFlows { points, found, order, in_order } = flows;
    order.clear();
    let cells = points.iter().map(|&point| cell_bits(grid.unwrapped_index(point)));
    order.extend(cells.zip(0_u64..).map(|(cell, number)| cell << u32::BITS | number));
    order.sort_unstable();
    in_order.resize(points.len(), None);

    let mut columns: [&[R]; COLUMNS] = [&[]; COLUMNS];
    columns[VOLUME] = &sums.columns.fluid_volume;
    columns[PRESSURE] = pressure;
    for d in 0..D {
        columns[VELOCITY + d] = &particles.velocity[d];
    }
    let columns = &columns[..fit.columns(D)];
    let position = &particles.position;
    let input = PassInput { pair, grid, position, columns, only: Only::All, packs: &sums.packs };
    input.run_at(&FitPass { fit, points }, order, in_order);

    found.resize(points.len(), None);
    for (&entry, &flow) in order.iter().zip(&*in_order) {
        found[number(entry)] = flow;
    }
}

/// Bits of a cell's index along an axis that the order takes into account.
const INDEX_BITS: u32 = 10;

/// Returns the lowest bits of a cell's index along all axes.
///
/// Cells far apart may share them; then a cell is only packed more than once.
fn cell_bits<const D: usize>(cell: [i64; D]) -> u64 {
    cell.iter().rev().fold(0, |bits, &along| bits << INDEX_BITS | along as u64 & ((1 << INDEX_BITS) - 1))
}

/// Returns the number of the point of an entry of the order.
fn number(entry: u64) -> usize {
    entry as u32 as usize
}

/// Flow at a point in a message, and whether there is any.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub(super) struct FlowMessage {
    flow: PointFlow,
    is_found: u64,
}

impl PointResult for Option<PointFlow> {
    type Message = FlowMessage;

    fn to_message(&self) -> FlowMessage {
        FlowMessage { flow: self.unwrap_or_default(), is_found: u64::from(self.is_some()) }
    }

    fn from_message(message: FlowMessage) -> Self {
        (message.is_found != 0).then_some(message.flow)
    }
}

struct FitPass<'a, const D: usize> {
    fit: PointFit,
    points: &'a [[f64; D]],
}

impl<R: Real, const D: usize> PointPass<R, D> for FitPass<'_, D> {
    /// Entry of the order.
    type Point = u64;
    type Found = Option<PointFlow>;

    #[inline(always)]
    fn position(&self, entry: u64) -> Option<[f64; D]> {
        let point = self.points[number(entry)];
        point.iter().all(|x| x.is_finite()).then_some(point)
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        _entry: u64,
        x: [R; D],
    ) -> Option<PointFlow> {
        self.fit.at::<K, L, D>(pack, x, source.inverse_h)
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

    /// Returns fits in a disordered box without periodic sides: at its corner, an edge, its centre
    /// and far away. Every seventh particle is a wall particle with meaningless fields.
    fn fitted<R: PairReal<D>, const D: usize>(
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

    fn check<R: PairReal<D>, const D: usize>(set: InstructionSet, tolerance: f64) {
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

    fn check_images<R: PairReal<D>, const D: usize>(set: InstructionSet, tolerance: f64) {
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
    fn images_of_linear_fields_and_means_of_uniform_ones_are_exact_at_a_cut_support() {
        for set in InstructionSet::available() {
            check_images::<f64, 2>(set, 1e-9);
            check_images::<f64, 3>(set, 1e-9);
            check_images::<f32, 2>(set, 2e-3);
            check_images::<f32, 3>(set, 2e-3);
        }
    }

    #[test]
    fn fits_are_exact_at_a_cut_support_and_ignore_walls() {
        for set in InstructionSet::available() {
            check::<f64, 2>(set, 1e-10);
            check::<f64, 3>(set, 1e-10);
            check::<f32, 2>(set, 2e-3);
            check::<f32, 3>(set, 2e-3);
        }
    }
}
