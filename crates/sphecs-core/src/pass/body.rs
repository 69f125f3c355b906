//! Force and torque of the fluid on a body, a part of the wall.
//!
//! ```text
//! F = −Σ_a m Σ_b f_ab,   T = −Σ_a m Σ_b (x_b − c) × f_ab,   (x_b − c) × f_ab = (x_a − c) × f_ab − x_ab × f_ab
//! ```
//!
//! Over fluid particles a and the body's particles b; m f_ab is the force that the momentum sum of the scheme has for the pair, so
//! that the body gets what the fluid loses: Negi et al. (2020), Eqs. 37 and 38, from the fluid's side. The loops are those of the
//! rates over a pack that holds the body alone. The pressure's part is along x_ab; all else that the sum has,
//! viscous and turbulent stress and that of the transport velocity, is the viscous part.
//!
//! Two terms of the schemes take a particle's own mean pressure out of all its pairs, p̄_a of Negi et al. (2020), Eq. 7, and the
//! tensile control of p_a < 0. Over a whole support they add up to nearly nothing, but the share of the pairs that cross a
//! surface is the very force that the pressure has on it: with them a submerged cylinder has no buoyancy (test
//! `submerged_cylinder_is_lifted_by_the_displaced_weight`). So the settings that are handed in have neither.

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::pack::{Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use glam::DVec3;

/// Force and torque, parts of pressure and viscosity: per metre of depth in 2D.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodySum {
    /// Force of the pressure, N (N/m in 2D).
    pub pressure_force: DVec3,
    /// Force of all else, N (N/m in 2D).
    pub viscous_force: DVec3,
    /// Torque of the pressure about the body's centre, N m (N in 2D).
    pub pressure_torque: DVec3,
    /// Torque of all else, N m (N in 2D).
    pub viscous_torque: DVec3,
}

impl BodySum {
    fn plus(self, other: Self) -> Self {
        Self {
            pressure_force: self.pressure_force + other.pressure_force,
            viscous_force: self.viscous_force + other.viscous_force,
            pressure_torque: self.pressure_torque + other.pressure_torque,
            viscous_torque: self.viscous_torque + other.viscous_torque,
        }
    }
}

/// A body and the cells around it, kept from step to step.
#[derive(Clone, Debug, Default)]
pub struct Body {
    /// Index of the wall part.
    pub part: u16,
    /// Point that torques are about, m.
    pub about: DVec3,
    /// Cells from which its particles can be felt; they never move. Empty until they are looked for.
    cells: Vec<u32>,
    sums: Vec<BodySum>,
}

impl Body {
    /// The body of a part of the wall.
    pub fn new(part: u16, about: DVec3) -> Self {
        Self { part, about, ..Self::default() }
    }

    /// Finds the cells around it, unless they are known.
    fn find_cells<R: Real, const D: usize>(&mut self, grid: &CellGrid<D>, particles: &ParticleArrays<R, D>) {
        if !self.cells.is_empty() {
            return;
        }
        let is_body = |row: usize| particles.zone[row] == Zone::Wall && particles.patch[row] == self.part;
        for cell in 0..grid.len() {
            let mut near = false;
            grid.for_each_run(grid.index_of(cell), |mut rows, _| near = near || rows.any(is_body));
            if near {
                self.cells.push(cell as u32);
            }
        }
    }
}

/// What the pair loop of a scheme gives a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowForce<const D: usize> {
    /// Acceleration, m/s².
    pub acceleration: [f64; D],
    /// Its part of pressure, m/s².
    pub pressure: [f64; D],
    /// Σ x_ab × (acceleration by the pair), m²/s².
    pub moment: [f64; 3],
}

/// The pair loop of a scheme.
pub(super) trait RowLoop<R: Real, const D: usize>: Sync {
    /// Sums over a pack for a row at `point`; must be `#[inline(always)]`.
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        point: [R; D],
        row: usize,
    ) -> RowForce<D>;
}

/// Sums force and torque on a body by the pair loop of a scheme over these columns.
pub(super) fn sum_body<K: KernelShape, R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    columns: &[&[R]],
    sums: &PairSums<R, D>,
    row_loop: &impl RowLoop<R, D>,
    body: &mut Body,
) -> BodySum {
    body.find_cells(grid, particles);
    let source = Source {
        grid,
        position: &particles.position,
        columns,
        inverse_h: 1.0 / pair.smoothing_length,
        support_ratio: K::SUPPORT,
        only: Only::Positive(&sums.columns.body, &[]),
    };
    let Body { about, cells, sums: of_cells, .. } = body;
    let of_cell = |&cell: &u32| {
        let block = BodyCell::<K, R, D, _> {
            pair,
            source: &source,
            particles,
            about: *about,
            cell: cell as usize,
            row_loop,
            pack: &mut sums.packs.of_this_thread(),
            shape: std::marker::PhantomData,
        };
        R::dispatch(pair.lanes, block)
    };
    // Cell by cell and then in their order: the same bits for any number of threads.
    cells.par_iter().map(of_cell).collect_into_vec(of_cells);
    of_cells.iter().fold(BodySum::default(), |sum, cell| sum.plus(*cell))
}

struct BodyCell<'a, K, R: Real, const D: usize, W> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    particles: &'a ParticleArrays<R, D>,
    about: DVec3,
    cell: usize,
    row_loop: &'a W,
    pack: &'a mut Pack<R>,
    shape: std::marker::PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize, W: RowLoop<R, D>> Vectorised<R> for BodyCell<'_, K, R, D, W> {
    type Output = BodySum;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> BodySum {
        let grid = self.source.grid;
        let rows = grid.rows(self.cell);
        let mut sum = BodySum::default();
        if !self.pack.fill::<L, D>(self.source, self.cell, |row| self.particles.zone[row] == Zone::Fluid) {
            return sum;
        }
        for row in rows {
            if self.particles.zone[row] != Zone::Fluid {
                continue;
            }
            let point = self.pack.relative(self.source, row);
            let force = self.row_loop.sum::<K, L>(self.pack, self.source, point, row);
            // Over a period the nearer image counts.
            let arm =
                grid.nearest_image(std::array::from_fn(|d| self.particles.position[d][row] - self.about[d]));
            let (arm, whole) = (vector(arm), vector(force.acceleration) * -self.pair.mass);
            let pressure = vector(force.pressure) * -self.pair.mass;
            let torque = arm.cross(whole) + DVec3::from(force.moment) * self.pair.mass;
            let of_pressure = arm.cross(pressure);
            sum = sum.plus(BodySum {
                pressure_force: pressure,
                viscous_force: whole - pressure,
                pressure_torque: of_pressure,
                viscous_torque: torque - of_pressure,
            });
        }
        sum
    }
}

fn vector<const D: usize>(components: [f64; D]) -> DVec3 {
    let mut vector = DVec3::ZERO;
    for d in 0..D {
        vector[d] = components[d];
    }
    vector
}
