//! Rates of the fluid under `Wcsph`.
//!
//! ```text
//! dv_a/dt = −(1/ρ_a) Σ V_b (p_a + p_b) ∇W + viscous term (+ noise damping)
//!           (+ Σ m_b (T_a/ρ_a² + T_b/ρ_b²)·∇W)
//! ∇C_a    = Σ V_b ∇W,   ∇·v_a = Σ V_b (v_b − v_a)·∇W,   signal_a = max_b |h x_ab·v_ab/(r² + η²)|
//! or, with the drift corrected: s_a − Σ V_b W_ab s_b / Σ V_b W_ab,   b: fluid, a itself included
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 10 and 18. The integrator adds the body force. The pair
//! loop is that of `fused`; `wcsph_terms.rs` calls the terms, which are in
//! `physics/`. Loops of a fixed shape finish several rows at once (`batch.rs`).

mod batch;
#[cfg(test)]
mod tests;
mod wcsph_columns;
mod wcsph_sums;
mod wcsph_terms;

use std::marker::PhantomData;

use batch::{Batch, BatchedRow};
use wcsph_columns::{WcsphColumns, columns};
use wcsph_terms::WcsphSettings;

use super::body::{Body, BodyPass, ExactBodySum};
use super::column_access::WcsphRates;
use super::fused::{
    BlockLoop, Damped, DampedWithWalls, DampedWithWallsDriftCorrected, FluidRow, FusedBlock, FusedInputs,
    FusedPass, FusedScheme, General, GeneralWithMoments, LoopShape, OutputColumns, Plain, PlainWithWalls,
    RateColumns, RateScalars, RowForce, Summary, sum_pairs,
};
use super::pack::{Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Largest values over all fluid rows, for the time step and the monitor. A rate that is NaN makes
/// its largest value NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RatesSummary {
    /// Largest |dv/dt| without the body force, m/s².
    pub acceleration: f64,
    /// Largest c_a + max_b |h x_ab·v_ab/(r² + η²)|, m/s.
    pub signal_speed: f64,
    /// Largest |v|, m/s.
    pub speed: f64,
    /// Largest |∇·v|, 1/s.
    pub divergence: f64,
    /// Largest eddy viscosity ν_t, m²/s.
    pub eddy_viscosity: f64,
    /// Largest rate at which the viscous term damps a particle among neighbours at rest, 1/s, over
    /// particles without a wall in their support.
    pub damping: f64,
    /// Largest such rate over particles with a wall in their support, 1/s.
    pub damping_at_walls: f64,
}

/// Time level of the velocities that a pass takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TimeLevel {
    /// The present time.
    Present,
    /// One step earlier, for the dissipative terms of a leapfrog step.
    Previous,
}

impl TimeLevel {
    /// Returns the velocities of this level.
    pub fn columns<R: Real, const D: usize>(self, particles: &ParticleArrays<R, D>) -> &[Vec<R>; D] {
        match self {
            TimeLevel::Present => &particles.velocity,
            TimeLevel::Previous => &particles.previous_velocity,
        }
    }
}

impl Summary for RatesSummary {
    fn join(self, other: Self) -> Self {
        Self {
            acceleration: larger(self.acceleration, other.acceleration),
            signal_speed: larger(self.signal_speed, other.signal_speed),
            speed: larger(self.speed, other.speed),
            divergence: larger(self.divergence, other.divergence),
            eddy_viscosity: larger(self.eddy_viscosity, other.eddy_viscosity),
            damping: larger(self.damping, other.damping),
            damping_at_walls: larger(self.damping_at_walls, other.damping_at_walls),
        }
    }
}

