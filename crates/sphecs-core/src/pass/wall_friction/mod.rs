//! Friction of walls whose boundary layer the spacing does not resolve.
//!
//! ```text
//! ũ_w = Σ_b v_b w_wb / Σ_b w_wb − v_wall, its tangential part;
//! ỹ_w = Σ_b y_b w_wb / Σ_b w_wb,   y_b = (x_b − x_w)·n_w − d_w
//! F_w = −ρ_w u_τ² Δ^(D−1) ũ_w/|ũ_w|   where d_w < Δ, else 0;
//! u_τ(|ũ_w|, ỹ_w): physics/wall/law.rs
//! dv_a/dt += (1/m) Σ_w F_w w_aw / Σ_b w_wb
//! ```
//!
//! Sums over b are over the flow around a wall particle. The stress is that of the mean flow in its
//! support, about one spacing away. The force on the wall acts with opposite sign on the same
//! particles, by the same weights, so momentum is conserved. One of the layers behind a flat wall
//! is nearer than Δ, wherever the lattice is cut, and it has the stress of its own area. At the
//! edge of two walls the particle behind both adds the stress of another Δ^(D−1). In a square duct
//! with N particles across in plug flow this is 1/N of the stress.
//!
//! Distributing the stress of each wall particle by the kernel is our own method;
//! docs/book/src/theory/walls.md gives its purpose.

#[cfg(test)]
mod tests;

use std::ops::Range;

use glam::DVec3;

use super::body::{Body, BodySum, ExactBodySum};
use super::density::{LEAST_Q2, squared_distance};
use super::pack::{Only, Pack, Source};
use super::rates::TimeLevel;
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::walls::LEAST_WEIGHT;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{self, Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::wall::law::friction_velocity;

/// Depth behind the surface beyond which a wall particle has no friction, over Δ.
///
/// It is slightly less than one, for lattices with a layer on the surface itself.
const REACH: f64 = 1.0 - 1e-6;

/// Smallest distance of the mean flow from the wall, over Δ.
const LEAST_DISTANCE: f64 = 0.1;

/// Writer of the friction.
#[derive(Debug)]
pub struct WallFriction(());

/// Adds the friction of walls with a wall function to the accelerations of the fluid, by the
/// velocities of a level.
pub fn add_wall_friction<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if !pair.has_wall_function() || !sums.columns.find_walls(pair, particles) {
        return;
    }
    sums.columns.find_fluid_volume(pair, particles);
    let PairSums { friction, friction_felt, .. } = sums;
    let felt = friction_felt.write(WallFriction(()));
    for column in friction.write(WallFriction(())).iter_mut().chain([felt]) {
        column.resize(particles.len(), R::default());
    }
    find_wall_friction(pair, grid, particles, level, sums);
    distribute_friction(pair, grid, particles, sums);
}

/// Finds the friction of every wall particle from the flow around it, into `sums.friction`.
fn find_wall_friction<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) {
    let PairSums { friction, friction_felt, columns, packs, .. } = sums;
    let velocity = level.columns(particles);
    let neighbours: [&[R]; 4] = std::array::from_fn(|column| match column {
        d if d < D => velocity[d].as_slice(),
        _ => columns.fluid_volume.as_slice(),
    });
    let input = PassInput {
        pair,
        grid,
        position: &particles.position,
        columns: &neighbours[..=D],
        only: Only::NotPositive(&columns.image_distance, &columns.walls_before),
        packs,
    };
    let friction = friction.write(WallFriction(())).each_mut().map(Vec::as_mut_slice);
    let outputs = (friction, friction_felt.write(WallFriction(())).as_mut_slice());
    input.run(&WallSidePass { pair, particles, velocity }, outputs);
}

/// Adds the friction of the wall particles to the accelerations of the fluid around them.
fn distribute_friction<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &PairSums<R, D>,
) {
    let ParticleArrays { acceleration, position, zone, .. } = particles;
    let input = PassInput {
        pair,
        grid,
        position,
        columns: &sums.friction.read(WallFriction(())).each_ref().map(Vec::as_slice),
        only: Only::Positive(&sums.columns.image_distance, &sums.columns.walls_before),
        packs: &sums.packs,
    };
    input.run(&FluidSidePass { zone }, acceleration.each_mut().map(Vec::as_mut_slice));
}

/// Adds the friction on a body to the forces of its pairs.
pub fn add_friction_on<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &PairSums<R, D>,
    body: &Body,
    sum: &mut ExactBodySum,
) {
    if !pair.wall_part(body.part).wall_function {
        return;
    }
    let friction = sums.friction.read(WallFriction(()));
    let friction_felt = sums.friction_felt.read(WallFriction(()));
    let own = pair.ranks.own_cells();
    for row in 0..particles.len() {
        let is_of_body = particles.zone[row] == Zone::Wall && particles.patch[row] == body.part;
        if !is_of_body || !own.has_row(grid, row) {
            continue;
        }
        let (mut force, mut arm) = (DVec3::ZERO, DVec3::ZERO);
        let felt = friction_felt[row].to_f64();
        // The stress acts at the surface in front of the particle.
        let depth = particles.wall_distance[row].to_f64();
        let foot = std::array::from_fn(|d| {
            particles.position[d][row] + depth * particles.wall_normal[d][row].to_f64() - body.about[d]
        });
        let foot = grid.nearest_image(foot);
        for d in 0..D {
            force[d] = -pair.discretisation.mass * felt * friction[d][row].to_f64();
            arm[d] = foot[d];
        }
        *sum += &BodySum { viscous_force: force, viscous_torque: arm.cross(force), ..BodySum::default() };
    }
}

