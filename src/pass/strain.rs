//! Velocity gradient among the neighbours of a particle, summed together with its density: its symmetric part, the
//! rate of strain, serves the damping of noise, all of it carries the velocity of a shifted particle.
//!
//! ```text
//! S = ½ (∇v + ∇vᵀ),   ∂v_i/∂x_j = Σ_k G_ik (M⁻¹)_kj,   w = −(1/r) dW/dr,   ‾ = Σ_b w_b …/Σ_b w_b, b ≠ a
//! G_ik = Σ_b w_b (v_b − v̄)_i (x_b − x̄)_k,   M_kj = Σ_b w_b (x_b − x̄)_k (x_b − x̄)_j
//! ```
//!
//! The weights are those of Bonet & Lok (1999), the least squares are about the neighbours' own mean: what the particle
//! has for a velocity does not show, so that neither the damping nor the shifting can feed on its noise. Over fluid, inflow
//! and outflow: walls are left out, since the images of a particle close to a wall multiply its noise. Exact for linear
//! fields whatever the neighbours weigh, so that all weigh the same and the density of the step need not be known yet.

use std::marker::PhantomData;
use std::ops::Range;

use super::blocks::for_each_block;
use super::density::{LEAST_Q2, finish};
use super::pack::{Only, Pack, Source, nothing_near};
use super::rates::VelocityLevel;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::linear::invert_symmetric;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::sps::{component, components};

/// Most columns beside the coordinates: velocity in 3D and whether a neighbour flows.
const MOST_COLUMNS: usize = 3 + 1;

/// Sums density and pressure of the fluid rows over all rows, and the rate of strain of fluid, inflow and outflow rows
/// over those alone, into `sums.strain`; the whole gradient into `sums.neighbour_gradient` if shifting carries velocities.
pub fn sum_density_and_strain<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    sums.columns.find_flow(particles);
    for column in sums.strain.iter_mut().take(components(D)) {
        column.resize(particles.len(), R::default());
    }
    let carried = if pair.shifting.carries_velocity() { particles.len() } else { 0 };
    for column in sums.neighbour_gradient.iter_mut().flatten() {
        column.resize(carried, R::default());
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

/// Density and pressure, components of the strain, and gradient of a block's rows.
type Outputs<'a, R, const D: usize> = ([&'a mut [R]; 2], [&'a mut [R]; 6], [[&'a mut [R]; D]; D]);

impl<R: Real, const D: usize> WithShape for StrainPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let PairSums { strain, neighbour_gradient, columns, packs, .. } = self.sums;
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
        let source = Source {
            grid: self.grid,
            position,
            columns: &neighbours[..D + 1],
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
            strain.each_mut().map(Vec::as_mut_slice),
            neighbour_gradient.each_mut().map(|row| row.each_mut().map(Vec::as_mut_slice)),
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
        let ([density, pressure], strain, mut whole) = self.outputs;
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            if !self.zone[rows.clone()].iter().any(|&zone| flows(zone)) {
                continue;
            }
            self.pack.fill::<L, D>(self.source, cell);
            for row in rows {
                if !flows(self.zone[row]) {
                    continue;
                }
                let (kernel_sum, gradient) = sum::<K, L, D>(self.pack, self.source, row);
                if self.zone[row] == Zone::Fluid {
                    density[row - first] = kernel_sum;
                }
                for (columns, components) in whole.iter_mut().zip(gradient) {
                    for (column, component) in columns.iter_mut().zip(components) {
                        if let Some(slot) = column.get_mut(row - first) {
                            *slot = R::from_f64(component);
                        }
                    }
                }
                for i in 0..D {
                    for j in 0..=i {
                        let mean = 0.5 * (gradient[i][j] + gradient[j][i]);
                        strain[component::<D>(i, j)][row - first] = R::from_f64(mean);
                    }
                }
            }
        }
        let rows = first..grid.rows(self.cells.end - 1).end;
        finish(self.pair, &self.zone[rows], density, pressure);
    }
}

