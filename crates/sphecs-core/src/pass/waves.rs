//! What the wave equation of an outlet sums over the neighbours of its particles, and their concentration gradient.

use std::marker::PhantomData;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::density::LEAST_Q2;
use super::pack::{Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::physics::wall::image;
use crate::physics::wave_sums::{WaveLanes, WavePair, WaveSetting, WaveSums};

/// Rows that a thread takes at a time.
const CHUNK: usize = 64;

/// Most columns beside the coordinates: velocity, density, image distance.
const MOST_COLUMNS: usize = 3 + 2;

/// What was summed for a particle.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WaveFound {
    /// The sums of the wave equation.
    pub sums: WaveSums,
    /// ∇C = Σ V_b ∇W, 1/m.
    pub concentration: DVec3,
}

/// Sums over the neighbours of the rows, which must be in their order; walls as the images that the fluid sees.
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
    sums.columns.find_walls(pair, particles);
    found.resize(rows.len(), WaveFound::default());
    pair.kernel.with_shape(WavePass { setting, pair, grid, particles, sums, rows, found });
}

struct WavePass<'a, R: Real, const D: usize> {
    setting: &'a WaveSetting,
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    sums: &'a PairSums<R, D>,
    rows: &'a [u32],
    found: &'a mut [WaveFound],
}

impl<R: Real, const D: usize> WithShape for WavePass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let images = &self.sums.columns.image_distance;
        let mut columns: [&[R]; MOST_COLUMNS] = [&[]; MOST_COLUMNS];
        for d in 0..D {
            columns[d] = &self.particles.velocity[d];
        }
        columns[D] = &self.particles.density;
        columns[D + 1] = images;
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &columns[..D + 1 + usize::from(!images.is_empty())],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let chunks = self.rows.par_chunks(CHUNK).zip(self.found.par_chunks_mut(CHUNK));
        chunks.for_each(|(rows, found)| {
            let block = WaveBlock::<K, R, D> {
                setting: self.setting,
                pair: self.pair,
                source: &source,
                wall_distance: &self.particles.wall_distance,
                rows,
                found,
                pack: &mut self.sums.packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        });
    }
}

struct WaveBlock<'a, K, R: Real, const D: usize> {
    setting: &'a WaveSetting,
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    wall_distance: &'a [R],
    rows: &'a [u32],
    found: &'a mut [WaveFound],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for WaveBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(mut self) {
        let mut packed = None;
        for at in 0..self.rows.len() {
            let row = self.rows[at] as usize;
            let cell =
                self.source.grid.unwrapped_index(std::array::from_fn(|d| self.source.position[d][row]));
            if packed != Some(cell) {
                self.pack.fill_around::<L, D>(self.source, cell);
                packed = Some(cell);
            }
            self.found[at] = self.sum::<L>(row);
        }
    }
}

impl<K: KernelShape, R: Real, const D: usize> WaveBlock<'_, K, R, D> {
    #[inline(always)]
    fn sum<L: Lanes<Real = R>>(&mut self, row: usize) -> WaveFound {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let point = self.pack.relative(self.source, row);
        let (mut x_o, mut v_o, mut normal) = ([zero; D], [zero; D], [zero; D]);
        for d in 0..D {
            x_o[d] = L::splat(point[d]);
            v_o[d] = L::splat(self.source.columns[d][row]);
            normal[d] = L::constant(self.setting.normal[d]);
        }
        let inverse_distance =
            L::constant(image::inverse_distance(self.wall_distance[row].to_f64(), self.pair.spacing));
        let mass = L::constant(self.pair.mass);
        let columns = self.source.columns.len();
        let mut sums = WaveLanes::<L, D>::new();
        let mut concentration = [zero; D];
        for entry in self.pack.entries::<L>(D + columns) {
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
            if columns > D + 1 {
                // The image velocity of a wall particle, as the fluid sees it.
                let image = entry.column(D + D + 1);
                let stretch = image.mul_add(inverse_distance, one);
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
        let h = self.pair.smoothing_length;
        let f_scale = self.pair.slope_scale() / (h * h);
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
    use crate::particles::zone::Zone;
    use crate::pass::neighbours::Neighbours;
    use crate::pass::samples::{SPACING, Sample, settings};
    use crate::physics::wave_sums::{ReferenceFrame, TransverseOperator};

    /// The sums of a row, neighbour by neighbour.
    fn reference<R: Real, const D: usize>(
        sample: &Sample<R, D>,
        setting: &WaveSetting,
        row: usize,
    ) -> WaveFound {
        let Sample { pair, grid, particles, .. } = sample;
        let h = pair.smoothing_length;
        let f_scale = pair.slope_scale() / (h * h);
        let d_o = particles.wall_distance[row].to_f64().max(0.1 * SPACING);
        let mut sums = WaveLanes::<Array<f64, 1>, D>::new();
        let mut concentration = DVec3::ZERO;
        let point = std::array::from_fn(|d| particles.position[d][row]);
        Neighbours::new(grid, particles).for_each(point, |b, x_ob, r_squared| {
            let wall = particles.zone[b] == Zone::Wall;
            let stretch = if wall { 1.0 + particles.wall_distance[b].to_f64() / d_o } else { 1.0 };
            let (v_o, v_b) = (particles.velocity_of(row), particles.velocity_of(b));
            let volume = pair.mass / particles.density[b].to_f64();
            let f = pair.f(r_squared.sqrt());
            sums.add(
                setting,
                &WavePair {
                    x_ob: x_ob.map(|x| Array([x / h])),
                    v_ob: std::array::from_fn(|d| Array([(v_o[d] - v_b[d]) * stretch])),
                    v_n_b: Array([v_b.dot(setting.normal)]),
                    volume: Array([volume]),
                    w: Array([pair.w(r_squared.sqrt()) / pair.kernel_scale()]),
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

    fn check<R: Real, const D: usize>(set: InstructionSet, has_walls: bool, tolerance: f64) {
        for transverse in [
            None,
            Some(TransverseOperator::Normalised),
            Some(TransverseOperator::Printed),
            Some(TransverseOperator::Consistent),
        ] {
            let pair = settings(Kernel::WendlandC2, D, 1.5);
            let mut sample = Sample::<R, D>::lattice(PairSettings { lanes: set, ..pair }, [8; D], false);
            sample.stir(0.2, 1.0);
            for row in 0..sample.particles.len() {
                let height = sample.particles.position[1][row] + 0.3;
                sample.particles.wall_distance[row] =
                    R::from_f64((height - 3.0 * SPACING).abs() + 0.1 * SPACING);
                if has_walls && height < 3.0 * SPACING {
                    sample.particles.zone[row] = Zone::Wall;
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
    fn sums_are_those_over_all_neighbours() {
        for set in InstructionSet::available() {
            for has_walls in [false, true] {
                check::<f64, 2>(set, has_walls, 1e-11);
                check::<f64, 3>(set, has_walls, 1e-11);
                check::<f32, 3>(set, has_walls, 1e-4);
            }
        }
    }
}
