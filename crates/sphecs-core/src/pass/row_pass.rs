//! Common driver of the pair passes.
//!
//! A pass states its neighbour columns ([`PassInput`]), which particles it sums for, the sum and
//! where the result goes. The driver packs the neighbourhood of every cell once and runs the sums
//! inside the function that has the vector instructions.
//!
//! - [`RowPass`]: the sum of a particle depends on its neighbourhood alone. This is the usual kind.
//! - [`BlockPass`]: particles are finished in batches, or a block has a summary (`strain`, `rates`,
//!   `edac`).
//! - [`PointPass`]: the sums are at a list of points, such as those of inlets and outlets.
//!
//! Every method that a trait requires must be `#[inline(always)]`. Otherwise its body would be
//! compiled without the vector instructions.

use std::marker::PhantomData;
use std::ops::Range;

use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use super::pack::{Only, Pack, PackPool, Source};
use super::ranks::{PointResult, SharedColumns};
use super::settings::PairSettings;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;

/// Points that a thread takes at a time.
const POINTS: usize = 64;

/// Neighbour data that a pass reads.
#[derive(Clone, Copy, Debug)]
pub(super) struct PassInput<'a, R, const D: usize> {
    /// Settings of the pair passes.
    pub pair: &'a PairSettings,
    /// Grid that the particles are sorted by.
    pub grid: &'a CellGrid<D>,
    /// Positions of the particles, m.
    pub position: &'a [Vec<f64>; D],
    /// Columns behind the coordinates, in the order in which the sum reads them.
    pub columns: &'a [&'a [R]],
    /// Particles that are neighbours.
    pub only: Only<'a, R>,
    /// Buffers of the neighbourhoods, one per thread.
    pub packs: &'a PackPool<R>,
}

/// Consecutive cells whose particles a thread sums for, and the buffer for their neighbourhoods.
pub(super) struct Block<'a, R, const D: usize> {
    /// Origin of the neighbourhoods.
    pub source: &'a Source<'a, R, D>,
    /// Cells of the block.
    pub cells: Range<usize>,
    /// Neighbourhood of one cell.
    pub pack: &'a mut Pack<R>,
}

impl<R: Real, const D: usize> Block<'_, R, D> {
    /// Returns the rows of the block.
    #[inline(always)]
    pub(super) fn rows(&self) -> Range<usize> {
        let grid = self.source.grid;
        grid.rows(self.cells.start).start..grid.rows(self.cells.end - 1).end
    }
}

/// A pass with a state of its own within a block of cells.
pub(super) trait BlockPass<R: Real, const D: usize>: Sync {
    /// Columns that the pass writes, cut into the rows of a block.
    type Outputs: SharedColumns;
    /// Result of a block besides its columns.
    type Summary: Default + Send;
    /// Type in whose module the loops are compiled: see [`Vectorised::Module`].
    type Module;

    /// Sums for the particles of a block and stores the results.
    fn block<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        block: Block<'_, R, D>,
        outputs: &mut Self::Outputs,
    ) -> Self::Summary;

    /// Joins the summaries of two blocks; the result must not depend on the order.
    fn join(first: Self::Summary, second: Self::Summary) -> Self::Summary;
}

/// A pass whose sum for a particle depends on the neighbourhood alone.
pub(super) trait RowPass<R: Real, const D: usize>: Sync {
    /// Columns that the pass writes, cut into the rows of a block.
    type Outputs: SharedColumns;
    /// Result for one particle.
    type Sum;

    /// Returns true if the pass sums for the particle of a row.
    fn includes(&self, row: usize) -> bool;

    /// Sums over the neighbourhood of the particle of a row.
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> Self::Sum;

    /// Stores the result for a particle; `slot` is its row, counted from the first of the block.
    fn store(&self, row: usize, slot: usize, sum: Self::Sum, outputs: &mut Self::Outputs);

