//! Sub-particle stress of all particles, for the rates.
//!
//! Fluid, inflow and outflow have the stress of their velocity gradient
//! ([`gradients`](super::gradients)). Walls have no stress of their own. They take the kernel mean
//! of T/ρ² of the flow, as they take its pressure, so a uniform stress exerts no force on the fluid
//! next to a wall. With T = 0 in the wall the cut of the stress at the surface would push particles
//! off it. A free-slip wall takes the mirror image of the mean in its surface, so that it takes no
//! shear; a wall with a wall function keeps the mean.

use std::ops::Range;

use super::density::squared_distance;
use super::pack::{Only, Pack, Source};
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::walls::LEAST_WEIGHT;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::math::symmetric::{component, components};
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::viscosity::Sps;

/// Writer of stress and eddy viscosity.
#[derive(Debug)]
pub struct Stress(());

/// Sets stress and eddy viscosity from the velocity gradient in `sums`. Does nothing unless the
/// viscous term is `Sps`.
pub fn find_stress<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    let Some(model) = pair.viscous_term.stress_model() else {
        return;
    };
    sums.packs.prepare();
    let has_walls = sums.columns.find_walls(pair, particles);
    sums.eddy_viscosity.write(Stress(())).resize(particles.len(), R::default());
    for column in sums.stress.write(Stress(())).iter_mut().take(components(D)) {
        column.resize(particles.len(), R::default());
    }
    find_flow_stress(pair, &model, grid, particles, sums);
    if has_walls {
        extrapolate_stress(pair, grid, particles, sums);
    }
}

/// Stress and eddy viscosity of the particles of a block.
type FlowStress<'a, R> = ([&'a mut [R]; 6], [&'a mut [R]; 1]);

/// Sets stress and eddy viscosity of the flow, and zero for walls.
fn find_flow_stress<R: Real, const D: usize>(
    pair: &PairSettings,
    model: &Sps,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    let PairSums { gradient, stress, eddy_viscosity, .. } = sums;
    let gradient = gradient.read(Stress(()));
    let work = |cells: Range<usize>, (stress, [eddy]): &mut FlowStress<R>| {
        let first = grid.rows(cells.start).start;
        for row in first..grid.rows(cells.end - 1).end {
            let (tensor, viscosity) = if particles.zone[row] == Zone::Wall {
                ([0.0; 6], 0.0)
            } else {
                let gradient = std::array::from_fn(|i| std::array::from_fn(|j| gradient[i][j][row].to_f64()));
                model.stress::<D>(gradient, particles.density[row].to_f64(), pair.discretisation.spacing)
            };
            for (column, component) in stress.iter_mut().zip(tensor).take(components(D)) {
                column[row - first] = R::from_f64(component);
            }
            eddy[row - first] = R::from_f64(viscosity);
        }
    };
    let stress = stress.write(Stress(())).each_mut().map(Vec::as_mut_slice);
    let outputs = (stress, [eddy_viscosity.write(Stress(())).as_mut_slice()]);
    pair.ranks.for_each_block(grid, outputs, &work, &|(), ()| ());
}

/// Sets the stress of the wall particles to the kernel mean over the flow.
fn extrapolate_stress<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    let PairSums { stress, wall_stress, columns, packs, .. } = sums;
    let stress = stress.write(Stress(()));
    for (column, from) in wall_stress.iter_mut().zip(stress.iter()) {
        column.resize(from.len(), R::default());
    }
    let zone = &particles.zone;
    let mut neighbours: [&[R]; 7] = [&columns.image_distance; 7];
    for (slot, column) in neighbours[1..].iter_mut().zip(stress.iter()) {
        *slot = column;
    }
    let columns = &neighbours[..=components(D)];
    let input = PassInput { pair, grid, position: &particles.position, columns, only: Only::All, packs };
    input.run(&WallStressPass { pair, particles }, wall_stress.each_mut().map(Vec::as_mut_slice));
    // They are written only now, since the extrapolation reads stresses while it runs.
    for (column, found) in stress.iter_mut().zip(wall_stress.iter()) {
        for (row, (stress, found)) in column.iter_mut().zip(found).enumerate() {
            if zone[row] == Zone::Wall {
                *stress = *found;
            }
        }
    }
}

