//! The fluid's fields at the points that inlets and outlets ask for: fits over packs.
//!
//! ```text
//! minimise Σ_b V_b W_b (f_b − Σ_i c_i φ_i(x_b − x))²   →   f(x) = c_0,   φ_0 = 1, the others 0 at x
//! ```
//!
//! Moving least squares, as in [`sampling`](super::sampling), which does the same neighbour by neighbour for probes. Here there
//! are thousands of points a step: they are put into the order of the cells that they fall in, and those of one cell share its
//! pack. What is found at a point depends on that pack alone, not on the other points.

use std::marker::PhantomData;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::density::LEAST_Q2;
use super::pack::{Entry, Only, Pack, Source};
use super::sampling::solve_linear;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::linear::solve;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Points that a thread takes at a time.
const CHUNK: usize = 64;

/// Columns beside the coordinates: volume of the fluid, pressure, velocity.
const COLUMNS: usize = 2 + 3;
/// Which of a pack's columns after its `D` coordinates is what.
const VOLUME: usize = 0;
const PRESSURE: usize = 1;
const VELOCITY: usize = 2;

/// What is fitted at each point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PointFit {
    /// The pressure, by a linear basis.
    Pressure,
    /// The kernel mean of the pressure, and the velocity along the normal of a section by a basis that is linear along it and
    /// quadratic over it: a kernel mean takes 3 % of the peak off a Poiseuille profile of 25 rows and lets the row at the wall
    /// run ahead, which no outlet can follow.
    Section {
        /// Unit normal of the section.
        normal: DVec3,
        /// Unit vectors in it; the second is not looked at in 2D.
        across: [DVec3; 2],
    },
}

/// The flow found at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointFlow {
    /// Velocity along the normal of the section, m/s; 0 where only the pressure is fitted.
    pub velocity: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// Points with what was found at them, kept from step to step.
#[derive(Debug, Default)]
pub struct PointFlows<const D: usize> {
    /// The points, m.
    pub points: Vec<[f64; D]>,
    /// What was found at each; None where no fluid is near.
    pub found: Vec<Option<PointFlow>>,
    /// Cell and number of each point, by cell.
    order: Vec<([i64; D], u32)>,
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
        sums.packs.prepare();
        sums.columns.find_fluid_volume(pair, particles);
        self.order.clear();
        let cells = self.points.iter().map(|&point| grid.unwrapped_index(point));
        self.order.extend(cells.zip(0..));
        self.order.sort_unstable();
        self.in_order.resize(self.points.len(), None);
        pair.kernel.with_shape(PointPass { fit, pair, grid, particles, sums, flows: self });
        self.found.resize(self.points.len(), None);
        for (&(_, number), &found) in self.order.iter().zip(&self.in_order) {
            self.found[number as usize] = found;
        }
    }
}

struct PointPass<'a, R: Real, const D: usize> {
    fit: PointFit,
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
        columns[PRESSURE] = &self.particles.pressure;
        for d in 0..D {
            columns[VELOCITY + d] = &self.particles.velocity[d];
        }
        let count = if self.fit == PointFit::Pressure { VELOCITY } else { VELOCITY + D };
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &columns[..count],
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
    order: &'a [([i64; D], u32)],
    found: &'a mut [Option<PointFlow>],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for PointBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let mut packed = None;
        for (&(cell, number), found) in self.order.iter().zip(self.found) {
            let point = self.points[number as usize];
            *found = None;
            if !point.iter().all(|x| x.is_finite()) {
                continue;
            }
            if packed != Some(cell) {
                self.pack.fill_around::<L, D>(self.source, cell);
                packed = Some(cell);
            }
            let at = self.pack.relative_to(self.source, point);
            *found = match self.fit {
                PointFit::Pressure => pressure::<K, L, D>(self.pack, at),
                PointFit::Section { normal, across } if D == 2 => {
                    section::<K, L, D, 4>(self.pack, at, normal, across)
                }
                PointFit::Section { normal, across } => section::<K, L, D, 7>(self.pack, at, normal, across),
            };
        }
    }
}

