//! The fused pair loop: one pass over all neighbours for everything that a step needs.
//!
//! One loop serves both schemes ([`sum_pairs`]): a scheme gives the sums of a particle, the terms
//! that a vector of neighbours adds to them and the end of a particle ([`FusedScheme`]). The terms
//! themselves are in `physics/`; `rates/wcsph_terms.rs` and `edac/edac_terms.rs` call them one
//! after another.
//!
//! Lengths are in units of h and the kernel is without its norm: the dimensions are multiplied
//! once per particle, not once per pair. The sums are locals of the loop and all terms are inlined
//! into it, so that the compiler keeps them in registers. One system per term would take 3.2 to
//! 3.5 times as long.

mod rate_columns;
mod shape;
mod wall_image;

use std::marker::PhantomData;
use std::ops::Range;

pub(crate) use rate_columns::FusedRates;
pub(super) use rate_columns::{FusedOutputs, OutputColumns, RateColumns, RateScalars};
pub(super) use shape::{
    Damped, DampedWithWalls, DampedWithWallsDriftCorrected, General, GeneralWithMoments, LoopShape, Plain,
    PlainWithWalls,
};
pub(super) use wall_image::WallImage;

use super::column_access::FusedInputsReader;
use super::density::LEAST_Q2;
use super::pack::{Entry, NeighbourMask, Only, Pack, PackPool, Source, Vector};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::wall_sides::{Behind, OwnSide, SideColumns};
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::physics::pair::PairGeometry;

/// Columns that the fused passes of both schemes read.
#[derive(Clone, Copy)]
pub(super) struct FusedInputs<'a, R: Real, const D: usize> {
    pub pair: &'a PairSettings,
    pub grid: &'a CellGrid<D>,
    pub zone: &'a [Zone],
    /// Position, m.
    pub position: &'a [Vec<f64>; D],
    /// Distance to the nearest wall, m; infinite where none is in the support.
    pub wall_distance: &'a [R],
    /// Body force of the rows, m/s²; empty where it is that of `pair`.
    pub body_force: &'a [Vec<R>; D],
    /// Sides of the rows near thin walls; empty where no wall is thin.
    pub sides: &'a SideColumns<R, D>,
    /// Part of the wall, in sums of the force on a body: only sides of this part count.
    pub body: Option<u16>,
    /// Masks of the neighbours in the support; empty where none were made.
    pub masks: &'a [NeighbourMask],
    /// Columns of the neighbours in the order in which they are packed.
    pub columns: &'a [&'a [R]],
}

/// Extremes of the rows of a pass.
pub(super) trait Summary: Copy + Default + Send {
    /// Returns the larger of each, whatever the order.
    fn join(self, other: Self) -> Self;
}

/// A fluid particle whose neighbours are summed over.
#[derive(Clone, Copy, Debug)]
pub(super) struct FluidRow<R, const D: usize> {
    pub row: usize,
    /// Position relative to the centre of the pack, in units of h.
    pub point: [R; D],
    /// Distance to the nearest wall, m; infinite where none is in the support.
    pub wall_distance: f64,
    /// Neighbours in the support.
    pub mask: NeighbourMask,
}

/// Quantities of a particle that the terms of both schemes take, in every lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnParticle<L, const D: usize> {
    /// Position relative to the centre of the pack, over h.
    pub x: [L; D],
    /// Velocity, m/s.
    pub v: [L; D],
    /// Pressure, Pa.
    pub pressure: L,
    /// Density, kg/m³.
    pub density: L,
    /// −ρ_a g h, Pa: times x_ab/h the hydrostatic part of a mirrored wall pressure.
    pub hydrostatic: [L; D],
    /// 1/d_a of the image factor 1 + d_b/d_a, 1/m.
    pub inverse_wall_distance: L,
    /// Side of a thin wall.
    pub side: OwnSide<L, D>,
}

/// Part of a scheme's loop that does not depend on the neighbours.
pub(super) trait PairTerms<L: Lanes, const D: usize> {
    /// Quantities of the particle.
    type Own;
    /// Sums over its neighbours, one per lane.
    type Sums;

    /// Returns the number of columns that the terms take, coordinates included.
    fn width(&self) -> usize;

    /// Returns the quantities of a row.
    fn own(&self, row: &FluidRow<L::Real, D>) -> Self::Own;

    /// Returns the sums of a row over no neighbours.
    fn no_sums(&self, own: &Self::Own) -> Self::Sums;

    /// Adds the terms of a vector of neighbours.
    fn add<K: KernelShape>(&self, own: &Self::Own, neighbours: Entry<'_, L>, sums: &mut Self::Sums);
}

/// Force of the neighbours on a row.
#[derive(Clone, Copy, Debug)]
pub(super) struct RowForce<const D: usize> {
    /// Acceleration, m/s².
    pub acceleration: [f64; D],
    /// Part of the acceleration due to pressure, m/s².
    pub pressure: [f64; D],
    /// Σ x_ab × (acceleration by the pair), m²/s².
    pub moment: [f64; 3],
}

/// A scheme whose rates a fused pass sums.
pub(super) trait FusedScheme<R: Real, const D: usize>: Sync {
    /// Extremes of the rows.
    type Summary: Summary;

