//! The zone of outflow particles that a condition works on in one stage of a step.

use glam::DVec3;

use super::method::OutflowState;
use super::non_reflecting::prescribed_flow::Inflow;
use crate::boundary::flow::FlowProperties;
use crate::boundary::patch::Patch;
use crate::math::grid::CellGrid;
use crate::particles::arrays::ParticleArrays;
use crate::particles::rows::set_real_vector;
use crate::pass::fits::{PointFit, PointFlow};
use crate::pass::pair_real::PairReal;
use crate::pass::points::PointFlows;
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;

/// Travel times of sound through the domain, along the normal of the outlet, after which
/// transmitted acoustic waves have left. A shorter time hardly damps the resonance of an inlet with
/// a throat; a longer one prolongs the start-up.
const SETTLING_PASSAGES: f64 = 4.0;

/// Returns the time after which acoustic waves have left a domain of this extent (m), s.
pub fn settling_time(extent: f64, sound_speed: f64) -> f64 {
    SETTLING_PASSAGES * extent / sound_speed
}

/// Outflow particles of one outlet, with the data that a condition may read and write.
pub struct OutflowZone<'a, R: PairReal<D>, const D: usize> {
    /// Properties of the flow and of the domain.
    pub flow: FlowProperties<'a>,
    /// Opening of the outlet.
    pub patch: &'a Patch,
    /// Extent of the domain along the outlet's normal, m.
    pub extent: f64,
    /// Slow part of the volume flow that all inlets prescribe; None without inlets.
    pub prescribed: Option<Inflow>,
    /// True if pressures are less what balances a body force or carries the flow, so that they do
    /// not fall towards the plane by friction.
    pub is_balanced: bool,
    /// Area of the outlet over that of all outlets.
    pub area_share: f64,
    /// Volume flow that all inlets prescribe at the present time, m³/s (m²/s in 2D); None without
    /// inlets.
    pub total_inflow: Option<f64>,
    /// Mean velocity through the section that the flow of the whole domain has without sound, m/s;
    /// None if the condition does not use it.
    pub through_velocity: Option<f64>,
    /// Present value of the quantity that the scene gives as a function of time; else 0.
    pub given: f64,
    /// Rows of the outflow particles in the arrays.
    pub rows: &'a [u32],
    /// Rows of the fluid upstream that the condition requested in its
    /// [`Needs`](super::method::Needs), else empty.
    pub upstream: &'a [u32],
    /// Mean speed of the inflow particles, m/s; None without any, or if the condition does not use
    /// it.
    pub inflow_speed: Option<f64>,
    /// Mean normal velocity and pressure of the fluid in the last layers upstream of the plane.
    pub adjacent: PointFlow,
    /// Size of the last time step, s.
    pub time_step: f64,
    /// True in the first step of a run, when the zones are a lattice of the reference density.
    pub is_first_step: bool,
    /// Settings of the pair sums.
    pub pair: &'a PairSettings,
    /// Cell grid by which the arrays are sorted.
    pub grid: &'a CellGrid<D>,
    /// Particles of the simulation.
    pub arrays: &'a mut ParticleArrays<R, D>,
    /// Pair sums of the simulation.
    pub sums: &'a mut PairSums<R, D>,
    /// Buffers of the fits, kept from step to step.
    pub buffers: &'a mut ZoneBuffers<R, D>,
    /// Speeds along the normal at which the particles move, m/s, in the order of `rows`.
    pub speeds: &'a mut Vec<f64>,
}

/// Buffers of the fits in outflow zones, kept from step to step so that steps allocate nothing.
#[derive(Default)]
pub struct ZoneBuffers<R: PairReal<D>, const D: usize> {
    fits: PointFlows<D>,
    column: Vec<R>,
}

