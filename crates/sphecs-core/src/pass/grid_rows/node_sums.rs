//! Sums over the particles near a group of nodes, one node per lane, and the fits that follow.

use super::near::Near;
use super::{FIELDS, PRESSURE};
use crate::math::factors::Factors;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, MOST_LANES};
use crate::pass::density::LEAST_Q2;

/// Determinant of the scaled linear moments below which the neighbours do not span all directions,
/// as in [`sampling`](super::sampling).
const SMALLEST_DETERMINANT: f64 = 1e-6;

/// Pivot of the scaled quadratic moments below which the neighbours do not span that basis.
///
/// It is 0.01 within the fluid and 1e-4 on a flat wall.
const SMALLEST_PIVOT: f64 = 1e-6;

/// Largest bound V W(0) (M⁻¹)_00 on the gain of a quadratic fit: the variance of its value over
/// that of the particles, for independent noise.
const MOST_GAIN: f64 = 12.0;

/// Sums over the neighbours of a group, one node per lane.
pub(super) struct Sums<L, const N: usize> {
    /// Σ V w φ_i φ_j, upper triangle.
    pub(super) moments: [[L; N]; N],
    /// Σ V w φ_i (f − f_reference); of pressure, density and tag only for the linear functions.
    right: [[L; N]; FIELDS],
    /// Σ V w over the flow, zones of inlets and outlets included.
    pub(super) flow: L,
    /// Σ V w over walls.
    pub(super) solid: L,
}

/// Weight and basis of a fluid particle for each node of a group.
#[derive(Clone, Copy)]
struct Weighted<'a, L, const D: usize, const N: usize> {
    particle: &'a Near<D>,
    /// V w.
    weight: L,
    basis: [L; N],
}

/// Sides of the nodes of a group near thin walls.
pub(super) struct NodeSides<L, const D: usize> {
    /// Normal of the surface that a node faces; 0 for a node without a side.
    pub(super) normal: [L; D],
    /// Distance of that surface, over h; infinite for a node without a side.
    pub(super) front: L,
}

impl<L: Lanes<Real = f64>, const D: usize> NodeSides<L, D> {
    /// Returns the weight of a particle of the flow, 0 for the nodes that have it behind a wall.
    /// The offset is (x_b − x)/h.
    #[inline(always)]
    fn visible(&self, particle: &Near<D>, offset: [L; D], weight: L) -> L {
        let zero = L::constant(0.0);
        let (mut depth, mut into) = (zero, zero);
        for d in 0..D {
            depth = self.normal[d].mul_add(L::constant(-particle.facing[d]), depth);
            into = self.normal[d].mul_add(-offset[d], into);
        }
        let behind = L::select(self.front.less(into), depth, zero);
        L::select(zero.less(behind), zero, weight)
    }
}

impl<L: Lanes<Real = f64>, const N: usize> Sums<L, N> {
    /// Sums over particles near a group whose nodes are `step`/h apart.
    ///
    /// Loops in place of iterators, which would be calls of functions without the instructions. The
    /// sums are taken row by row of the moments, since all of them together do not fit into the
    /// registers.
    #[inline(always)]
    pub(super) fn of<K: KernelShape, const D: usize>(
        near: &[Near<D>],
        step: [f64; D],
        sides: Option<&NodeSides<L, D>>,
    ) -> Self {
        let zero = L::constant(0.0);
        let mut sums = Self { moments: [[zero; N]; N], right: [[zero; N]; FIELDS], flow: zero, solid: zero };
        let mut numbers = [0.0; MOST_LANES];
        for lane in 0..L::COUNT {
            numbers[lane] = lane as f64;
        }
        let lane = L::first_of(&numbers);
        let mut from = 0;
        while from < near.len() {
            let to = near.len().min(from + BLOCK);
            sums.add_block::<K, D>(&near[from..to], (step, lane), sides);
            from = to;
        }
        sums
    }

