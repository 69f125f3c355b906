//! Friction of walls whose boundary layer the spacing does not resolve.
//!
//! ```text
//! ũ_w = Σ_b v_b w_wb / Σ_b w_wb − v_wall, its tangential part;   ỹ_w = Σ_b y_b w_wb / Σ_b w_wb,   y_b = (x_b − x_w)·n_w − d_w
//! F_w = −ρ_w u_τ² Δ^(D−1) ũ_w/|ũ_w|   where d_w < Δ, else 0;   u_τ(|ũ_w|, ỹ_w): physics/wall/law.rs
//! dv_a/dt += (1/m) Σ_w F_w w_aw / Σ_b w_wb
//! ```
//!
//! Sums over b are those over the flow around a wall particle. The stress is that of the mean flow in its support, about a spacing
//! away, and what it takes goes to the same particles by the same weights, so that momentum is kept. Of the layers
//! behind a flat wall one is nearer than Δ, wherever the lattice is cut, so that it takes the stress of its own area. In the edge
//! of two walls the particle behind both takes that of another Δ^(D−1): 1/N of the stress of a square duct with N rows in plug flow.
//!
//! A stress per wall particle that the kernel spreads is our own way to give it to the particles. What it is for:
//! docs/walls.md.

#[cfg(test)]
mod tests;

use std::marker::PhantomData;
use std::ops::Range;

use glam::DVec3;

use super::blocks::for_each_block;
use super::body::{Body, BodySum};
use super::density::LEAST_Q2;
use super::pack::{Only, Pack, Source};
use super::rates::VelocityLevel;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{self, Lanes, Vectorised, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::wall::law::friction_velocity;

/// Least Σ w(q) that is divided by: less is at the very edge of the support, where nothing is felt.
const LEAST_SUM: f64 = 1e-20;

/// Depth behind the surface from which a wall particle takes nothing, over Δ: a little less than one, for a lattice with a layer on the
/// surface itself.
const REACH: f64 = 1.0 - 1e-6;

/// Least distance of the mean flow from the wall, over Δ.
const LEAST_DISTANCE: f64 = 0.1;

/// Adds to the accelerations of the fluid what walls with a wall function take, by the velocities of a level.
pub fn add_wall_friction<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if !pair.has_wall_function() || sums.columns.find_walls(pair, particles) == 0 {
        return;
    }
    sums.columns.find_fluid_volume(pair, particles);
    for column in sums.friction.iter_mut().chain([&mut sums.friction_felt]) {
        column.resize(particles.len(), R::default());
    }
    pair.kernel.with_shape(TakePass { pair, grid, particles: &*particles, level, sums });
    pair.kernel.with_shape(FeelPass { pair, grid, particles, sums });
}

/// Adds the friction on a body to what pairs with it exert.
pub fn add_friction_on<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &PairSums<R, D>,
    body: &Body,
    sum: &mut BodySum,
) {
    if !pair.wall_part(body.part).wall_function {
        return;
    }
    // One after another, in the order of the rows: the same bits for any number of threads.
    for row in 0..particles.len() {
        if particles.zone[row] != Zone::Wall || particles.patch[row] != body.part {
            continue;
        }
        let (mut force, mut arm) = (DVec3::ZERO, DVec3::ZERO);
        let felt = sums.friction_felt[row].to_f64();
        // The stress acts at the surface in front of the particle.
        let depth = particles.wall_distance[row].to_f64();
        let foot = std::array::from_fn(|d| {
            particles.position[d][row] + depth * particles.wall_normal[d][row].to_f64() - body.about[d]
        });
        let foot = grid.nearest_image(foot);
        for d in 0..D {
            force[d] = -pair.mass * felt * sums.friction[d][row].to_f64();
            arm[d] = foot[d];
        }
        sum.viscous_force += force;
        sum.viscous_torque += arm.cross(force);
    }
}

struct TakePass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &'a mut PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for TakePass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let PairSums { friction, friction_felt, columns, packs, .. } = self.sums;
        let velocity = self.level.columns(self.particles);
        let neighbours: [&[R]; 4] = std::array::from_fn(|column| match column {
            d if d < D => velocity[d].as_slice(),
            _ => columns.fluid_volume.as_slice(),
        });
        let source = Source {
            grid: self.grid,
            position: &self.particles.position,
            columns: &neighbours[..=D],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::NotPositive(&columns.image_distance, &columns.walls_before),
        };
        let work = |cells: Range<usize>, (friction, felt): ([&mut [R]; D], &mut [R])| {
            let block = TakeBlock::<K, R, D> {
                pair: self.pair,
                source: &source,
                particles: self.particles,
                cells,
                friction,
                felt,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        let written = (friction.each_mut().map(Vec::as_mut_slice), friction_felt.as_mut_slice());
        for_each_block(self.grid, written, &work, &|(), ()| ());
    }
}