/// Returns the larger of two numbers, or NaN if `b` is NaN: `f64::max` would hide it.
pub fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Sums acceleration, shifting vector and divergence of the fluid rows over all rows.
///
/// Each rank gets the largest values over its own rows.
pub fn sum_rates<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
) -> RatesSummary {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    if !pair.shifting.keeps_drift() {
        sums.columns.find_fluid_volume(pair, particles);
    }
    let scalars = RateScalars::DivergenceAndDamping { per_row: has_walls };
    let mut outputs = RateColumns::take(scalars, particles, sums);
    let (places, list) = columns(pair, particles, level, sums, has_walls);
    let scheme = Wcsph { columns: places, eddy_viscosity: sums.eddy_viscosity.read(WcsphRates) };
    let summary = pair.discretisation.kernel.with_shape(FusedPass {
        scheme: &scheme,
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
    grid: &CellGrid<D>,
    particles: &ParticleArrays<R, D>,
    level: TimeLevel,
    sums: &mut PairSums<R, D>,
    body: &mut Body,
) -> ExactBodySum {
    if !body.prepare(pair, grid, particles, sums) {
        return ExactBodySum::default();
    }
    let (places, list) = columns(pair, particles, level, sums, true);
    let scheme = Wcsph { columns: places, eddy_viscosity: sums.eddy_viscosity.read(WcsphRates) };
    let inputs = FusedInputs {
        body: Some(body.part),
        ..FusedInputs::new(pair, grid, particles, sums, list.as_slice())
    };
    let of_body = &sums.columns.body;
    pair.discretisation.kernel.with_shape(BodyPass {
        scheme: &scheme,
        inputs,
        of_body,
        packs: &sums.packs,
        body,
    })
}

/// The scheme `Wcsph` for a fused pass.
struct Wcsph<'a, R> {
    columns: WcsphColumns,
    /// Eddy viscosity ν_t of the rows, m²/s; empty without sub-particle-scale stress.
    eddy_viscosity: &'a [R],
}

impl<R: Real, const D: usize> FusedScheme<R, D> for Wcsph<'_, R> {
    type Summary = RatesSummary;

    #[inline(always)]
    fn sum_block<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        block: FusedBlock<'_, K, Self, R, D>,
    ) -> RatesSummary {
        let settings = WcsphSettings::<L, D>::new(block.inputs, block.source, self.columns);
        let columns = &self.columns;
        let (damped, walls) = (columns.strain.is_some(), columns.image_distance.is_some());
        match (settings.fit_fixed_shapes(), damped, walls, columns.concentration.is_some()) {
            (true, false, false, false) => self.sum_rows::<K, L, Plain, D>(&settings, block),
            (true, false, true, false) => self.sum_rows::<K, L, PlainWithWalls, D>(&settings, block),
            (true, true, false, false) => self.sum_rows::<K, L, Damped, D>(&settings, block),
            (true, true, true, false) => self.sum_rows::<K, L, DampedWithWalls, D>(&settings, block),
            (true, true, true, true) => {
                self.sum_rows::<K, L, DampedWithWallsDriftCorrected, D>(&settings, block)
            }
            _ => self.sum_rows::<K, L, General, D>(&settings, block),
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
        let settings = WcsphSettings::<L, D>::new(inputs, source, self.columns);
        let terms = settings.with_shape::<GeneralWithMoments>();
        let sums = sum_pairs::<K, L, _, D>(&terms, pack, row);
        let (pressure, moment) = terms.pressure_and_moment(&sums);
        RowForce { acceleration: terms.rates(&sums, row).acceleration, pressure, moment }
    }
}

impl<R: Real> Wcsph<'_, R> {
    /// Sums over the rows of a block by the loop of a shape.
    #[inline(always)]
    fn sum_rows<K: KernelShape, L: Lanes<Real = R>, S: LoopShape, const D: usize>(
        &self,
        settings: &WcsphSettings<'_, L, D>,
        block: FusedBlock<'_, K, Self, R, D>,
    ) -> RatesSummary {
        let (cells, outputs) = block.split();
        let mut block_loop = WcsphBlock::<L, S, D> {
            settings,
            outputs,
            batch: Batch::new(),
            eddy_viscosity: self.eddy_viscosity,
            shape: PhantomData,
        };
        cells.sum_rows::<K, L, _>(&mut block_loop)
    }
}