impl<R: PairReal<D>, const D: usize> OutflowZone<'_, R, D> {
    /// Returns the unit normal of the outlet, in the direction of the outflow.
    pub fn normal(&self) -> DVec3 {
        self.patch.towards
    }

    /// Returns the position of a row, m.
    pub fn position(&self, row: usize) -> DVec3 {
        self.arrays.position_of(row)
    }

    /// Returns velocity (m/s) and pressure (Pa) of a row.
    pub fn state(&self, row: usize) -> (DVec3, f64) {
        (self.arrays.velocity_of(row), self.arrays.pressure[row].to_f64())
    }

    /// Fits the fluid at the moved positions of the outflow particles and then at `others`, m. The
    /// results are read by [`fitted`](Self::fitted).
    pub fn fit_fluid(
        &mut self,
        fit: PointFit,
        moved: impl Fn(DVec3) -> DVec3,
        others: impl Iterator<Item = DVec3>,
    ) {
        let (rows, fits) = (self.rows, &mut self.buffers.fits);
        let points = rows.iter().map(|&row| moved(self.arrays.position_of(row as usize))).chain(others);
        fits.points.clear();
        fits.points.extend(points.map(|point| std::array::from_fn(|axis| point[axis])));
        fits.find(fit, self.pair, self.grid, self.arrays, self.sums);
    }

    /// Finds kernel means over the fluid, at the outflow particles, of values given by row; other
    /// rows count as 0. The results are the pressures of [`fitted`](Self::fitted).
    pub fn fit_mean(&mut self, values: impl Iterator<Item = (usize, f64)>) {
        let ZoneBuffers { fits, column } = &mut *self.buffers;
        column.clear();
        column.resize(self.arrays.len(), R::default());
        for (row, value) in values {
            column[row] = R::from_f64(value);
        }
        fits.points.clear();
        fits.points.extend(self.rows.iter().map(|&row| {
            let point = self.arrays.position_of(row as usize);
            std::array::from_fn(|axis| point[axis])
        }));
        fits.find_mean(column, self.pair, self.grid, self.arrays, self.sums);
    }

    /// Returns the results of the last fit, by point; None where no fluid is near.
    pub fn fitted(&self) -> &[Option<PointFlow>] {
        &self.buffers.fits.found
    }

    /// Returns the mean of a value over the results of the last fit; None where there is no fluid
    /// at all.
    pub fn mean_fitted(&self, value: impl Fn(&PointFlow) -> f64) -> Option<f64> {
        let (mut sum, mut count) = (0.0, 0);
        for flow in self.fitted().iter().flatten() {
            sum += value(flow);
            count += 1;
        }
        (count > 0).then(|| sum / f64::from(count))
    }

    /// Sets velocity, pressure and speed of a row; its density follows where the scheme has an
    /// equation of state.
    pub fn set(&mut self, row: usize, state: OutflowState) {
        self.arrays.pressure[row] = R::from_f64(state.pressure);
        if let Some(density) = self.pair.density_at(state.pressure) {
            self.set_density(row, density);
        }
        set_real_vector(&mut self.arrays.velocity, row, state.velocity);
        self.speeds.push(state.speed);
    }

    /// Sets the density of a row, kg/m³, and in the first step the distance from the plane that
    /// belongs to it.
    ///
    /// Rows whose distance does not belong to their density count too few neighbours for fluid that
    /// enters. Later it need not follow: fluid that leaves has the distance of its density, and
    /// rows that follow a pulsating pressure push fluid through the plane and back.
    pub fn set_density(&mut self, row: usize, density: f64) {
        self.arrays.density[row] = R::from_f64(density);
        if self.is_first_step {
            let along = self.patch.along(self.arrays.position_of(row));
            let way = self.patch.towards * (along * (self.flow.density / density - 1.0));
            for (axis, way) in way.to_array().into_iter().enumerate().take(D) {
                self.arrays.position[axis][row] += way;
            }
        }
    }

    /// Sets acceleration and shifting vector of all rows to 0.
    pub fn clear_rates(&mut self) {
        for &row in self.rows {
            set_real_vector(&mut self.arrays.acceleration, row as usize, DVec3::ZERO);
            self.sums.set_outflow_shift(row as usize, DVec3::ZERO);
        }
    }
}