    #[inline(always)]
    fn add_block<K: KernelShape, const D: usize>(
        &mut self,
        near: &[Near<D>],
        (step, lane): ([f64; D], L),
        sides: Option<&NodeSides<L, D>>,
    ) {
        let zero = L::constant(0.0);
        let Some(first) = near.first() else { return };
        let mut fluid = [Weighted { particle: first, weight: zero, basis: [zero; N] }; BLOCK];
        let mut count = 0;
        for particle in near {
            let mut offset = [zero; D];
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                offset[d] = L::constant(-step[d]).mul_add(lane, L::constant(particle.offset[d]));
                q2 = offset[d].mul_add(offset[d], q2);
            }
            let value = K::value(q2.roots().0);
            self.solid = value.mul_add(L::constant(particle.solid), self.solid);
            let mut weight = value * L::constant(particle.flow);
            if let Some(sides) = sides {
                let visible = sides.visible(particle, offset, weight);
                // The flow behind a wall stands for the wall.
                self.solid = self.solid + (weight - visible);
                weight = visible;
            }
            self.flow = self.flow + weight;
            if particle.is_fluid {
                fluid[count] = Weighted { particle, weight, basis: basis::<L, D, N>(offset) };
                count += 1;
            }
        }
        let fluid = &fluid[..count];
        macro_rules! rows {
            ($($row:literal)*) => { $( if $row < N { self.add_row::<D, $row>(fluid); } )* };
        }
        rows!(0 1 2 3 4 5 6 7 8 9);
    }

    /// Adds to the row `I` of the moments and of the right-hand sides.
    #[inline(always)]
    fn add_row<const D: usize, const I: usize>(&mut self, fluid: &[Weighted<'_, L, D, N>]) {
        let mut moments = self.moments[I];
        let mut right = [L::constant(0.0); FIELDS];
        for field in 0..FIELDS {
            right[field] = self.right[field][I];
        }
        for near in fluid {
            let weighted = near.weight * near.basis[I];
            for j in I..N {
                moments[j] = weighted.mul_add(near.basis[j], moments[j]);
            }
            for d in 0..D {
                right[d] = weighted.mul_add(L::constant(near.particle.values[d]), right[d]);
            }
            // Pressure, density and tag are fitted by the linear functions alone.
            if I <= D {
                for field in PRESSURE..FIELDS {
                    right[field] = weighted.mul_add(L::constant(near.particle.values[field]), right[field]);
                }
            }
        }
        self.moments[I] = moments;
        for field in 0..FIELDS {
            self.right[field][I] = right[field];
        }
    }
}

/// Particles whose weights are stored at a time.
const BLOCK: usize = 32;

/// Fits of all lanes.
pub(super) struct Fits<L, const D: usize> {
    /// Fields relative to the reference.
    pub(super) values: [L; FIELDS],
    /// Derivative of a component of velocity along an axis, times h; NaN without a linear fit.
    pub(super) slopes: [[L; D]; D],
}

/// Solves the equations of all lanes.
#[inline(always)]
pub(super) fn solved<K: KernelShape, L: Lanes<Real = f64>, const D: usize, const N: usize>(
    sums: &Sums<L, N>,
    cell_volume: f64,
) -> Fits<L, D> {
    let total = sums.moments[0][0];
    let factors = Factors::of(&sums.moments, total * L::constant(1e-12));
    let inverse_total = L::constant(1.0) / total;
    let (mut determinant, mut smallest) = (L::constant(1.0), L::constant(1.0));
    for i in 0..N {
        let pivot = factors.pivots[i] * inverse_total;
        smallest = smallest.min(pivot);
        if i <= D {
            determinant = determinant * pivot;
        }
    }
    let central = K::value(L::constant(0.0)) * L::constant(cell_volume);
    let gain = factors.first_of_inverse() * central;
    let is_linear = L::constant(SMALLEST_DETERMINANT).less(determinant);
    let is_spanned = L::constant(SMALLEST_PIVOT).less(smallest);
    let is_calm = gain.less(L::constant(MOST_GAIN));
    let mut fits = Fits { values: [L::constant(0.0); FIELDS], slopes: [[L::constant(0.0); D]; D] };
    for field in 0..FIELDS {
        if (D..PRESSURE).contains(&field) {
            continue;
        }
        let forward = factors.forward(&sums.right[field]);
        let mut fit = factors.solution(&forward, 1 + D);
        if field < D {
            let quadratic = factors.solution(&forward, N);
            for i in 0..=D {
                let spanned = L::select(is_spanned, quadratic[i], fit[i]);
                fit[i] = L::select(is_calm, spanned, fit[i]);
            }
            for j in 0..D {
                fits.slopes[field][j] = L::select(is_linear, fit[1 + j], L::constant(f64::NAN));
            }
        }
        fits.values[field] = L::select(is_linear, fit[0], sums.right[field][0] * inverse_total);
    }
    fits
}

/// Returns 1, the coordinates and their products.
#[inline(always)]
fn basis<L: Lanes, const D: usize, const N: usize>(offset: [L; D]) -> [L; N] {
    let mut basis = [L::constant(1.0); N];
    let mut next = D + 1;
    for i in 0..D {
        basis[1 + i] = offset[i];
        for j in i..D {
            if next < N {
                basis[next] = offset[i] * offset[j];
            }
            next += 1;
        }
    }
    basis
}