/// x_b − x in units of h, and V_b w(q), of the neighbours in an entry.
#[inline(always)]
fn offset<K: KernelShape, L: Lanes, const D: usize>(entry: &Entry<'_, L>, at: [L::Real; D]) -> ([L; D], L) {
    let mut offset = [L::constant(0.0); D];
    let mut q2 = L::constant(LEAST_Q2);
    for d in 0..D {
        offset[d] = entry.column(d) - L::splat(at[d]);
        q2 = offset[d].mul_add(offset[d], q2);
    }
    (offset, entry.column(D + VOLUME) * K::value(q2 * q2.inverse_sqrt()))
}

#[inline(always)]
fn pressure<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
) -> Option<PointFlow> {
    let mut moments = [[L::constant(0.0); 4]; 4];
    let mut right = [L::constant(0.0); 4];
    for entry in pack.entries::<L>(D + VELOCITY) {
        let (offset, weight) = offset::<K, L, D>(&entry, at);
        let mut basis = [L::constant(1.0); 4];
        basis[1..=D].copy_from_slice(&offset);
        add(&mut moments, &mut right, basis, D + 1, weight, entry.column(D + PRESSURE));
    }
    let moments = symmetric(moments, D + 1);
    let right = right.map(|sum| sum.sum().to_f64());
    if moments[0][0] <= 0.0 {
        return None;
    }
    Some(PointFlow { velocity: 0.0, pressure: solve_linear(moments, right, D) })
}

#[inline(always)]
fn section<K: KernelShape, L: Lanes, const D: usize, const N: usize>(
    pack: &Pack<L::Real>,
    at: [L::Real; D],
    normal: DVec3,
    across: [DVec3; 2],
) -> Option<PointFlow> {
    let directions = [normal, across[0], across[1]];
    let mut moments = [[L::constant(0.0); N]; N];
    let mut right = [L::constant(0.0); N];
    let mut pressure = L::constant(0.0);
    for entry in pack.entries::<L>(D + VELOCITY + D) {
        let (offset, weight) = offset::<K, L, D>(&entry, at);
        let mut along = [L::constant(0.0); 3];
        let mut velocity = L::constant(0.0);
        for d in 0..D {
            for (along, direction) in along.iter_mut().zip(directions) {
                *along = offset[d].mul_add(L::constant(direction[d]), *along);
            }
            velocity = entry.column(D + VELOCITY + d).mul_add(L::constant(normal[d]), velocity);
        }
        let [n, s, t] = along;
        let one = L::constant(1.0);
        let mut basis = [one; N];
        if N == 4 {
            basis.copy_from_slice(&[one, n, s, s * s]);
        } else {
            basis.copy_from_slice(&[one, n, s, t, s * s, s * t, t * t]);
        }
        add(&mut moments, &mut right, basis, N, weight, velocity);
        pressure = weight.mul_add(entry.column(D + PRESSURE), pressure);
    }
    let moments = symmetric(moments, N);
    let weight = moments[0][0];
    if weight <= 0.0 {
        return None;
    }
    let right = right.map(|sum| sum.sum().to_f64() / weight);
    let fitted = solve(moments.map(|row| row.map(|moment| moment / weight)), right);
    Some(PointFlow {
        // Where the neighbours do not span the basis, the kernel mean.
        velocity: fitted.map_or(right[0], |coefficients| coefficients[0]),
        pressure: pressure.sum().to_f64() / weight,
    })
}

/// Adds neighbours to the lower triangle of the moments and to the right-hand side, of the first `count` functions.
#[inline(always)]
fn add<L: Lanes, const N: usize>(
    moments: &mut [[L; N]; N],
    right: &mut [L; N],
    basis: [L; N],
    count: usize,
    weight: L,
    value: L,
) {
    for i in 0..count {
        let weighted = weight * basis[i];
        right[i] = weighted.mul_add(value, right[i]);
        for j in 0..=i {
            moments[i][j] = weighted.mul_add(basis[j], moments[i][j]);
        }
    }
}

/// Both triangles of the moments, summed over the lanes.
#[inline(always)]
fn symmetric<L: Lanes, const N: usize>(moments: [[L; N]; N], count: usize) -> [[f64; N]; N] {
    let mut all = [[0.0; N]; N];
    for i in 0..count {
        for j in 0..=i {
            all[i][j] = moments[i][j].sum().to_f64();
            all[j][i] = all[i][j];
        }
    }
    all
}

#[cfg(test)]
mod tests {
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