/// Σ w(q) over a pack, and the gradient of the velocity over the flow in it, the row itself left out.
#[inline(always)]
fn sum<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    source: &Source<L::Real, D>,
    row: usize,
) -> (L::Real, [[f64; D]; D]) {
    let zero = L::constant(0.0);
    let point = pack.relative(source, row);
    let mut x_a = [zero; D];
    let mut v_a = [zero; D];
    for d in 0..D {
        x_a[d] = L::splat(point[d]);
        v_a[d] = L::splat(source.columns[d][row]);
    }
    let mut kernel_sum = zero;
    let mut weight_sum = zero;
    let mut along_sum = [zero; D];
    let mut across_sum = [zero; D];
    let mut sum = [[zero; D]; D];
    // By component: M is symmetric.
    let mut moment = [zero; 6];
    let limit = L::constant(K::SUPPORT * K::SUPPORT);
    for entry in pack.entries::<L>(2 * D + 1) {
        let mut x = [zero; D];
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            x[d] = x_a[d] - entry.column(d);
            q2 = x[d].mul_add(x[d], q2);
        }
        if nothing_near::<L, D>(q2, limit) {
            continue;
        }
        let inverse_q = q2.inverse_sqrt();
        let q = q2 * inverse_q;
        kernel_sum = kernel_sum + K::value(q);
        let slope = K::slope(q, inverse_q) * entry.column(2 * D);
        weight_sum = weight_sum + slope;
        for i in 0..D {
            let across = slope * (v_a[i] - entry.column(D + i));
            let along = slope * x[i];
            across_sum[i] = across_sum[i] + across;
            along_sum[i] = along_sum[i] + along;
            for j in 0..D {
                sum[i][j] = across.mul_add(x[j], sum[i][j]);
                if j <= i {
                    let at = component::<D>(i, j);
                    moment[at] = along.mul_add(x[j], moment[at]);
                }
            }
        }
    }
    // The sums lack the same factor, but for one h: ∇W = scale · slope · x_ab/h. The row itself is in none but the first.
    let nearest = L::constant(LEAST_Q2);
    let inverse_q = nearest.inverse_sqrt();
    let own_weight = K::slope(nearest * inverse_q, inverse_q).largest().to_f64();
    let weights = weight_sum.sum().to_f64() - own_weight;
    let of_weights = if weights == 0.0 { 0.0 } else { 1.0 / weights };
    let along = along_sum.map(|sum| sum.sum().to_f64());
    let across = across_sum.map(|sum| sum.sum().to_f64());
    let mut moments = [[0.0; D]; D];
    let mut plain = [[0.0; D]; D];
    for i in 0..D {
        for j in 0..D {
            // About the mean of the neighbours.
            moments[i][j] = moment[component::<D>(i, j)].sum().to_f64() - along[i] * along[j] * of_weights;
            plain[i][j] = source.inverse_h * (sum[i][j].sum().to_f64() - across[i] * along[j] * of_weights);
        }
    }
    let mut gradient = [[0.0; D]; D];
    // Fewer neighbours than dimensions say nothing of a gradient.
    if let Some(inverse) = invert_symmetric(moments) {
        for i in 0..D {
            for j in 0..D {
                gradient[i][j] = (0..D).map(|k| plain[i][k] * inverse[k][j]).sum();
            }
        }
    }
    (kernel_sum.sum(), gradient)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::math::lanes::InstructionSet;
    use crate::pass::samples::{SPACING, Sample, settings};
    use crate::physics::shifting::Shifting;

    const SLOPES: [[f64; 3]; 3] = [[1.0, -2.0, 0.5], [3.0, 0.2, 0.0], [-1.0, 0.7, 2.0]];

    /// A stirred linear flow whose lowest rows are a wall at rest.
    fn check<const D: usize>(kernel: Kernel, counts: [usize; D]) {
        for lanes in InstructionSet::available() {
            let pair = PairSettings { lanes, ..settings(kernel, D, 1.3) };
            let mut sample = Sample::<f64, D>::lattice(pair, counts, false);
            sample.stir(0.2, 0.0);
            for row in 0..sample.particles.len() {
                let point: [f64; D] = std::array::from_fn(|d| sample.particles.position[d][row]);
                if point[1] + 0.3 < 2.0 * SPACING {
                    sample.particles.zone[row] = Zone::Wall;
                    continue;
                }
                for i in 0..D {
                    let velocity = 0.3 + (0..D).map(|j| SLOPES[i][j] * point[j]).sum::<f64>();
                    sample.particles.velocity[i][row] = velocity;
                    sample.particles.velocity_before[i][row] = -2.0 * velocity;
                }
            }
            sample.density();
            let density = sample.particles.density.clone();
            sample.particles.density.fill(0.0);
            for (level, factor) in [(VelocityLevel::Present, 1.0), (VelocityLevel::Previous, -2.0)] {
                let Sample { pair, grid, particles, sums, .. } = &mut sample;
                sum_density_and_strain(pair, grid, particles, level, sums);
                for row in (0..particles.len()).filter(|&row| particles.zone[row] == Zone::Fluid) {
                    assert_eq!(particles.density[row], density[row]);
                    for i in 0..D {
                        for j in 0..=i {
                            let expected = 0.5 * factor * (SLOPES[i][j] + SLOPES[j][i]);
                            let found = sums.strain[component::<D>(i, j)][row];
                            assert!((found - expected).abs() < 1e-11, "S_{i}{j} = {found}");
                        }
                    }
                }
            }
        }
    }

    #[test]
    fn strain_of_a_linear_flow_is_exact_beside_walls_and_faces_and_density_is_the_same() {
        for kernel in Kernel::ALL {
            check(kernel, [13, 9]);
            check(kernel, [7, 6, 6]);
        }
    }

    #[test]
    fn a_particles_own_velocity_does_not_show_in_its_gradient_but_in_its_neighbours() {
        let shifting = Shifting::Local { coefficient: 32.0 };
        let pair = PairSettings { shifting, ..settings(Kernel::WendlandC2, 2, 1.3) };
        let mut sample = Sample::<f64, 2>::lattice(pair, [8, 8], true);
        sample.stir(0.2, 1.0);
        let (own, other) = (sample.row(27), sample.row(28));
        let gradients = |sample: &mut Sample<f64, 2>| {
            sample.strain();
            let gradient = &sample.sums.neighbour_gradient;
            [own, other].map(|row| [gradient[0][1][row], gradient[0][0][row], gradient[1][0][row]])
        };
        let before = gradients(&mut sample);
        sample.particles.velocity[0][own] += 3.0;
        let after = gradients(&mut sample);
        for (before, after) in before[0].iter().zip(after[0]) {
            assert!((before - after).abs() < 1e-12, "{before} and {after}");
        }
        assert!((before[1][1] - after[1][1]).abs() > 1.0);
        assert_eq!(sample.sums.strain[1][own], sample.sums.neighbour_gradient[1][1][own]);
    }
}