struct TakeBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    particles: &'a ParticleArrays<R, D>,
    cells: Range<usize>,
    friction: [&'a mut [R]; D],
    felt: &'a mut [R],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for TakeBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(mut self) {
        let (pair, particles) = (self.pair, self.particles);
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let reach = REACH * pair.spacing;
        let takes = |row: usize| {
            particles.zone[row] == Zone::Wall
                && pair.wall_part(particles.patch[row]).wall_function
                && particles.wall_distance[row].to_f64() < reach
        };
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            for column in self.friction.iter_mut().chain([&mut self.felt]) {
                column[rows.start - first..rows.end - first].fill(R::default());
            }
            if !self.pack.fill::<L, D>(self.source, cell, takes) {
                continue;
            }
            for row in rows.filter(|&row| takes(row)) {
                let point = self.pack.relative(self.source, row);
                let normal: [f64; D] = std::array::from_fn(|d| particles.wall_normal[d][row].to_f64());
                let flow = mean_flow::<K, L, D>(self.pack, point, normal);
                if flow.weights <= LEAST_SUM {
                    continue;
                }
                let depth = particles.wall_distance[row].to_f64();
                let wall: [f64; D] = std::array::from_fn(|d| self.source.columns[d][row].to_f64());
                let area = pair.spacing.powi(D as i32 - 1);
                let y = (flow.height * pair.smoothing_length - depth).max(LEAST_DISTANCE * pair.spacing);
                let stress = stress(pair, particles.density[row].to_f64(), y, normal, wall, flow.velocity);
                for d in 0..D {
                    let taken = -stress[d] * area / (pair.mass * flow.weights);
                    self.friction[d][row - first] = R::from_f64(taken);
                }
                self.felt[row - first] = R::from_f64(flow.felt);
            }
        }
    }
}

/// Stress on a wall, Pa, of the flow's velocity at a distance.
fn stress<const D: usize>(
    pair: &PairSettings,
    density: f64,
    y: f64,
    normal: [f64; D],
    wall: [f64; D],
    flow: [f64; D],
) -> [f64; D] {
    let into: f64 = (0..D).map(|d| (flow[d] - wall[d]) * normal[d]).sum();
    let along: [f64; D] = std::array::from_fn(|d| flow[d] - wall[d] - into * normal[d]);
    let speed = along.iter().map(|component| component * component).sum::<f64>().sqrt();
    let u_tau = friction_velocity(speed, y, pair.viscosity);
    if u_tau == 0.0 { [0.0; D] } else { along.map(|component| density * u_tau * u_tau * component / speed) }
}

/// The flow around a wall particle, by its weights w(q).
struct MeanFlow<const D: usize> {
    /// Velocity, m/s.
    velocity: [f64; D],
    /// Distance along the normal from the particle, in units of h.
    height: f64,
    /// Σ w(q) over the flow.
    weights: f64,
    /// The same over the fluid alone.
    felt: f64,
}

#[inline(always)]
fn mean_flow<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
    normal: [f64; D],
) -> MeanFlow<D> {
    let zero = L::constant(0.0);
    let (mut x_w, mut n_w) = ([zero; D], [zero; D]);
    for d in 0..D {
        x_w[d] = L::splat(point[d]);
        n_w[d] = L::constant(normal[d]);
    }
    let (mut sum, mut height, mut weights, mut felt) = ([zero; D], zero, zero, zero);
    for entry in pack.entries::<L>(2 * D + 1) {
        let mut x = [zero; D];
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            x[d] = entry.column(d) - x_w[d];
            q2 = x[d].mul_add(x[d], q2);
        }
        let weight = K::value(q2.roots().0);
        for d in 0..D {
            sum[d] = entry.column(D + d).mul_add(weight, sum[d]);
        }
        height = dot(n_w, x).mul_add(weight, height);
        weights = weights + weight;
        felt = felt + L::select(zero.less(entry.column(2 * D)), weight, zero);
    }
    let whole = weights.sum().to_f64();
    let inverse = if whole > LEAST_SUM { 1.0 / whole } else { 0.0 };
    MeanFlow {
        velocity: lanes::sums(sum).map(|sum| sum * inverse),
        height: height.sum().to_f64() * inverse,
        weights: whole,
        felt: felt.sum().to_f64(),
    }
}

struct FeelPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    grid: &'a CellGrid<D>,
    particles: &'a mut ParticleArrays<R, D>,
    sums: &'a PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for FeelPass<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let ParticleArrays { acceleration, position, zone, .. } = self.particles;
        let columns = &self.sums.columns;
        let neighbours: [&[R]; D] = self.sums.friction.each_ref().map(Vec::as_slice);
        let source = Source {
            grid: self.grid,
            position,
            columns: &neighbours,
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::Positive(&columns.image_distance, &columns.walls_before),
        };
        let zone = zone.as_slice();
        let packs = &self.sums.packs;
        let work = |cells: Range<usize>, acceleration: [&mut [R]; D]| {
            let block = FeelBlock::<K, R, D> {
                source: &source,
                zone,
                cells,
                acceleration,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block);
        };
        for_each_block(self.grid, acceleration.each_mut().map(Vec::as_mut_slice), &work, &|(), ()| ());
    }
}

struct FeelBlock<'a, K, R: Real, const D: usize> {
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    cells: Range<usize>,
    acceleration: [&'a mut [R]; D],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for FeelBlock<'_, K, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let zero = L::constant(0.0);
        for cell in self.cells.clone() {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.zone[row] == Zone::Fluid) {
                continue;
            }
            for row in rows.filter(|&row| self.zone[row] == Zone::Fluid) {
                let point = self.pack.relative(self.source, row);
                let mut x_a = [zero; D];
                for d in 0..D {
                    x_a[d] = L::splat(point[d]);
                }
                let mut sum = [zero; D];
                for entry in self.pack.entries::<L>(2 * D) {
                    let mut q2 = L::constant(LEAST_Q2);
                    for d in 0..D {
                        let x = entry.column(d) - x_a[d];
                        q2 = x.mul_add(x, q2);
                    }
                    let weight = K::value(q2.roots().0);
                    for d in 0..D {
                        sum[d] = entry.column(D + d).mul_add(weight, sum[d]);
                    }
                }
                for d in 0..D {
                    self.acceleration[d][row - first] += sum[d].sum();
                }
            }
        }
    }
}