    /// Returns the result for a particle with no neighbour in its support; None if this is not
    /// tested before the sum.
    ///
    /// The test pays where many particles are far from all neighbours, such as the outer layers of
    /// a wall.
    #[inline(always)]
    fn isolated(&self) -> Option<Self::Sum> {
        None
    }

    /// Prepares the outputs of a block whose particles are these rows.
    #[inline(always)]
    fn begin(&self, _rows: Range<usize>, _outputs: &mut Self::Outputs) {}

    /// Finishes the outputs of a block whose particles are these rows.
    #[inline(always)]
    fn finish(&self, _rows: Range<usize>, _outputs: &mut Self::Outputs) {}
}

/// A row pass as a block pass: particle by particle, without a summary.
struct EachRow<'a, P>(&'a P);

impl<R: Real, const D: usize, P: RowPass<R, D>> BlockPass<R, D> for EachRow<'_, P> {
    type Outputs = P::Outputs;
    type Summary = ();
    type Module = P;

    #[inline(always)]
    fn block<K: KernelShape, L: Lanes<Real = R>>(&self, block: Block<'_, R, D>, outputs: &mut P::Outputs) {
        let (pass, rows) = (self.0, block.rows());
        let Block { source, cells, pack } = block;
        pass.begin(rows.clone(), outputs);
        for cell in cells {
            if !pack.fill::<L, D>(source, cell, |row| pass.includes(row)) {
                continue;
            }
            let bounds = pass.isolated().map(|_| pack.bounds::<L, D>());
            for row in source.grid.rows(cell) {
                if !pass.includes(row) {
                    continue;
                }
                let sum = match (bounds, pass.isolated()) {
                    (Some(bounds), Some(isolated))
                        if pack.is_empty()
                            || bounds.out_of_reach(pack.relative(source, row), K::SUPPORT * K::SUPPORT) =>
                    {
                        isolated
                    }
                    _ => pass.sum::<K, L>(pack, source, row),
                };
                pass.store(row, row - rows.start, sum, outputs);
            }
        }
        pass.finish(rows, outputs);
    }

    fn join(_: (), _: ()) {}
}

/// A pass whose sums are at points of a list, in which points of one cell follow each other.
pub(super) trait PointPass<R: Real, const D: usize>: Sync {
    /// Entry of the list.
    type Point: Copy + Sync;
    /// Result at a point.
    type Found: PointResult;

    /// Returns the position of an entry, m; None for an entry that is to have the default result.
    fn position(&self, point: Self::Point) -> Option<[f64; D]>;

    /// Sums over the neighbourhood of an entry at `x`, in units of h from the centre of the pack.
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        point: Self::Point,
        x: [R; D],
    ) -> Self::Found;
}

impl<'a, R: Real, const D: usize> PassInput<'a, R, D> {
    /// Runs a pass over all cells, in parallel, particle by particle.
    pub(super) fn run<P: RowPass<R, D>>(self, pass: &P, outputs: P::Outputs) {
        self.run_blocks(&EachRow(pass), outputs);
    }

    /// Runs a pass over all cells, in parallel, block by block; returns the joined summaries.
    pub(super) fn run_blocks<P: BlockPass<R, D>>(self, pass: &P, outputs: P::Outputs) -> P::Summary {
        self.pair.discretisation.kernel.with_shape(OverBlocks { input: self, pass, outputs })
    }

    /// Runs a pass over the points of a list, in parallel.
    pub(super) fn run_at<P: PointPass<R, D>>(self, pass: &P, points: &[P::Point], found: &mut [P::Found]) {
        self.pair.discretisation.kernel.with_shape(OverPoints { input: self, pass, points, found });
    }

    /// Returns the origin of the neighbourhoods under a kernel.
    fn source<K: KernelShape>(&self) -> Source<'a, R, D> {
        Source {
            grid: self.grid,
            position: self.position,
            columns: self.columns,
            inverse_h: 1.0 / self.pair.discretisation.smoothing_length,
            support_ratio: K::SUPPORT,
            only: self.only,
        }
    }
}