/// Friction of the wall particles, from the flow around them.
struct WallSidePass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    particles: &'a ParticleArrays<R, D>,
    velocity: &'a [Vec<R>; D],
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for WallSidePass<'a, R, D> {
    /// Acceleration of the neighbours over w(q), and Σ w(q) over the fluid.
    type Outputs = ([&'a mut [R]; D], &'a mut [R]);
    type Sum = MeanFlow<D>;

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        let Self { pair, particles, .. } = self;
        particles.zone[row] == Zone::Wall
            && pair.wall_part(particles.patch[row]).wall_function
            && particles.wall_distance[row].to_f64() < REACH * pair.discretisation.spacing
    }

    #[inline(always)]
    fn begin(&self, rows: Range<usize>, (friction, felt): &mut Self::Outputs) {
        for column in friction.iter_mut().chain([felt]) {
            column[..rows.len()].fill(R::default());
        }
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> MeanFlow<D> {
        let normal = std::array::from_fn(|d| self.particles.wall_normal[d][row].to_f64());
        mean_flow::<K, L, D>(pack, pack.relative(source, row), normal)
    }

    #[inline(always)]
    fn store(&self, row: usize, slot: usize, flow: MeanFlow<D>, (friction, felt): &mut Self::Outputs) {
        if flow.weights <= LEAST_WEIGHT {
            return;
        }
        let Self { pair, particles, .. } = self;
        let normal: [f64; D] = std::array::from_fn(|d| particles.wall_normal[d][row].to_f64());
        let depth = particles.wall_distance[row].to_f64();
        let wall: [f64; D] = std::array::from_fn(|d| self.velocity[d][row].to_f64());
        let area = pair.discretisation.spacing.powi(D as i32 - 1);
        let y = (flow.height * pair.discretisation.smoothing_length - depth)
            .max(LEAST_DISTANCE * pair.discretisation.spacing);
        let stress = stress(pair, particles.density[row].to_f64(), y, normal, wall, flow.velocity);
        for d in 0..D {
            friction[d][slot] = R::from_f64(-stress[d] * area / (pair.discretisation.mass * flow.weights));
        }
        felt[slot] = R::from_f64(flow.felt);
    }
}

/// Returns the stress on a wall, Pa, of the flow's velocity at the distance `y`, m.
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

/// Flow around a wall particle, weighted by w(q).
struct MeanFlow<const D: usize> {
    /// Velocity, m/s.
    velocity: [f64; D],
    /// Distance along the normal from the particle, in units of h.
    height: f64,
    /// Σ w(q) over the flow.
    weights: f64,
    /// Σ w(q) over the fluid alone.
    felt: f64,
}

/// Returns the mean of the packed flow around a wall particle.
#[inline(always)]
fn mean_flow<K: KernelShape, L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
    normal: [f64; D],
) -> MeanFlow<D> {
    let zero = L::constant(0.0);
    let x_w = splat::<L, D>(point);
    let mut n_w = [zero; D];
    for d in 0..D {
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
    let inverse = if whole > LEAST_WEIGHT { 1.0 / whole } else { 0.0 };
    MeanFlow {
        velocity: lanes::sums(sum).map(|sum| sum * inverse),
        height: height.sum().to_f64() * inverse,
        weights: whole,
        felt: felt.sum().to_f64(),
    }
}

/// Accelerations of the fluid, from the friction of the wall particles around it.
struct FluidSidePass<'a> {
    zone: &'a [Zone],
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for FluidSidePass<'a> {
    type Outputs = [&'a mut [R]; D];
    /// Acceleration, m/s².
    type Sum = [R; D];

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.zone[row] == Zone::Fluid
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> [R; D] {
        let x_a = splat::<L, D>(pack.relative(source, row));
        let mut sum = [L::constant(0.0); D];
        for entry in pack.entries::<L>(2 * D) {
            let weight = K::value(squared_distance(x_a, entry).roots().0);
            for d in 0..D {
                sum[d] = entry.column(D + d).mul_add(weight, sum[d]);
            }
        }
        let mut total = [R::default(); D];
        for d in 0..D {
            total[d] = sum[d].sum();
        }
        total
    }

    #[inline(always)]
    fn store(&self, _row: usize, slot: usize, sum: [R; D], acceleration: &mut Self::Outputs) {
        for d in 0..D {
            acceleration[d][slot] += sum[d];
        }
    }
}
