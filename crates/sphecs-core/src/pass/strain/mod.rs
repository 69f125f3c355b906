//! Velocity gradient among the neighbours of a particle, summed together with its density: its symmetric part, the
//! rate of strain, serves the damping of noise, all of it carries the velocity of a shifted particle. On the way ∇C, which a
//! shift that is to carry nothing is made of.
//!
//! ```text
//! S = ½ (∇v + ∇vᵀ),   ∂v_i/∂x_j = Σ_k G_ik (M⁻¹)_kj,   w = −(1/r) dW/dr,   ‾ = Σ_b w_b …/Σ_b w_b, b ≠ a
//! G_ik = Σ_b w_b (v_b − v̄)_i (x_b − x̄)_k,   M_kj = Σ_b w_b (x_b − x̄)_k (x_b − x̄)_j
//! s_a  = Σ_b V_b ∇W,   V_b = m/ρ_b of the step before
//! ```
//!
//! The weights are those of Bonet & Lok (1999), the least squares are about the neighbours' own mean: what the particle
//! has for a velocity does not show, so that neither the damping nor the shifting can feed on its noise. Over fluid, inflow
//! and outflow: walls are left out (but of s), since the images of a particle close to a wall multiply its noise. Exact for linear
//! fields whatever the neighbours weigh, so that all weigh the same and the density of the step need not be known yet. s needs volumes, and
//! takes those of the step before, which differ by what sound does in a step: with equal ones it would have the gradient of the pressure in it, of
//! which the mean around leaves what is narrow, next to edges (docs/noise.md).

mod ends;
mod row;
#[cfg(test)]
mod tests;

use std::marker::PhantomData;
use std::ops::Range;

use ends::{Ends, Gradients};
use row::{RowSums, sum};

use super::blocks::for_each_block;
use super::density::{LEAST_Q2, finish};
use super::pack::{NeighbourMask, Only, Pack, Source, TILE_VECTORS, mask_len};
use super::rates::VelocityLevel;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::math::symmetric::components;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Most columns beside the coordinates: velocity in 3D, whether a neighbour flows, and its volume.
const MOST_COLUMNS: usize = 3 + 1 + 1;

/// Sums density and pressure of the fluid rows over all rows, and the rate of strain of fluid, inflow and outflow rows
/// over those alone, into `sums.strain`; the whole gradient into `sums.neighbour_gradient` if shifting carries velocities, s into
/// `sums.crowding` if it carries no mass.
pub fn sum_density_and_strain<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    sums.near.resize(mask_len::<D>(particles.len()), NeighbourMask::ALL);
    sums.columns.forget_densities();
    sums.columns.find_flow(particles);
    for column in sums.strain.iter_mut().take(components(D)) {
        column.resize(particles.len(), R::default());
    }
    let carried = if pair.shifting.carries_velocity() { particles.len() } else { 0 };
    for column in sums.neighbour_gradient.iter_mut().flatten() {
        column.resize(carried, R::default());
    }
    let crowded = !pair.shifting.keeps_drift();
    if crowded {
        sums.columns.find_volume(pair, particles);
    }
    for column in &mut sums.crowding {
        column.resize(if crowded { particles.len() } else { 0 }, R::default());
    }
    pair.kernel.with_shape(StrainPass { pair, grid, particles, level, sums });
}

struct StrainPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &'a mut PairSums<R, D>,
}

/// Density and pressure, components of the strain, gradient, ∇C, and what is near, of a block's rows.
type Outputs<'a, R, const D: usize> =
    ([&'a mut [R]; 2], Gradients<'a, R, D>, ([&'a mut [R]; D], &'a mut [NeighbourMask]));

impl<R: Real, const D: usize> WithShape for StrainPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let PairSums { strain, neighbour_gradient, crowding, near, columns, packs, .. } = self.sums;
        let ParticleArrays { zone, position, velocity, velocity_before, density, pressure, .. } =
            self.particles;
        let velocity = match self.level {
            VelocityLevel::Present => velocity,
            VelocityLevel::Previous => velocity_before,
        };
        let mut neighbours: [&[R]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
        for d in 0..D {
            neighbours[d] = &velocity[d];
        }
        neighbours[D] = &columns.flow;
        let crowded = !self.pair.shifting.keeps_drift();
        if crowded {
            neighbours[D + 1] = &columns.volume;
        }
        let source = Source {
            grid: self.grid,
            position,
            columns: &neighbours[..if crowded { D + 2 } else { D + 1 }],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let (zone, packs) = (&*zone, &*packs);
        let work = |cells: Range<usize>, outputs: Outputs<R, D>| {
            let block = StrainBlock::<K, R, D> {
                pair: self.pair,
                source: &source,
                zone,
                cells,
                outputs,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        let outputs = (
            [&mut density[..], &mut pressure[..]],
            (
                strain.each_mut().map(Vec::as_mut_slice),
                neighbour_gradient.each_mut().map(|row| row.each_mut().map(Vec::as_mut_slice)),
            ),
            (crowding.each_mut().map(Vec::as_mut_slice), &mut near[..]),
        );
        for_each_block(self.grid, outputs, &work, &|(), ()| ());
    }
}

struct StrainBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    cells: Range<usize>,
    outputs: Outputs<'a, R, D>,
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for StrainBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let flows = |zone: Zone| matches!(zone, Zone::Fluid | Zone::Inflow | Zone::Outflow);
        let ([density, pressure], mut gradients, (mut crowding, noted)) = self.outputs;
        let crowded = !self.pair.shifting.keeps_drift();
        // ∇W over slope · x_ab/h, 1/m^(D+1).
        let gradient_scale = self.pair.slope_scale() * self.source.inverse_h;
        let (q, inverse_q) = L::constant(LEAST_Q2).roots();
        let own_weight = K::slope(q, inverse_q).largest().to_f64();
        let mut ends = Ends::<D>::new(own_weight, self.source.inverse_h);
        let mut all_slopes = [L::constant(0.0); TILE_VECTORS];
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| flows(self.zone[row])) {
                continue;
            }
            for row in rows {
                if !flows(self.zone[row]) {
                    continue;
                }
                let RowSums { kernel_sum, of_flow, slopes, near } = if crowded {
                    sum::<K, L, D, true>(self.pack, self.source, row, &mut all_slopes)
                } else {
                    sum::<K, L, D, false>(self.pack, self.source, row, &mut all_slopes)
                };
                if let Some(slot) = noted.get_mut(row - first) {
                    *slot = near;
                }
                if self.zone[row] == Zone::Fluid {
                    density[row - first] = kernel_sum;
                }
                ends.take(row - first, &of_flow, &mut gradients);
                for (column, slope) in crowding.iter_mut().zip(slopes) {
                    if let Some(slot) = column.get_mut(row - first) {
                        *slot = R::from_f64(gradient_scale * slope);
                    }
                }
            }
        }
        ends.write(&mut gradients);
        let rows = first..grid.rows(self.cells.end - 1).end;
        finish(self.pair, &self.zone[rows], density, pressure);
    }
}