struct WallStressPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for WallStressPass<'a, R, D> {
    type Outputs = [&'a mut [R]; 6];
    /// Mean T/ρ² by component, m⁵/(kg s²).
    type Sum = [f64; 6];

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.particles.zone[row] == Zone::Wall
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> [f64; 6] {
        let zero = L::constant(0.0);
        let x_w = splat::<L, D>(pack.relative(source, row));
        let mut sums = [zero; 6];
        let mut weights = zero;
        for entry in pack.entries::<L>(D + 1 + components(D)) {
            let weight = K::value(squared_distance(x_w, entry).roots().0);
            let weight = L::select(zero.less(entry.column(D)), zero, weight);
            weights = weights + weight;
            for (c, sum) in sums.iter_mut().enumerate().take(components(D)) {
                *sum = weight.mul_add(entry.column(D + 1 + c), *sum);
            }
        }
        let weights = weights.sum().to_f64();
        let mut means = [0.0; 6];
        for (mean, sum) in means.iter_mut().zip(sums).take(components(D)) {
            *mean = if weights > LEAST_WEIGHT { sum.sum().to_f64() / weights } else { 0.0 };
        }
        means
    }

    #[inline(always)]
    fn store(&self, row: usize, slot: usize, means: [f64; 6], stress: &mut Self::Outputs) {
        let part = self.pair.wall_part(self.particles.patch[row]);
        let means = if part.free_slip && !part.wall_function {
            mirrored::<D>(means, std::array::from_fn(|d| self.particles.wall_normal[d][row].to_f64()))
        } else {
            means
        };
        for (column, mean) in stress.iter_mut().zip(means).take(components(D)) {
            column[slot] = R::from_f64(mean);
        }
    }
}

