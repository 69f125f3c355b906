//! Small flows for the tests of the passes.

use glam::DVec3;

use super::column_access::AfterPasses;
use super::density::sum_density;
use super::neighbours::Neighbours;
use super::rates::{RatesSummary, TimeLevel, sum_rates};
use super::settings::PairSettings;
use super::strain::sum_density_and_strain;
use super::sums::PairSums;
use super::wall_velocity::find_velocity_seen;
use crate::discretisation::Discretisation;
use crate::math::grid::CellGrid;
use crate::math::kernel::Kernel;
use crate::math::real::Real;
use crate::particles::arrays::{ParticleArrays, SpareColumns};
use crate::particles::rows::ParticleRow;
use crate::particles::zone::Zone;
use crate::physics::eos::Tait;

/// Spacing of all samples, m.
pub(super) const SPACING: f64 = 0.01;

/// Fluid of all samples.
pub(super) const WATER: Tait = Tait { reference_density: 1000.0, sound_speed: 4.0 };

/// Particles, their grid and the settings of the passes.
pub(super) struct Sample<R: Real, const D: usize> {
    pub pair: PairSettings,
    pub grid: CellGrid<D>,
    pub particles: ParticleArrays<R, D>,
    pub sums: PairSums<R, D>,
}

/// Returns the settings of a sample.
pub(super) fn settings(kernel: Kernel, dimensions: usize, smoothing_ratio: f64) -> PairSettings {
    let discretisation =
        Discretisation::new(kernel, dimensions, SPACING, smoothing_ratio, WATER.reference_density);
    PairSettings::new(&discretisation, WATER)
}

/// Returns settings with the same spacing and smoothing ratio in 3D.
pub(super) fn in_space(pair: &PairSettings) -> PairSettings {
    let Discretisation { kernel, smoothing_ratio, .. } = pair.discretisation;
    let PairSettings { discretisation, lattice, .. } = settings(kernel, 3, smoothing_ratio);
    PairSettings { discretisation, lattice, ..pair.clone() }
}

/// Returns a pseudo-random number in −1..1 that depends on the key alone.
pub(super) fn noise(key: u32) -> f64 {
    let mut x = u64::from(key).wrapping_add(1).wrapping_mul(0x9e37_79b9_7f4a_7c15);
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    (x >> 11) as f64 / (1u64 << 52) as f64 - 1.0
}

impl<R: Real, const D: usize> Sample<R, D> {
    /// Returns a box of fluid on a lattice of `counts` particles, at rest at the reference density.
    ///
    /// Unless it is periodic, the box has a margin of one spacing.
    pub(super) fn lattice(pair: PairSettings, counts: [usize; D], periodic: bool) -> Self {
        let margin = if periodic { 0.0 } else { SPACING };
        let lower = [-0.3 - margin; D];
        let upper = std::array::from_fn(|d| -0.3 + counts[d] as f64 * SPACING + margin);
        let grid = CellGrid::new(
            lower,
            upper,
            [periodic; D],
            pair.discretisation.support,
            pair.discretisation.cell_size(),
        );
        let mut particles = ParticleArrays::default();
        for index in 0..counts.iter().product() {
            let mut rest = index;
            let mut position = DVec3::ZERO;
            for d in 0..D {
                position[d] = -0.3 + ((rest % counts[d]) as f64 + 0.5) * SPACING;
                rest /= counts[d];
            }
            particles.push(&ParticleRow {
                id: index as u32,
                position,
                density: WATER.reference_density,
                wall_distance: f64::INFINITY,
                ..Default::default()
            });
        }
        // Tests make walls of fluid rows.
        for column in &mut particles.wall_normal {
            column.resize(particles.id.len(), R::default());
        }
        let mut sample = Self { pair, grid, particles, sums: PairSums::default() };
        sample.sort();
        sample
    }

    /// Disorders the particles: moves each by up to `shift` (in Δ) and gives it a velocity of up to
    /// `speed`, m/s, by its number.
    pub(super) fn stir(&mut self, shift: f64, speed: f64) {
        for row in 0..self.particles.len() {
            let key = self.particles.id[row] * 8;
            let mut point = [0.0; D];
            for d in 0..D {
                point[d] = self.particles.position[d][row] + shift * SPACING * noise(key + d as u32);
                self.particles.velocity[d][row] = R::from_f64(speed * noise(key + 4 + d as u32));
            }
            let point = self.grid.wrap(point);
            for d in 0..D {
                self.particles.position[d][row] = point[d];
            }
        }
        self.sort();
    }