    /// Sums over the rows of a block; must be `#[inline(always)]`.
    fn sum_block<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        block: FusedBlock<'_, K, Self, R, D>,
    ) -> Self::Summary
    where
        Self: Sized;

    /// Sums the force on one row with all terms of the scene; must be `#[inline(always)]`.
    fn row_force<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        inputs: &FusedInputs<'_, R, D>,
        source: &Source<'_, R, D>,
        pack: &Pack<R>,
        row: &FluidRow<R, D>,
    ) -> RowForce<D>;
}

/// Treatment of the fluid rows of a block by one shape of a scheme's loop.
pub(super) trait BlockLoop<R: Real, const D: usize> {
    /// Extremes of the rows.
    type Summary: Summary;

    /// Sums over a pack for a row and joins its extremes to those of its cell; must be
    /// `#[inline(always)]`.
    fn sum_row<K: KernelShape>(&mut self, pack: &Pack<R>, row: &FluidRow<R, D>, of_cell: &mut Self::Summary);

    /// Returns the extremes of the block from those of its cells, squares of vectors still in
    /// place of their lengths; must be `#[inline(always)]`.
    fn finish(&mut self, of_cells: Self::Summary) -> Self::Summary;
}

/// Adds the terms of all neighbours of a row: the pair loop of both schemes.
#[inline(always)]
pub(super) fn sum_pairs<K: KernelShape, L: Lanes, T: PairTerms<L, D>, const D: usize>(
    terms: &T,
    pack: &Pack<L::Real>,
    row: &FluidRow<L::Real, D>,
) -> T::Sums {
    let own = terms.own(row);
    let mut sums = terms.no_sums(&own);
    for neighbours in pack.masked_entries::<L, D>(terms.width(), row.mask) {
        terms.add::<K>(&own, neighbours, &mut sums);
    }
    sums
}

impl<L: Lanes, const D: usize> OwnParticle<L, D> {
    /// Returns the quantities of a row of a density, kg/m³, and a pressure, Pa.
    #[inline(always)]
    pub(super) fn new(
        inputs: &FusedInputs<'_, L::Real, D>,
        row: &FluidRow<L::Real, D>,
        v: [L; D],
        density: f64,
        pressure: f64,
    ) -> Self {
        let pair = inputs.pair;
        let mut x = [L::constant(0.0); D];
        let mut hydrostatic = [L::constant(0.0); D];
        for d in 0..D {
            x[d] = L::splat(row.point[d]);
            let force = inputs.body_force[d].get(row.row).map_or(pair.body_force[d], |force| force.to_f64());
            hydrostatic[d] = L::constant(-density * force * pair.discretisation.smoothing_length);
        }
        let inverse_distance =
            pair.wall_model.inverse_distance(row.wall_distance, pair.discretisation.spacing);
        Self {
            x,
            v,
            pressure: L::constant(pressure),
            density: L::constant(density),
            hydrostatic,
            inverse_wall_distance: L::constant(inverse_distance),
            side: OwnSide::new(
                inputs.sides,
                row.row,
                row.wall_distance,
                pair.discretisation.smoothing_length,
                inputs.body,
            ),
        }
    }

    /// Returns distance, relative velocity and kernel of a vector of neighbours.
    #[inline(always)]
    pub(super) fn geometry<K: KernelShape>(
        &self,
        neighbours: Entry<'_, L>,
        velocity: Vector,
        facing: Option<Vector>,
    ) -> (PairGeometry<L, D>, Option<Behind<L>>) {
        let mut x = [L::constant(0.0); D];
        let mut v = [L::constant(0.0); D];
        let mut q2 = L::constant(LEAST_Q2);
        for d in 0..D {
            x[d] = self.x[d] - neighbours.column(d);
            v[d] = self.v[d] - neighbours.column(velocity.0 + d);
            q2 = x[d].mul_add(x[d], q2);
        }
        let (q, inverse_q) = q2.roots();
        let behind = facing.map(|facing| Behind::new(&self.side, facing, neighbours, x));
        if let Some(behind) = &behind {
            v = self.side.relative_velocity(behind, self.v, v);
        }
        (PairGeometry { x, v, q2, q, inverse_q, slope: K::slope(q, inverse_q) }, behind)
    }
}

