//! Force and torque of the fluid on a body, a part of the wall.
//!
//! ```text
//! F = −Σ_a m Σ_b f_ab,   T = −Σ_a m Σ_b (x_b − c) × f_ab,
//! (x_b − c) × f_ab = (x_a − c) × f_ab − x_ab × f_ab
//! ```
//!
//! The sums are over fluid particles a and particles b of the body. The force of a pair in the
//! momentum sum of the scheme is m f_ab, so the body gains the momentum that the fluid loses. These
//! are Eqs. 37 and 38 of Negi et al. (2020), seen from the fluid. The loop is the fused one
//! (`fused`) over a pack that holds the body alone. The part along x_ab due to pressure is the
//! pressure part; all other terms, viscous and turbulent stress and that of the transport velocity,
//! are the viscous part.
//!
//! Two terms of the schemes subtract a particle's own pressure from all its pairs: p̄_a of Negi et
//! al. (2020), Eq. 7, and the tensile control of p_a < 0. Over a full support they nearly cancel,
//! but over the pairs that cross a surface they equal the pressure force on it. With them a
//! submerged cylinder has no buoyancy (test
//! `submerged_cylinder_is_lifted_by_the_displaced_weight`). So the settings for these sums have
//! neither.

use std::marker::PhantomData;
use std::ops::AddAssign;

use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::column_access::BodySums;
use super::fused::{FluidRow, FusedInputs, FusedScheme};
use super::pack::{NeighbourMask, Only, Pack, PackPool, Source};
use super::ranks::Ranks;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::exact_sum::ExactSum;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use glam::DVec3;

/// Force and torque, split into the parts of pressure and viscosity; per metre of depth in 2D.
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

    fn vectors(&self) -> [DVec3; 4] {
        [self.pressure_force, self.viscous_force, self.pressure_torque, self.viscous_torque]
    }
}

/// Sum of forces and torques without rounding, so that their order does not matter.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ExactBodySum([[ExactSum; 3]; 4]);

impl ExactBodySum {
    /// Adds what the other ranks found to each sum, by one message.
    pub fn join_all(sums: &mut [Self], ranks: &Ranks) {
        if ranks.size() == 1 {
            return;
        }
        let mut all: Vec<ExactSum> = sums.iter().flat_map(|sum| sum.0.as_flattened()).cloned().collect();
        ranks.sum_exactly(&mut all);
        let places = sums.iter_mut().flat_map(|sum| sum.0.as_flattened_mut());
        places.zip(all).for_each(|(place, sum)| *place = sum);
    }

    /// Returns the sum, rounded once.
    pub fn value(&self) -> BodySum {
        let vector = |sums: &[ExactSum; 3]| DVec3::from_array(sums.each_ref().map(ExactSum::value));
        let [pressure_force, viscous_force, pressure_torque, viscous_torque] = self.0.each_ref().map(vector);
        BodySum { pressure_force, viscous_force, pressure_torque, viscous_torque }
    }
}