    /// Sorts the particles into the cells.
    pub(super) fn sort(&mut self) {
        let order = self.grid.build(&self.particles.position, &self.particles.id, |_| true).expect("inside");
        self.particles.reorder(order, &mut SpareColumns::default());
        self.sums.forget_order();
    }

    /// Sums density and pressure.
    pub(super) fn density(&mut self) {
        sum_density(&self.pair, &self.grid, &mut self.particles, &mut self.sums);
    }

    /// Sums density, pressure and rates of strain.
    pub(super) fn strain(&mut self) {
        let level = TimeLevel::Present;
        sum_density_and_strain(&self.pair, &self.grid, &mut self.particles, level, &mut self.sums);
    }

    /// Finds the velocities of dummy walls, where walls are dummies.
    pub(super) fn velocity_seen(&mut self) {
        if self.pair.wall_model.sees_kernel_mean() {
            let level = TimeLevel::Present;
            find_velocity_seen(&self.pair, &self.grid, &self.particles, level, &mut self.sums);
        }
    }

    /// Sums the rates.
    pub(super) fn rates(&mut self) -> RatesSummary {
        self.velocity_seen();
        sum_rates(&self.pair, &self.grid, &mut self.particles, TimeLevel::Present, &mut self.sums)
    }

    /// Returns the row of a particle.
    pub(super) fn row(&self, id: u32) -> usize {
        self.particles.id.iter().position(|&found| found == id).expect("the particle exists")
    }

    /// Returns density, divergence, acceleration and shift by particle number.
    pub(super) fn results(&self) -> Vec<Vec<f64>> {
        let columns = [&self.particles.density, self.sums.divergence.read(AfterPasses)];
        let vectors = [&self.particles.acceleration, self.sums.shift.read(AfterPasses)];
        let mut rows: Vec<usize> = (0..self.particles.len()).collect();
        rows.sort_by_key(|&row| self.particles.id[row]);
        let all = columns.into_iter().chain(vectors.into_iter().flatten());
        all.map(|column| rows.iter().map(|&row| column[row].to_f64()).collect()).collect()
    }
}

/// Returns the velocity of a dummy particle, summed neighbour by neighbour; of other particles
/// their own.
pub(super) fn dummy_velocity<R: Real, const D: usize>(sample: &Sample<R, D>, row: usize) -> [f64; D] {
    let particles = &sample.particles;
    let of = |row: usize| -> [f64; D] { std::array::from_fn(|d| particles.velocity[d][row].to_f64()) };
    if particles.zone[row] != Zone::Wall {
        return of(row);
    }
    let (mut sum, mut weights) = ([0.0; D], 0.0);
    let point = std::array::from_fn(|d| particles.position[d][row]);
    Neighbours::new(&sample.grid, particles).for_each(point, |b, _, r2| {
        if particles.zone[b] != Zone::Wall {
            let weight = sample.pair.discretisation.w(r2.sqrt());
            weights += weight;
            for (sum, v) in sum.iter_mut().zip(of(b)) {
                *sum += v * weight;
            }
        }
    });
    let wall = of(row);
    if weights <= 1e-12 {
        return wall;
    }
    let mean = sum.map(|sum| sum / weights);
    if !sample.pair.wall_part(particles.patch[row]).free_slip {
        return std::array::from_fn(|d| 2.0 * wall[d] - mean[d]);
    }
    let normal: [f64; D] = std::array::from_fn(|d| particles.wall_normal[d][row].to_f64());
    let into: f64 = (0..D).map(|d| (mean[d] - wall[d]) * normal[d]).sum();
    std::array::from_fn(|d| mean[d] - 2.0 * into * normal[d])
}

/// Asserts that two sets of columns agree to `tolerance` of the largest number of each column.
pub(super) fn assert_close(found: &[Vec<f64>], expected: &[Vec<f64>], tolerance: f64, what: &str) {
    for (column, (found, expected)) in found.iter().zip(expected).enumerate() {
        let size = expected.iter().fold(0.0, |a: f64, b| a.max(b.abs()));
        assert_eq!(found.len(), expected.len());
        for (row, (found, expected)) in found.iter().zip(expected).enumerate() {
            let error = (found - expected).abs();
            assert!(error <= tolerance * size, "{what}, column {column}, row {row}: {found}, not {expected}");
        }
    }
}
