//! Sums of an outlet's wave equation over the neighbours of its particles, and their concentration
//! gradient.

use glam::DVec3;

use super::density::LEAST_Q2;
use super::pack::{Only, Pack, Source};
use super::ranks::PointResult;
use super::row_pass::{PassInput, PointPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::physics::wall::image;
use crate::physics::wave_sums::{WaveLanes, WavePair, WaveSetting, WaveSums};

/// Largest number of columns besides the coordinates: velocity, density, image distance, normal.
const MOST_COLUMNS: usize = 3 + 2 + 3;

/// Sums of one particle.
#[derive(Clone, Copy, Debug, Default, PartialEq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct WaveFound {
    /// The sums of the wave equation.
    pub sums: WaveSums,
    /// ∇C = Σ V_b ∇W, 1/m.
    pub concentration: DVec3,
}

impl PointResult for WaveFound {
    type Message = Self;

    fn to_message(&self) -> Self {
        *self
    }

    fn from_message(message: Self) -> Self {
        message
    }
}

/// Sums over the neighbours of the particles of `rows`, which must be in ascending order, into
/// `found`.
///
/// Walls enter as images without a velocity cap, or as ghosts where the wall model is `Ghost`. The
/// image of a free-slip wall differs from the particle in its normal velocity alone, so that such a
/// wall does not slow the stream of the zone.
pub fn sum_waves<R: Real, const D: usize>(
    setting: &WaveSetting,
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
    rows: &[u32],
    found: &mut Vec<WaveFound>,
) {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    let free_slip = has_walls && pair.has_free_slip();
    found.resize(rows.len(), WaveFound::default());
    let mut columns: [&[R]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
    for d in 0..D {
        columns[d] = &particles.velocity[d];
        columns[D + 2 + d] = &particles.wall_normal[d];
    }
    columns[D] = &particles.density;
    columns[D + 1] = &sums.columns.image_distance;
    let wall_columns = match (has_walls, free_slip) {
        (false, _) => 0,
        (true, false) => 1,
        (true, true) => 1 + D,
    };
    let columns = &columns[..D + 1 + wall_columns];
    let position = &particles.position;
    let input = PassInput { pair, grid, position, columns, only: Only::All, packs: &sums.packs };
    input.run_at(&WavePass { setting, pair, particles, has_walls, free_slip }, rows, found);
}

struct WavePass<'a, R: Real, const D: usize> {
    setting: &'a WaveSetting,
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
    has_walls: bool,
    /// True if some walls slip.
    free_slip: bool,
}