impl AddAssign<&BodySum> for ExactBodySum {
    fn add_assign(&mut self, part: &BodySum) {
        for (sums, vector) in self.0.iter_mut().zip(part.vectors()) {
            sums.iter_mut().zip(vector.to_array()).for_each(|(sum, component)| *sum += component);
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
    /// Numbers of particles of other wall parts, and of inflow particles, that count for the body,
    /// ascending.
    pub others: Vec<u32>,
    /// True if the body moves, so that its cells are found in every step.
    moves: bool,
    /// Own cells whose particles have the body in their support.
    cells: Vec<u32>,
    /// Changes of the own cells at which `cells` were found; None until then.
    found_at: Option<u64>,
    /// Number of particles of the body in the rows before each row; of a body that moves.
    before: Vec<u32>,
    sums: Vec<BodySum>,
}

impl Body {
    /// Returns the body of a part of the wall, with torques about a point, m.
    pub fn new(part: u16, about: DVec3) -> Self {
        Self { part, about, ..Self::default() }
    }

    /// Returns the body with its cells found again in every step.
    #[must_use]
    pub fn moving(self) -> Self {
        Self { moves: true, ..self }
    }

    /// Prepares the columns and the cells for the sums on the body; returns false without walls.
    pub(super) fn prepare<R: Real, const D: usize>(
        &mut self,
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
        sums: &mut PairSums<R, D>,
    ) -> bool {
        sums.packs.prepare();
        if !sums.columns.find_images(pair, particles) {
            return false;
        }
        let sides = sums.sides.read(BodySums);
        let part = f64::from(self.part);
        // Flow behind a thin wall of the body stands for its particles.
        let stands_for = |row: usize| {
            sides.part.get(row).is_some_and(|of| of.to_f64() == part)
                && particles.zone[row].flows()
                && sides.facing.iter().any(|column| column[row] != R::default())
        };
        sums.columns.find_body(particles, |row| self.has(particles, row) || stands_for(row));
        self.find_cells(pair, grid, particles);
        true
    }

    /// Finds the cells around the body, unless they are known.
    fn find_cells<R: Real, const D: usize>(
        &mut self,
        pair: &PairSettings,
        grid: &CellGrid<D>,
        particles: &ParticleArrays<R, D>,
    ) {
        let changes = Some(pair.ranks.changes());
        if self.found_at == changes && !self.moves {
            return;
        }
        self.found_at = changes;
        let own = pair.ranks.own_cells();
        let mut before = std::mem::take(&mut self.before);
        before.clear();
        before.push(0);
        let mut count = 0;
        before.extend((0..particles.len()).map(|row| {
            count += u32::from(self.has(particles, row));
            count
        }));
        let cells = &mut self.cells;
        cells.clear();
        for cell in (0..grid.len()).filter(|&cell| own.has(cell)) {
            let mut near = false;
            grid.for_each_run(grid.index_of(cell), |rows, _| {
                near = near || (!rows.is_empty() && before[rows.end] > before[rows.start]);
            });
            if near {
                cells.push(cell as u32);
            }
        }
        self.before = before;
    }

    /// Returns true if a row counts for the body.
    fn has<R: Real, const D: usize>(&self, particles: &ParticleArrays<R, D>, row: usize) -> bool {
        (particles.zone[row] == Zone::Wall && particles.patch[row] == self.part)
            || (matches!(particles.zone[row], Zone::Wall | Zone::Inflow)
                && self.others.binary_search(&particles.id[row]).is_ok())
    }
}

/// Sums force and torque on a body by the pair loop of a scheme.
pub(super) struct BodyPass<'a, S, R: Real, const D: usize> {
    pub scheme: &'a S,
    pub inputs: FusedInputs<'a, R, D>,
    /// 1 for the particles of the body, 0 for all others.
    pub of_body: &'a [R],
    pub packs: &'a PackPool<R>,
    pub body: &'a mut Body,
}

impl<S: FusedScheme<R, D>, R: Real, const D: usize> WithShape for BodyPass<'_, S, R, D> {
    type Output = ExactBodySum;

    fn run<K: KernelShape>(self) -> ExactBodySum {
        let Self { scheme, inputs, of_body, packs, body } = self;
        let source = inputs.source(K::SUPPORT, Only::Positive(of_body, &[]));
        let Body { about, cells, sums: of_cells, .. } = body;
        let of_cell = |&cell: &u32| {
            let block = BodyCell::<K, S, R, D> {
                scheme,
                inputs: &inputs,
                source: &source,
                about: *about,
                cell: cell as usize,
                pack: &mut packs.of_this_thread(),
                kernel: PhantomData,
            };
            R::dispatch(inputs.pair.lanes, block)
        };
        cells.par_iter().map(of_cell).collect_into_vec(of_cells);
        let mut sum = ExactBodySum::default();
        of_cells.iter().for_each(|cell| sum += cell);
        sum
    }
}

/// One cell around a body.
struct BodyCell<'a, K, S, R: Real, const D: usize> {
    scheme: &'a S,
    inputs: &'a FusedInputs<'a, R, D>,
    source: &'a Source<'a, R, D>,
    about: DVec3,
    cell: usize,
    pack: &'a mut Pack<R>,
    kernel: PhantomData<K>,
}

impl<K: KernelShape, S: FusedScheme<R, D>, R: Real, const D: usize> Vectorised<R>
    for BodyCell<'_, K, S, R, D>
{
    type Output = BodySum;
    type Module = S;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> BodySum {
        let FusedInputs { grid, zone, position, wall_distance, pair, .. } = *self.inputs;
        let mut sum = BodySum::default();
        if !self.pack.fill::<L, D>(self.source, self.cell, |row| zone[row] == Zone::Fluid) {
            return sum;
        }
        for row in grid.rows(self.cell) {
            if zone[row] != Zone::Fluid {
                continue;
            }
            let fluid = FluidRow {
                row,
                point: self.pack.relative(self.source, row),
                wall_distance: wall_distance[row].to_f64(),
                mask: NeighbourMask::ALL,
            };
            let force = self.scheme.row_force::<K, L>(self.inputs, self.source, self.pack, &fluid);
            // In a periodic box the nearest image of the particle counts.
            let arm = grid.nearest_image(std::array::from_fn(|d| position[d][row] - self.about[d]));
            let (arm, whole) = (vector(arm), vector(force.acceleration) * -pair.discretisation.mass);
            let pressure = vector(force.pressure) * -pair.discretisation.mass;
            let torque = arm.cross(whole) + DVec3::from(force.moment) * pair.discretisation.mass;
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
