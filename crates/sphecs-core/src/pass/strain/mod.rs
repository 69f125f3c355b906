//! Velocity gradient among the neighbours of a particle, summed together with its density.
//!
//! The damping of noise uses its symmetric part, the rate of strain; shifting uses the full
//! gradient to carry velocities. The same loop sums ∇C for a shift without drift.
//!
//! ```text
//! S = ½ (∇v + ∇vᵀ),   ∂v_i/∂x_j = Σ_k G_ik (M⁻¹)_kj,
//! w = −(1/r) dW/dr,   ‾ = Σ_b w_b …/Σ_b w_b, b ≠ a
//! G_ik = Σ_b w_b (v_b − v̄)_i (x_b − x̄)_k,   M_kj = Σ_b w_b (x_b − x̄)_k (x_b − x̄)_j
//! s_a  = Σ_b V_b ∇W,   V_b = m/ρ_b of the step before
//! ```
//!
//! The weights are those of Bonet & Lok (1999); the least squares are about the mean of the
//! neighbours. The velocity of the particle itself does not enter, so neither the damping nor the
//! shifting can amplify its noise. The sums are over fluid, inflow and outflow. Walls are left out
//! (except in s), since the images of a particle close to a wall multiply its noise. The gradient
//! is exact for linear fields whatever the weights of the neighbours. So all weights are equal, and
//! the density of the step need not be known yet. The sum s needs volumes and takes those of the
//! previous step, which differ only by the acoustic change of one step. With equal volumes s would
//! contain the gradient of the pressure. Subtracting its mean over the support leaves the short
//! waves next to edges (docs/notebook/2026-11-23-noise.md).

mod pending;
mod row;
#[cfg(test)]
mod tests;

use pending::{Gradients, PendingGradients};
use row::{RowSums, sum};

use super::density::{LEAST_Q2, finish};
use super::pack::{NeighbourMask, Only, TILE_VECTORS, mask_len};
use super::rates::TimeLevel;
use super::row_pass::{Block, BlockPass, PassInput};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::math::symmetric::components;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Largest number of columns besides the coordinates: velocity in 3D, flow flag and volume of the
/// neighbour.
const MOST_COLUMNS: usize = 3 + 1 + 1;

/// Writer of the columns of this pass.
#[derive(Debug)]
pub struct Strain(());

/// Sums density and pressure of the fluid, and the rate of strain of fluid, inflow and outflow,
/// into `sums.strain`.
///
/// The density is over all particles, the strain over fluid, inflow and outflow. The whole gradient
/// goes into `sums.neighbour_gradient` if shifting carries velocities, s into
/// `sums.concentration_gradient` if it carries no mass.
pub fn sum_density_and_strain<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) {
    let has_shift_without_drift = !pair.shifting.keeps_drift();
    prepare(pair, particles, has_shift_without_drift, sums);
    let PairSums { strain, neighbour_gradient, concentration_gradient, near, columns, packs, .. } = sums;
    let (strain, neighbour_gradient) = (strain.write(Strain(())), neighbour_gradient.write(Strain(())));
    let concentration_gradient = concentration_gradient.write(Strain(()));
    let ParticleArrays { zone, position, velocity, previous_velocity, density, pressure, .. } = particles;
    let velocity = match level {
        TimeLevel::Present => &*velocity,
        TimeLevel::Previous => &*previous_velocity,
    };
    let mut neighbours: [&[R]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
    for d in 0..D {
        neighbours[d] = &velocity[d];
    }
    neighbours[D] = &columns.flow;
    neighbours[D + 1] = &columns.volume;
    let columns = &neighbours[..if has_shift_without_drift { D + 2 } else { D + 1 }];
    let input = PassInput { pair, grid, position, columns, only: Only::All, packs };
    let gradients = (
        strain.each_mut().map(Vec::as_mut_slice),
        neighbour_gradient.each_mut().map(|row| row.each_mut().map(Vec::as_mut_slice)),
    );
    let outputs = (
        [&mut density[..], &mut pressure[..]],
        gradients,
        (concentration_gradient.each_mut().map(Vec::as_mut_slice), &mut near[..]),
    );
    input.run_blocks(&StrainPass { pair, zone, has_shift_without_drift }, outputs);
}

/// Prepares the columns that the pass reads and writes.
fn prepare<R: Real, const D: usize>(
    pair: &PairSettings,
    particles: &ParticleArrays<R, D>,
    has_shift_without_drift: bool,
    sums: &mut PairSums<R, D>,
) {
    let rows = particles.len();
    sums.packs.prepare();
    sums.near.resize(mask_len::<D>(rows), NeighbourMask::ALL);
    sums.columns.forget_densities();
    sums.columns.find_flow(particles);
    for column in sums.strain.write(Strain(())).iter_mut().take(components(D)) {
        column.resize(rows, R::default());
    }
    let carried = if pair.shifting.carries_velocity() { rows } else { 0 };
    for column in sums.neighbour_gradient.write(Strain(())).iter_mut().flatten() {
        column.resize(carried, R::default());
    }
    if has_shift_without_drift {
        sums.columns.find_volume(pair, particles);
    }
    for column in sums.concentration_gradient.write(Strain(())) {
        column.resize(if has_shift_without_drift { rows } else { 0 }, R::default());
    }
}

struct StrainPass<'a> {
    pair: &'a PairSettings,
    zone: &'a [Zone],
    has_shift_without_drift: bool,
}