/// Returns the mirror image S T S, S = I − 2 n nᵀ, of a symmetric tensor in the plane across a unit
/// normal.
fn mirrored<const D: usize>(tensor: [f64; 6], normal: [f64; D]) -> [f64; 6] {
    let entry = |i: usize, j: usize| tensor[component::<D>(i, j)];
    let along: [f64; D] = std::array::from_fn(|i| (0..D).map(|j| entry(i, j) * normal[j]).sum());
    let across: f64 = (0..D).map(|i| normal[i] * along[i]).sum();
    let mut image = [0.0; 6];
    for i in 0..D {
        for j in i..D {
            let shear = normal[i] * along[j] + along[i] * normal[j];
            image[component::<D>(i, j)] = entry(i, j) - 2.0 * shear + 4.0 * normal[i] * normal[j] * across;
        }
    }
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::column_access::AfterPasses;
    use crate::pass::gradients::sum_gradients;
    use crate::pass::rates::TimeLevel;
    use crate::pass::samples::{SPACING, Sample, settings};
    use crate::pass::settings::WallPartSettings;
    use crate::physics::viscosity::{Sps, Viscosity};

    const SHEAR: f64 = 7.0;

    /// Plane shear over a wall, periodic in no direction.
    fn sheared<const D: usize>(counts: [usize; D], part: WallPartSettings) -> Sample<f64, D> {
        let pair = PairSettings {
            viscous_term: Viscosity::Sps(Sps::default()),
            wall_parts: [part].into(),
            ..settings(Kernel::WendlandC2, D, 1.3)
        };
        let mut sample = Sample::<f64, D>::lattice(pair, counts, false);
        for row in 0..sample.particles.len() {
            let height = sample.particles.position[1][row] + 0.3 - 4.0 * SPACING;
            sample.particles.wall_distance[row] = height.abs();
            sample.particles.velocity[0][row] = SHEAR * height;
            if height < 0.0 {
                sample.particles.zone[row] = Zone::Wall;
                sample.particles.velocity[0][row] = 0.0;
                sample.particles.wall_normal[1][row] = 1.0;
            }
        }
        sum_gradients(&sample.pair, &sample.grid, &sample.particles, TimeLevel::Present, &mut sample.sums);
        find_stress(&sample.pair, &sample.grid, &sample.particles, &mut sample.sums);
        sample
    }

    fn check<const D: usize>(counts: [usize; D], middle: u32) {
        let mut sample = sheared(counts, WallPartSettings::default());
        let eddy = (0.12 * SPACING).powi(2) * SHEAR;
        let shear_stress = eddy * SHEAR / 1000.0;
        let normal_stress = -2.0 / 3.0 * 0.0066 * (SPACING * SHEAR).powi(2) / 1000.0;
        let shear = crate::math::symmetric::component::<D>(0, 1);
        for row in 0..sample.particles.len() {
            let depth = -(sample.particles.position[1][row] + 0.3 - 4.0 * SPACING);
            if depth > 2.0 * SPACING {
                continue;
            }
            for (c, stress) in sample.sums.stress.read(AfterPasses).iter().enumerate().take(components(D)) {
                let expected = if c == shear {
                    shear_stress
                } else if c < D {
                    normal_stress
                } else {
                    0.0
                };
                assert!(
                    (stress[row] - expected).abs() < 1e-11 * shear_stress,
                    "component {c}: {}",
                    stress[row]
                );
            }
            if depth < 0.0 {
                assert!((sample.sums.eddy_viscosity.read(AfterPasses)[row] / eddy - 1.0).abs() < 1e-11);
            }
        }
        // A uniform stress exerts no force, even next to a wall.
        let summary = sample.rates();
        assert!((summary.eddy_viscosity / eddy - 1.0).abs() < 1e-11);
        let row = sample.row(middle);
        assert!(sample.particles.zone[row] == Zone::Fluid && sample.particles.wall_distance[row] < SPACING);
        for column in &sample.particles.acceleration {
            let force = column[row].abs();
            assert!(force < 1e-9 * shear_stress * 1000.0 / SPACING, "dv/dt = {force} m/s²");
        }
    }

    /// Mean of flow and wall at the surface: without shear, the normal stress unchanged. A wall
    /// function takes its stress elsewhere and keeps the mean.
    #[test]
    fn free_slip_wall_takes_no_shear_of_the_sub_particle_stress() {
        let free_slip = WallPartSettings { free_slip: true, wall_function: false };
        for (part, sign) in [(free_slip, -1.0), (WallPartSettings { wall_function: true, ..free_slip }, 1.0)]
        {
            let sample = sheared([13, 12], part);
            let stress = sample.sums.stress.read(AfterPasses);
            // The second and the third wall row of the middle see the same flow.
            let (wall, fluid) = (13 * 3 + 6, 13 * 8 + 6);
            assert_eq!(
                (sample.particles.zone[wall], sample.particles.zone[fluid]),
                (Zone::Wall, Zone::Fluid)
            );
            let shear = component::<2>(0, 1);
            assert!(stress[shear][wall] * sign > 0.1 * stress[shear][fluid], "{part:?}");
            assert!(stress[1][wall] < 0.0 && stress[0][wall] < 0.0, "{part:?}");
        }
        let tensor = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
        let normal = [0.6, 0.0, 0.8];
        let image = mirrored::<3>(tensor, normal);
        let shear = |tensor: [f64; 6], along: [f64; 3]| -> f64 {
            let entry = |i: usize, j: usize| tensor[component::<3>(i, j)];
            (0..3)
                .flat_map(|i| (0..3).map(move |j| (i, j)))
                .map(|(i, j)| along[i] * entry(i, j) * normal[j])
                .sum()
        };
        for along in [[0.8, 0.0, -0.6], [0.0, 1.0, 0.0]] {
            assert!((shear(tensor, along) + shear(image, along)).abs() < 1e-12);
        }
        assert!((shear(tensor, normal) - shear(image, normal)).abs() < 1e-12);
    }

    #[test]
    fn uniform_shear_has_equal_stress_in_fluid_and_wall() {
        check([13, 12], 4 * 13 + 6);
        check([9, 12, 9], (4 * 9 + 12 * 9 * 4 + 4) as u32);
    }
}