impl<'a, R: Real, const D: usize> FusedInputs<'a, R, D> {
    /// Returns the inputs of a pass over these columns of the neighbours.
    pub(super) fn new(
        pair: &'a PairSettings,
        grid: &'a CellGrid<D>,
        particles: &'a ParticleArrays<R, D>,
        sums: &'a PairSums<R, D>,
        columns: &'a [&'a [R]],
    ) -> Self {
        Self {
            pair,
            grid,
            zone: &particles.zone,
            position: &particles.position,
            wall_distance: &particles.wall_distance,
            body_force: &sums.body_force,
            sides: sums.sides.read(FusedInputsReader),
            body: None,
            masks: &sums.near,
            columns,
        }
    }

    /// Returns the source of the packs for a kernel of a support, over h.
    pub(super) fn source(&self, support_ratio: f64, only: Only<'a, R>) -> Source<'a, R, D> {
        Source {
            grid: self.grid,
            position: self.position,
            columns: self.columns,
            inverse_h: 1.0 / self.pair.discretisation.smoothing_length,
            support_ratio,
            only,
        }
    }
}

/// The fused pass of a scheme over all cells.
pub(super) struct FusedPass<'a, S, R: Real, const D: usize> {
    pub scheme: &'a S,
    pub inputs: FusedInputs<'a, R, D>,
    pub packs: &'a PackPool<R>,
    pub outputs: FusedOutputs<'a, R, D>,
}

impl<S: FusedScheme<R, D>, R: Real, const D: usize> WithShape for FusedPass<'_, S, R, D> {
    type Output = S::Summary;

    fn run<K: KernelShape>(self) -> S::Summary {
        let Self { scheme, inputs, packs, outputs } = self;
        let source = inputs.source(K::SUPPORT, Only::All);
        let work = |cells: Range<usize>, outputs: &mut FusedOutputs<R, D>| {
            let first = inputs.grid.rows(cells.start).start;
            let block = FusedBlock::<K, S, R, D> {
                scheme,
                inputs: &inputs,
                source: &source,
                cells,
                outputs: OutputColumns::from_row(first, outputs),
                pack: &mut packs.of_this_thread(),
                kernel: PhantomData,
            };
            R::dispatch(inputs.pair.lanes, block)
        };
        inputs.pair.ranks.for_each_block(inputs.grid, outputs, &work, &S::Summary::join)
    }
}

/// A block of cells of a fused pass.
pub(super) struct FusedBlock<'a, K, S, R: Real, const D: usize> {
    scheme: &'a S,
    pub inputs: &'a FusedInputs<'a, R, D>,
    pub source: &'a Source<'a, R, D>,
    cells: Range<usize>,
    pub outputs: OutputColumns<'a, R, D>,
    pack: &'a mut Pack<R>,
    kernel: PhantomData<K>,
}

impl<K: KernelShape, S: FusedScheme<R, D>, R: Real, const D: usize> Vectorised<R>
    for FusedBlock<'_, K, S, R, D>
{
    type Output = S::Summary;
    type Module = S;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> S::Summary {
        self.scheme.sum_block::<K, L>(self)
    }
}

/// The cells of a block, without its outputs.
pub(super) struct BlockCells<'a, R: Real, const D: usize> {
    inputs: &'a FusedInputs<'a, R, D>,
    source: &'a Source<'a, R, D>,
    cells: Range<usize>,
    pack: &'a mut Pack<R>,
}

impl<'a, K, S, R: Real, const D: usize> FusedBlock<'a, K, S, R, D> {
    /// Separates the outputs of the block from its cells.
    #[inline(always)]
    pub(super) fn split(self) -> (BlockCells<'a, R, D>, OutputColumns<'a, R, D>) {
        let Self { inputs, source, cells, outputs, pack, .. } = self;
        (BlockCells { inputs, source, cells, pack }, outputs)
    }
}

impl<R: Real, const D: usize> BlockCells<'_, R, D> {
    /// Runs a loop over all fluid rows of the cells.
    #[inline(always)]
    pub(super) fn sum_rows<K: KernelShape, L: Lanes<Real = R>, B: BlockLoop<R, D>>(
        self,
        block_loop: &mut B,
    ) -> B::Summary {
        let (zone, grid) = (self.inputs.zone, self.inputs.grid);
        let mut summary = B::Summary::default();
        for cell in self.cells {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| zone[row] == Zone::Fluid) {
                continue;
            }
            // Of each cell apart: the extremes of the block are in memory, and joining every row to
            // them took a twentieth of the pass.
            let mut of_cell = B::Summary::default();
            for row in rows {
                if zone[row] != Zone::Fluid {
                    continue;
                }
                let row = FluidRow {
                    row,
                    point: self.pack.relative(self.source, row),
                    wall_distance: self.inputs.wall_distance[row].to_f64(),
                    mask: NeighbourMask::of_row(self.inputs.masks, row),
                };
                block_loop.sum_row::<K>(self.pack, &row, &mut of_cell);
            }
            summary = summary.join(of_cell);
        }
        block_loop.finish(summary)
    }
}
