//! Rates of the fluid under `EdacTvf`, where the pressure evolves.
//!
//! The equations are in `physics/edac.rs`: Negi et al. (2020), Eqs. 6–11. The integrator adds the
//! body force. The pair loop is that of `fused`; `edac_terms.rs` calls the terms.
//! Volumes in the loop are in units of that of the lattice.

mod edac_columns;
mod edac_sums;
mod edac_terms;
#[cfg(test)]
mod tests;

use std::marker::PhantomData;

use edac_columns::{EdacColumns, columns};
use edac_terms::EdacSettings;

use super::body::{Body, BodyPass, ExactBodySum};
use super::fused::{
    BlockLoop, FluidRow, FusedBlock, FusedInputs, FusedPass, FusedScheme, General, GeneralWithMoments,
    LoopShape, OutputColumns, Plain, PlainWithWalls, RateColumns, RateScalars, RowForce, Summary, sum_pairs,
};
use super::pack::{Pack, Source};
use super::rates::larger;
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::physics::edac::Edac;

/// Largest values over all fluid rows, for the time step and the monitor. A rate that is NaN makes
/// its largest value NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EdacSummary {
    /// Largest |v|, m/s.
    pub speed: f64,
    /// Largest |∇·v|, 1/s.
    pub divergence: f64,
    /// Largest rate at which a dissipative term damps a particle's velocity or pressure among
    /// neighbours that keep theirs, 1/s.
    pub damping: f64,
}

impl Summary for EdacSummary {
    fn join(self, other: Self) -> Self {
        Self {
            speed: larger(self.speed, other.speed),
            divergence: larger(self.divergence, other.divergence),
            damping: larger(self.damping, other.damping),
        }
    }
}

/// Sums acceleration, rate of pressure, acceleration by the background pressure and divergence of
/// the fluid rows over all rows.
///
/// Each rank gets the largest values over its own rows.
pub fn sum_rates<R: Real, const D: usize>(
    pair: &PairSettings,
    edac: &Edac,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) -> EdacSummary {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    let mut outputs = RateColumns::take(RateScalars::PressureRateAndDivergence, particles, sums);
    let (places, list) = columns(pair, particles, sums, has_walls);
    let summary = pair.discretisation.kernel.with_shape(FusedPass {
        scheme: &EdacTvf { edac, columns: places },
        inputs: FusedInputs::new(pair, grid, particles, sums, list.as_slice()),
        packs: &sums.packs,
        outputs: outputs.as_outputs(),
    });
    outputs.put_back(particles, sums);
    summary
}

/// Sums force and torque of the fluid on a body, by the columns that the rates of the present step
/// are made of.
pub fn sum_body_force<R: Real, const D: usize>(
    pair: &PairSettings,
    edac: &Edac,
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
    body: &mut Body,
) -> ExactBodySum {
    if !body.prepare(pair, grid, particles, sums) {
        return ExactBodySum::default();
    }
    let (places, list) = columns(pair, particles, sums, true);
    let inputs = FusedInputs {
        body: Some(body.part),
        ..FusedInputs::new(pair, grid, particles, sums, list.as_slice())
    };
    let scheme = EdacTvf { edac, columns: places };
    let of_body = &sums.columns.body;
    pair.discretisation.kernel.with_shape(BodyPass {
        scheme: &scheme,
        inputs,
        of_body,
        packs: &sums.packs,
        body,
    })
}

/// The scheme `EdacTvf` for a fused pass.
struct EdacTvf<'a> {
    edac: &'a Edac,
    columns: EdacColumns,
}

impl<R: Real, const D: usize> FusedScheme<R, D> for EdacTvf<'_> {
    type Summary = EdacSummary;

    #[inline(always)]
    fn sum_block<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        block: FusedBlock<'_, K, Self, R, D>,
    ) -> EdacSummary {
        let settings = EdacSettings::<L, D>::new(block.inputs, block.source, self.edac, self.columns);
        match (settings.fit_fixed_shapes(), self.columns.image_distance.is_some()) {
            (true, false) => sum_rows::<K, L, Plain, R, D>(&settings, block),
            (true, true) => sum_rows::<K, L, PlainWithWalls, R, D>(&settings, block),
            (false, _) => sum_rows::<K, L, General, R, D>(&settings, block),
        }
    }

    #[inline(always)]
    fn row_force<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        inputs: &FusedInputs<'_, R, D>,
        source: &Source<'_, R, D>,
        pack: &Pack<R>,
        row: &FluidRow<R, D>,
    ) -> RowForce<D> {
        let settings = EdacSettings::<L, D>::new(inputs, source, self.edac, self.columns);
        let terms = settings.with_shape::<GeneralWithMoments>();
        let sums = sum_pairs::<K, L, _, D>(&terms, pack, row);
        let rates = terms.rates(&sums, row);
        let moment = terms.moment(&sums, row.row);
        RowForce { acceleration: rates.acceleration, pressure: rates.pressure_part, moment }
    }
}

/// Sums over the rows of a block by the loop of a shape.
#[inline(always)]
fn sum_rows<K: KernelShape, L: Lanes<Real = R>, S: LoopShape, R: Real, const D: usize>(
    settings: &EdacSettings<'_, L, D>,
    block: FusedBlock<'_, K, EdacTvf<'_>, R, D>,
) -> EdacSummary {
    let (cells, outputs) = block.split();
    cells.sum_rows::<K, L, _>(&mut EdacBlock::<L, S, D> { settings, outputs, shape: PhantomData })
}

/// Treatment of the rows of a block by a loop of a shape.
struct EdacBlock<'b, 'a, L: Lanes, S, const D: usize> {
    settings: &'b EdacSettings<'a, L, D>,
    outputs: OutputColumns<'b, L::Real, D>,
    shape: PhantomData<S>,
}

impl<L: Lanes, S: LoopShape, const D: usize> BlockLoop<L::Real, D> for EdacBlock<'_, '_, L, S, D> {
    type Summary = EdacSummary;

    #[inline(always)]
    fn sum_row<K: KernelShape>(
        &mut self,
        pack: &Pack<L::Real>,
        row: &FluidRow<L::Real, D>,
        of_cell: &mut EdacSummary,
    ) {
        let terms = self.settings.with_shape::<S>();
        let sums = sum_pairs::<K, L, _, D>(&terms, pack, row);
        let rates = terms.rates(&sums, row);
        let OutputColumns { first, acceleration, shift, scalars: [pressure_rate, divergence] } =
            &mut self.outputs;
        let at = row.row - *first;
        let mut speed = 0.0;
        for d in 0..D {
            acceleration[d][at] = L::Real::from_f64(rates.acceleration[d]);
            shift[d][at] = L::Real::from_f64(rates.background[d]);
            let v = self.settings.source.columns[d][row.row].to_f64();
            speed += v * v;
        }
        pressure_rate[at] = L::Real::from_f64(rates.pressure_rate);
        divergence[at] = L::Real::from_f64(rates.divergence);
        let of_row = EdacSummary { speed, divergence: rates.divergence.abs(), damping: rates.damping };
        *of_cell = of_cell.join(of_row);
    }

    #[inline(always)]
    fn finish(&mut self, of_cells: EdacSummary) -> EdacSummary {
        // The root of the largest square is the largest root: one root for the block.
        EdacSummary { speed: of_cells.speed.sqrt(), ..of_cells }
    }
}
