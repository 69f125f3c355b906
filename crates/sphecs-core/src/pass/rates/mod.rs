//! Rates of the fluid: one fused pair loop for everything that the step needs.
//!
//! ```text
//! dv_a/dt = −(1/ρ_a) Σ V_b (p_a + p_b) ∇W + viscous term (+ damping of noise) (+ Σ m_b (T_a/ρ_a² + T_b/ρ_b²)·∇W)
//! ∇C_a    = Σ V_b ∇W,   ∇·v_a = Σ V_b (v_b − v_a)·∇W,   signal_a = max_b |h x_ab·v_ab/(r² + η²)|
//! or, for a shift that carries nothing: s_a − Σ V_b W_ab s_b / Σ V_b W_ab,   b: fluid, a itself included
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 10 and 18. The body force is the integrator's. Lengths in the loop are in
//! units of h, and the kernel without its norm: the dimensions come back once per row.

mod batch;
pub mod body;
mod ends;
mod layout;
mod row;
#[cfg(test)]
mod tests;

use std::marker::PhantomData;
use std::ops::Range;

use batch::{Batch, Columns, Taken};
use layout::{Fields, Layout};
use row::PairLoop;

use super::blocks::for_each_block;
use super::pack::{Near, Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// The largest of what the time step and the monitor ask for, over all fluid rows. A value that is not a number shows
/// as such.
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
    /// Largest rate at which the viscous term damps a particle among neighbours at rest, 1/s: of those with no wall in their support,
    /// where the pressure evolves of all.
    pub damping: f64,
    /// The same of those with a wall in their support, 1/s; 0 where the pressure evolves.
    pub damping_at_walls: f64,
}

/// The velocities that a pass looks at.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VelocityLevel {
    /// Those of the present time.
    Present,
    /// Those of one step earlier, which the dissipative terms of a leapfrog step need.
    Previous,
}

impl VelocityLevel {
    /// The columns of this level.
    pub fn columns<R: Real, const D: usize>(self, particles: &ParticleArrays<R, D>) -> &[Vec<R>; D] {
        match self {
            VelocityLevel::Present => &particles.velocity,
            VelocityLevel::Previous => &particles.previous_velocity,
        }
    }
}

impl RatesSummary {
    /// The larger of each, whatever the order.
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

/// The larger of two numbers, or the one that is none: `f64::max` would hide it.
pub(super) fn larger(a: f64, b: f64) -> f64 {
    if b > a || b.is_nan() { b } else { a }
}

/// Sums acceleration, shifting vector and divergence of the fluid rows over all rows.
pub fn sum_rates<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &mut PairSums<R, D>,
) -> RatesSummary {
    sums.packs.prepare();
    let has_walls = sums.columns.find_images(pair, particles);
    for column in sums.shift.iter_mut().chain([&mut sums.divergence]) {
        column.resize(particles.len(), R::default());
    }
    if !pair.shifting.keeps_drift() {
        sums.columns.find_fluid_volume(pair, particles);
    }
    sums.damping.resize(if has_walls { particles.len() } else { 0 }, R::default());
    let layout = Layout::new::<D>(pair, has_walls);
    pair.kernel.with_shape(RatesPass { pair, layout, grid, particles, level, sums })
}

struct RatesPass<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    layout: Layout,
    grid: &'a CellGrid<D>,
    particles: &'a mut ParticleArrays<R, D>,
    level: VelocityLevel,
    sums: &'a mut PairSums<R, D>,
}

impl<R: Real, const D: usize> WithShape for RatesPass<'_, R, D> {
    type Output = RatesSummary;

    fn run<K: KernelShape>(self) -> RatesSummary {
        let ParticleArrays {
            zone,
            position,
            velocity,
            previous_velocity,
            acceleration,
            density,
            pressure,
            wall_distance,
            wall_normal,
            ..
        } = self.particles;
        let PairSums {
            shift,
            divergence,
            damping,
            eddy_viscosity,
            strain,
            crowding,
            stress,
            velocity_seen,
            body_force,
            near,
            columns,
            packs,
            ..
        } = self.sums;
        let layout = self.layout;
        let velocity = match self.level {
            _ if layout.sees_dummies(self.pair) => &*velocity_seen,
            VelocityLevel::Present => &*velocity,
            VelocityLevel::Previous => &*previous_velocity,
        };
        let (neighbours, count) = layout.in_order(Fields {
            velocity,
            scalars: [&*density, &*pressure],
            strain,
            image_distance: &columns.image_distance,
            wall_normal,
            stress,
            crowding,
            fluid_volume: &columns.fluid_volume,
        });
        let source = Source {
            grid: self.grid,
            position,
            columns: &neighbours[..count],
            inverse_h: 1.0 / self.pair.smoothing_length,
            support_ratio: K::SUPPORT,
            only: Only::All,
        };
        let (body_force, near) = (&*body_force, &*near);
        let work = |cells: Range<usize>, outputs: Outputs<R, D>| {
            let block = RatesBlock::<K, R, D> {
                pair: self.pair,
                layout,
                source: &source,
                zone,
                wall_distance,
                body_force,
                eddy_viscosity,
                near,
                cells,
                outputs,
                pack: &mut packs.of_this_thread(),
                shape: PhantomData,
            };
            R::dispatch(self.pair.lanes, block)
        };
        let outputs = (
            acceleration.each_mut().map(Vec::as_mut_slice),
            shift.each_mut().map(Vec::as_mut_slice),
            [divergence.as_mut_slice(), damping.as_mut_slice()],
        );
        for_each_block(self.grid, outputs, &work, &RatesSummary::join)
    }
}