/// Density and pressure, strain and gradient, ∇C, and the vectors of the pack with a neighbour in
/// the support.
type Outputs<'a, R, const D: usize> =
    ([&'a mut [R]; 2], Gradients<'a, R, D>, ([&'a mut [R]; D], &'a mut [NeighbourMask]));

impl<'a, R: Real, const D: usize> BlockPass<R, D> for StrainPass<'a> {
    type Outputs = Outputs<'a, R, D>;
    type Summary = ();
    type Module = Self;

    #[inline(always)]
    fn block<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        block: Block<'_, R, D>,
        ([density, pressure], gradients, (concentration_gradient, masks)): &mut Outputs<'a, R, D>,
    ) {
        let rows = block.rows();
        let Block { source, cells, pack } = block;
        // ∇W over slope · x_ab/h, 1/m^(D+1).
        let gradient_scale = self.pair.discretisation.slope_scale() * source.inverse_h;
        let (q, inverse_q) = L::constant(LEAST_Q2).roots();
        let own_weight = K::slope(q, inverse_q).largest().to_f64();
        let mut pending = PendingGradients::<D>::new(own_weight, source.inverse_h);
        let mut all_slopes = [L::constant(0.0); TILE_VECTORS];
        for cell in cells {
            if !pack.fill::<L, D>(source, cell, |row| self.zone[row].flows()) {
                continue;
            }
            for row in source.grid.rows(cell) {
                if !self.zone[row].flows() {
                    continue;
                }
                let RowSums { kernel_sum, of_flow, slopes, near } = if self.has_shift_without_drift {
                    sum::<K, L, D, true>(pack, source, row, &mut all_slopes)
                } else {
                    sum::<K, L, D, false>(pack, source, row, &mut all_slopes)
                };
                let slot = row - rows.start;
                if let Some(mask) = masks.get_mut(slot) {
                    *mask = near;
                }
                if self.zone[row] == Zone::Fluid {
                    density[slot] = kernel_sum;
                }
                pending.push(slot, &of_flow, gradients);
                for (column, slope) in concentration_gradient.iter_mut().zip(slopes) {
                    if let Some(found) = column.get_mut(slot) {
                        *found = R::from_f64(gradient_scale * slope);
                    }
                }
            }
        }
        pending.write(gradients);
        finish(self.pair, &self.zone[rows], density, pressure);
    }

    fn join(_: (), _: ()) {}
}