/// Treatment of the rows of a block by a loop of a shape.
struct WcsphBlock<'b, 'a, L: Lanes, S, const D: usize> {
    settings: &'b WcsphSettings<'a, L, D>,
    outputs: OutputColumns<'b, L::Real, D>,
    /// Rows of a batched loop whose rates are not written yet.
    batch: Batch<L, D>,
    eddy_viscosity: &'b [L::Real],
    shape: PhantomData<S>,
}

impl<L: Lanes, S: LoopShape, const D: usize> WcsphBlock<'_, '_, L, S, D> {
    /// True if the rates of several rows are written at once.
    const BATCHED: bool = S::FIXED && !S::CORRECTS_DRIFT;

    /// Sums over a pack for a row and adds it to the batch.
    #[inline(always)]
    fn sum_batched<K: KernelShape>(&mut self, pack: &Pack<L::Real>, row: &FluidRow<L::Real, D>) {
        let at_wall = row.wall_distance.is_finite();
        // Most rows have no wall in their support: their neighbours need no image factor.
        let sums = if S::WALLS && at_wall {
            sum_pairs::<K, L, _, D>(&self.settings.with_shape::<S>(), pack, row)
        } else {
            sum_pairs::<K, L, _, D>(&self.settings.with_shape::<S::AwayFromWalls>(), pack, row)
        };
        let source = self.settings.source;
        let velocity = std::array::from_fn(|d| source.columns[d][row.row]);
        let batched = BatchedRow { row: row.row, velocity, at_wall };
        if self.batch.add(self.settings, &sums, batched) {
            self.batch.finish(self.settings, &mut self.outputs);
        }
    }

    /// Sums over a pack for a row, writes its rates and returns its extremes.
    #[inline(always)]
    fn sum_one<K: KernelShape>(&mut self, pack: &Pack<L::Real>, row: &FluidRow<L::Real, D>) -> RatesSummary {
        let terms = self.settings.with_shape::<S>();
        let sums = sum_pairs::<K, L, _, D>(&terms, pack, row);
        let rates = terms.rates(&sums, row);
        let OutputColumns { first, acceleration, shift, scalars: [divergence, damping] } = &mut self.outputs;
        let at = row.row - *first;
        let mut square = 0.0;
        let mut speed = 0.0;
        for d in 0..D {
            acceleration[d][at] = L::Real::from_f64(rates.acceleration[d]);
            shift[d][at] = L::Real::from_f64(rates.shift[d]);
            square += rates.acceleration[d] * rates.acceleration[d];
            let v = self.settings.source.columns[d][row.row].to_f64();
            speed += v * v;
        }
        divergence[at] = L::Real::from_f64(rates.divergence);
        if let Some(damping) = damping.get_mut(at) {
            *damping = L::Real::from_f64(rates.damping);
        }
        let at_wall = row.wall_distance.is_finite();
        RatesSummary {
            acceleration: square,
            signal_speed: rates.signal_speed,
            speed,
            divergence: rates.divergence.abs(),
            damping: if at_wall { 0.0 } else { rates.damping },
            damping_at_walls: if at_wall { rates.damping } else { 0.0 },
            eddy_viscosity: self.eddy_viscosity.get(row.row).map_or(0.0, |eddy| eddy.to_f64()),
        }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> BlockLoop<L::Real, D> for WcsphBlock<'_, '_, L, S, D> {
    type Summary = RatesSummary;

    #[inline(always)]
    fn sum_row<K: KernelShape>(
        &mut self,
        pack: &Pack<L::Real>,
        row: &FluidRow<L::Real, D>,
        of_cell: &mut RatesSummary,
    ) {
        if Self::BATCHED {
            self.sum_batched::<K>(pack, row);
        } else {
            *of_cell = of_cell.join(self.sum_one::<K>(pack, row));
        }
    }

    #[inline(always)]
    fn finish(&mut self, of_cells: RatesSummary) -> RatesSummary {
        let mut summary = of_cells;
        if Self::BATCHED {
            self.batch.finish(self.settings, &mut self.outputs);
            summary = self.batch.summary();
        }
        // The root of the largest square is the largest root: one root for the block.
        summary.acceleration = summary.acceleration.sqrt();
        summary.speed = summary.speed.sqrt();
        summary
    }
}