impl<R: Real, const D: usize> PointPass<R, D> for WavePass<'_, R, D> {
    /// Row of a particle.
    type Point = u32;
    type Found = WaveFound;

    #[inline(always)]
    fn position(&self, row: u32) -> Option<[f64; D]> {
        Some(std::array::from_fn(|d| self.particles.position[d][row as usize]))
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: u32,
        x: [R; D],
    ) -> WaveFound {
        let row = row as usize;
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let x_o = splat::<L, D>(x);
        let (mut v_o, mut normal) = ([zero; D], [zero; D]);
        for d in 0..D {
            v_o[d] = L::splat(source.columns[d][row]);
            normal[d] = L::constant(self.setting.normal[d]);
        }
        let wall_distance = self.particles.wall_distance[row].to_f64();
        let (model, spacing) = (self.pair.wall_model, self.pair.discretisation.spacing);
        let inverse_distance = L::constant(if model.mirrors_velocity() {
            model.inverse_distance(wall_distance, spacing)
        } else {
            image::inverse_distance(wall_distance, spacing)
        });
        let mass = L::constant(self.pair.discretisation.mass);
        let mut sums = WaveLanes::<L, D>::new();
        let mut concentration = [zero; D];
        for entry in pack.entries::<L>(D + source.columns.len()) {
            let (mut x_ob, mut v_ob) = ([zero; D], [zero; D]);
            let mut v_n_b = zero;
            let mut q2 = L::constant(LEAST_Q2);
            for d in 0..D {
                let v_b = entry.column(D + d);
                x_ob[d] = x_o[d] - entry.column(d);
                v_ob[d] = v_o[d] - v_b;
                v_n_b = v_b.mul_add(normal[d], v_n_b);
                q2 = x_ob[d].mul_add(x_ob[d], q2);
            }
            let mut flows = one;
            if self.has_walls {
                // The image velocity of a wall particle, as in the rates of the fluid.
                let signed = entry.column(D + D + 1);
                let image = signed.abs();
                let stretch = image.mul_add(inverse_distance, one);
                if self.free_slip {
                    let slips = signed.less(zero);
                    let normal = entry.vector::<D>(D + D + 2);
                    let across = dot(normal, v_ob);
                    for d in 0..D {
                        v_ob[d] = L::select(slips, across * normal[d], v_ob[d]);
                    }
                }
                for v in &mut v_ob {
                    *v = *v * stretch;
                }
                flows = L::select(zero.less(image), zero, one);
            }
            let (q, inverse_q) = q2.roots();
            let volume = mass * entry.column(D + D).inverse();
            let pair =
                WavePair { x_ob, v_ob, v_n_b, volume, w: K::value(q), f: K::slope(q, inverse_q), flows };
            sums.add(self.setting, &pair);
            for d in 0..D {
                concentration[d] = (volume * pair.f).mul_add(x_ob[d], concentration[d]);
            }
        }
        let h = self.pair.discretisation.smoothing_length;
        let f_scale = self.pair.discretisation.slope_scale() / (h * h);
        let mut found = WaveFound { sums: sums.total(f_scale, h), concentration: DVec3::ZERO };
        for d in 0..D {
            found.concentration[d] = f_scale * h * concentration[d].sum().to_f64();
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::math::lanes::{Array, InstructionSet};
    use crate::particles::rows::real_vector;
    use crate::particles::zone::Zone;
    use crate::pass::neighbours::Neighbours;
    use crate::pass::samples::{SPACING, Sample, settings};
    use crate::pass::settings::WallPartSettings;
    use crate::physics::wave_sums::{ReferenceFrame, TransverseOperator};

    /// The sums of a row, neighbour by neighbour.
    fn reference<R: Real, const D: usize>(
        sample: &Sample<R, D>,
        setting: &WaveSetting,
        row: usize,
    ) -> WaveFound {
        let Sample { pair, grid, particles, .. } = sample;
        let h = pair.discretisation.smoothing_length;
        let f_scale = pair.discretisation.slope_scale() / (h * h);
        let d_o = particles.wall_distance[row].to_f64().max(0.1 * SPACING);
        let mut sums = WaveLanes::<Array<f64, 1>, D>::new();
        let mut concentration = DVec3::ZERO;
        let point = std::array::from_fn(|d| particles.position[d][row]);
        Neighbours::new(grid, particles).for_each(point, |b, x_ob, r_squared| {
            let wall = particles.zone[b] == Zone::Wall;
            let slips = wall && pair.wall_part(particles.patch[b]).free_slip;
            let stretch = if wall { 1.0 + particles.wall_distance[b].to_f64() / d_o } else { 1.0 };
            let (v_o, v_b) = (particles.velocity_of(row), particles.velocity_of(b));
            let n = real_vector(&particles.wall_normal, b);
            let v_ob = if slips { n * n.dot(v_o - v_b) } else { v_o - v_b };
            let volume = pair.discretisation.mass / particles.density[b].to_f64();
            let f = pair.discretisation.f(r_squared.sqrt());
            sums.add(
                setting,
                &WavePair {
                    x_ob: x_ob.map(|x| Array([x / h])),
                    v_ob: std::array::from_fn(|d| Array([v_ob[d] * stretch])),
                    v_n_b: Array([v_b.dot(setting.normal)]),
                    volume: Array([volume]),
                    w: Array([pair.discretisation.w(r_squared.sqrt()) / pair.discretisation.kernel_scale()]),
                    f: Array([f / f_scale]),
                    flows: Array([if wall { 0.0 } else { 1.0 }]),
                },
            );
            for d in 0..D {
                concentration[d] += volume * f * x_ob[d];
            }
        });
        WaveFound { sums: sums.total(f_scale, h), concentration }
    }

    /// Checks flow over a wall that slips or not, or without a wall.
    fn check<R: Real, const D: usize>(set: InstructionSet, walls: Option<bool>, tolerance: f64) {
        for transverse in [
            None,
            Some(TransverseOperator::Normalised),
            Some(TransverseOperator::Printed),
            Some(TransverseOperator::Consistent),
        ] {
            let part = WallPartSettings { free_slip: walls == Some(true), ..Default::default() };
            let pair = settings(Kernel::WendlandC2, D, 1.5);
            let pair = PairSettings { lanes: set, wall_parts: [part].into(), ..pair };
            let mut sample = Sample::<R, D>::lattice(pair, [8; D], false);
            sample.stir(0.2, 1.0);
            for row in 0..sample.particles.len() {
                let height = sample.particles.position[1][row] + 0.3;
                sample.particles.wall_distance[row] =
                    R::from_f64((height - 3.0 * SPACING).abs() + 0.1 * SPACING);
                if walls.is_some() && height < 3.0 * SPACING {
                    sample.particles.zone[row] = Zone::Wall;
                    sample.particles.wall_normal[0][row] = R::from_f64(-0.28);
                    sample.particles.wall_normal[1][row] = R::from_f64(0.96);
                }
            }
            let setting = WaveSetting {
                frame: ReferenceFrame::Fixed,
                transverse,
                normal: DVec3::new(0.8, 0.6, 0.0),
                dimensions: D,
                eta_squared: 0.01,
                viscosity: 1e-3,
            };
            let rows: Vec<u32> = (0..sample.particles.len() as u32).step_by(3).collect();
            let mut found = Vec::new();
            let Sample { pair, grid, particles, sums } = &mut sample;
            sum_waves(&setting, pair, grid, particles, sums, &rows, &mut found);
            for (&row, found) in rows.iter().zip(found) {
                let expected = reference(&sample, &setting, row as usize);
                let near = |found: DVec3, expected: DVec3| {
                    assert!(
                        found.distance(expected) <= tolerance * (10.0 + expected.length()),
                        "{found}, not {expected} with {transverse:?} in {D}D"
                    );
                };
                near(found.sums.rate(&setting), expected.sums.rate(&setting));
                near(found.concentration, expected.concentration);
            }
        }
    }

    #[test]
    fn sums_agree_with_the_scalar_formulas() {
        for set in InstructionSet::available() {
            for walls in [None, Some(false), Some(true)] {
                check::<f64, 2>(set, walls, 1e-11);
                check::<f64, 3>(set, walls, 1e-11);
                check::<f32, 3>(set, walls, 1e-4);
            }
        }
    }
}