/// A pass over blocks of cells, before the kernel is known.
struct OverBlocks<'a, R: Real, const D: usize, P: BlockPass<R, D>> {
    input: PassInput<'a, R, D>,
    pass: &'a P,
    outputs: P::Outputs,
}

impl<R: Real, const D: usize, P: BlockPass<R, D>> WithShape for OverBlocks<'_, R, D, P> {
    type Output = P::Summary;

    fn run<K: KernelShape>(self) -> P::Summary {
        let Self { input, pass, outputs } = self;
        let source = input.source::<K>();
        let work = |cells: Range<usize>, outputs: &mut P::Outputs| {
            let block = Block { source: &source, cells, pack: &mut input.packs.of_this_thread() };
            R::dispatch(
                input.pair.lanes,
                VectorBlock::<K, R, D, P> { block, pass, outputs, shape: PhantomData },
            )
        };
        input.pair.ranks.for_each_block(input.grid, outputs, &work, &P::join)
    }
}

/// The work of a pass in one block.
struct VectorBlock<'a, K, R: Real, const D: usize, P: BlockPass<R, D>> {
    block: Block<'a, R, D>,
    pass: &'a P,
    outputs: &'a mut P::Outputs,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize, P: BlockPass<R, D>> Vectorised<R>
    for VectorBlock<'_, K, R, D, P>
{
    type Output = P::Summary;
    type Module = P::Module;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> P::Summary {
        self.pass.block::<K, L>(self.block, self.outputs)
    }
}

/// A pass over points, before the kernel is known.
struct OverPoints<'a, R: Real, const D: usize, P: PointPass<R, D>> {
    input: PassInput<'a, R, D>,
    pass: &'a P,
    points: &'a [P::Point],
    found: &'a mut [P::Found],
}

impl<R: Real, const D: usize, P: PointPass<R, D>> WithShape for OverPoints<'_, R, D, P> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let Self { input, pass, points, found } = self;
        let source = input.source::<K>();
        input.pair.ranks.for_points(found, &|part, found| {
            let points = points[part].par_chunks(POINTS);
            points.zip(found.par_chunks_mut(POINTS)).for_each(|(points, found)| {
                let pack = &mut input.packs.of_this_thread();
                let shape = PhantomData;
                let chunk = VectorPoints::<K, R, D, P> { source: &source, pass, points, found, pack, shape };
                R::dispatch(input.pair.lanes, chunk);
            });
        });
    }
}

/// The work of a pass at consecutive points of its list.
struct VectorPoints<'a, K, R: Real, const D: usize, P: PointPass<R, D>> {
    source: &'a Source<'a, R, D>,
    pass: &'a P,
    points: &'a [P::Point],
    found: &'a mut [P::Found],
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize, P: PointPass<R, D>> Vectorised<R>
    for VectorPoints<'_, K, R, D, P>
{
    type Output = ();
    type Module = P;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let mut packed = None;
        for (&point, found) in self.points.iter().zip(self.found) {
            let Some(position) = self.pass.position(point) else {
                *found = P::Found::default();
                continue;
            };
            let cell = self.source.grid.unwrapped_index(position);
            if packed != Some(cell) {
                self.pack.fill_around::<L, D>(self.source, cell);
                packed = Some(cell);
            }
            let x = self.pack.relative_to(self.source, position);
            *found = self.pass.sum::<K, L>(self.pack, self.source, point, x);
        }
    }
}

/// Returns a point with every coordinate in all lanes.
#[inline(always)]
pub(super) fn splat<L: Lanes, const D: usize>(point: [L::Real; D]) -> [L; D] {
    let mut lanes = [L::constant(0.0); D];
    for d in 0..D {
        lanes[d] = L::splat(point[d]);
    }
    lanes
}