/// Acceleration, shifting vector, and divergence and damping rate of a block's rows.
type Outputs<'a, R, const D: usize> = ([&'a mut [R]; D], [&'a mut [R]; D], [&'a mut [R]; 2]);

struct RatesBlock<'a, K, R: Real, const D: usize> {
    pair: &'a PairSettings,
    layout: Layout,
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    wall_distance: &'a [R],
    body_force: &'a [Vec<R>; D],
    eddy_viscosity: &'a [R],
    near: &'a [Near],
    cells: Range<usize>,
    outputs: Outputs<'a, R, D>,
    pack: &'a mut Pack<R>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<R> for RatesBlock<'_, K, R, D> {
    type Output = RatesSummary;

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) -> RatesSummary {
        let pair_loop = PairLoop::<L, D>::new(self.pair, self.layout, self.body_force);
        let (damped, walls) = (pair_loop.is_damped(), pair_loop.has_walls());
        match (pair_loop.is_plain(), damped, walls, pair_loop.is_net()) {
            (true, false, false, false) => self.sweep::<L, true, false, false, false>(&pair_loop),
            (true, false, true, false) => self.sweep::<L, true, false, true, false>(&pair_loop),
            (true, true, false, false) => self.sweep::<L, true, true, false, false>(&pair_loop),
            (true, true, true, false) => self.sweep::<L, true, true, true, false>(&pair_loop),
            (true, true, true, true) => self.sweep::<L, true, true, true, true>(&pair_loop),
            _ => self.sweep::<L, false, false, false, false>(&pair_loop),
        }
    }
}

impl<K: KernelShape, R: Real, const D: usize> RatesBlock<'_, K, R, D> {
    /// All fluid rows of the block; `PLAIN`, `DAMPED`, `WALLS` and `NET` as the loop says.
    #[inline(always)]
    fn sweep<
        L: Lanes<Real = R>,
        const PLAIN: bool,
        const DAMPED: bool,
        const WALLS: bool,
        const NET: bool,
    >(
        self,
        pair_loop: &PairLoop<L, D>,
    ) -> RatesSummary {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let (mut acceleration, mut shift, [divergence, damping]) = self.outputs;
        let mut summary = RatesSummary::default();
        let mut batch = Batch::new();
        let mut columns =
            Columns { first, acceleration: &mut acceleration, shift: &mut shift, divergence, damping };
        for cell in self.cells {
            let rows = grid.rows(cell);
            if !self.pack.fill::<L, D>(self.source, cell, |row| self.zone[row] == Zone::Fluid) {
                continue;
            }
            let (pack, source) = (&*self.pack, self.source);
            // Of each cell apart: that of all is in memory, where to join at every row would cost a twentieth of the pass.
            let mut of_cell = RatesSummary::default();
            for row in rows {
                if self.zone[row] != Zone::Fluid {
                    continue;
                }
                let (point, distance) = (pack.relative(source, row), self.wall_distance[row].to_f64());
                let near = Near::of_row(self.near, row);
                // Most rows have no wall in their support, and need not ask each neighbour whether it is one.
                let at_wall = distance.is_finite();
                if PLAIN && !NET {
                    let sums = if WALLS && at_wall {
                        pair_loop.walk::<K, PLAIN, DAMPED, WALLS, NET, true, false>(
                            pack, source, point, row, near, distance,
                        )
                    } else {
                        pair_loop.walk::<K, PLAIN, DAMPED, WALLS, NET, false, false>(
                            pack, source, point, row, near, distance,
                        )
                    };
                    let velocity = std::array::from_fn(|d| source.columns[d][row]);
                    if batch.take(pair_loop, sums, Taken { row, velocity, at_wall }) {
                        batch.finish(pair_loop, &mut columns);
                    }
                    continue;
                }
                let rates = pair_loop
                    .sum::<K, PLAIN, DAMPED, WALLS, NET, false>(pack, source, point, row, near, distance);
                let mut square = 0.0;
                let mut speed = 0.0;
                for d in 0..D {
                    columns.acceleration[d][row - first] = R::from_f64(rates.acceleration[d]);
                    columns.shift[d][row - first] = R::from_f64(rates.shift[d]);
                    square += rates.acceleration[d] * rates.acceleration[d];
                    let v = source.columns[d][row].to_f64();
                    speed += v * v;
                }
                columns.divergence[row - first] = R::from_f64(rates.divergence);
                if let Some(damping) = columns.damping.get_mut(row - first) {
                    *damping = R::from_f64(rates.damping);
                }
                of_cell = of_cell.join(RatesSummary {
                    acceleration: square,
                    signal_speed: rates.signal_speed,
                    speed,
                    divergence: rates.divergence.abs(),
                    damping: if at_wall { 0.0 } else { rates.damping },
                    damping_at_walls: if at_wall { rates.damping } else { 0.0 },
                    eddy_viscosity: self.eddy_viscosity.get(row).map_or(0.0, |eddy| eddy.to_f64()),
                });
            }
            if !PLAIN || NET {
                summary = summary.join(of_cell);
            }
        }
        if PLAIN && !NET {
            batch.finish(pair_loop, &mut columns);
            summary = batch.summary();
        }
        // The root of the largest square is the largest root: one root a block.
        summary.acceleration = summary.acceleration.sqrt();
        summary.speed = summary.speed.sqrt();
        summary
    }
}
