//! The zone of inflow particles that a condition works on in one stage of a step.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::math::grid::CellGrid;
use crate::particles::arrays::ParticleArrays;
use crate::particles::rows::set_real_vector;
use crate::pass::fits::{PointFit, PointFlow};
use crate::pass::pair_real::PairReal;
use crate::pass::points::PointFlows;
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;

/// Smallest number of inflow particles per thread, as a profile may be an expression.
const CHUNK: usize = 32;

/// Surface and motion that a scene prescribes for the inflow particles of an inlet or an emitter.
pub trait InflowMotion: Sync {
    /// Returns the velocity of a particle at the present time, m/s.
    fn velocity(&self, particle: InflowParticle) -> DVec3;

    /// Returns the point of the surface in front of a particle, m.
    fn foot(&self, particle: InflowParticle) -> DVec3;

    /// Returns the mirror image of a particle in the surface, m.
    fn mirrored(&self, particle: InflowParticle) -> DVec3;

    /// Returns the centre of the section, m.
    fn centre(&self) -> DVec3;

    /// Returns the body force at a point (m) at the present time, m/s².
    fn body_force(&self, point: DVec3) -> DVec3;

    /// Returns g − dv/dt + ν ∇²v of a particle at the present time, m/s²: ∇p/ρ0 of the prescribed
    /// motion.
    fn pressure_force(&self, particle: InflowParticle) -> DVec3;
}

/// Number and place of an inflow particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InflowParticle {
    /// Number.
    pub id: u32,
    /// Position, m.
    pub position: DVec3,
}

/// Inflow particles of one inlet or emitter, with the data that a condition may read and write.
pub struct InflowZone<'a, R: PairReal<D>, const D: usize> {
    /// Rows of the inflow particles in the arrays.
    pub rows: &'a [u32],
    /// Surface and prescribed motion of the particles.
    pub motion: &'a dyn InflowMotion,
    /// Initial particle spacing Δ, m.
    pub spacing: f64,
    /// Reference density ρ0, kg/m³.
    pub density: f64,
    /// Sound speed c0, m/s.
    pub sound_speed: f64,
    /// Size of the last time step, s.
    pub time_step: f64,
    /// True in the first step of a run, before which there are no pressures.
    pub is_first_step: bool,
    /// Settings of the pair sums.
    pub pair: &'a PairSettings,
    /// Cell grid by which the arrays are sorted.
    pub grid: &'a CellGrid<D>,
    /// Particles of the simulation.
    pub arrays: &'a mut ParticleArrays<R, D>,
    /// Pair sums of the simulation.
    pub sums: &'a mut PairSums<R, D>,
    /// Buffers, kept from step to step.
    pub buffers: &'a mut InflowBuffers<D>,
}

/// Buffers of inflow zones, kept from step to step so that steps allocate nothing.
#[derive(Default)]
pub struct InflowBuffers<const D: usize> {
    fits: PointFlows<D>,
    states: Vec<InflowState>,
}

/// State of an inflow particle in a step.
struct InflowState {
    /// Velocity, m/s.
    velocity: DVec3,
    /// Pressure, Pa.
    pressure: f64,
    /// Density that belongs to the pressure, kg/m³; None where it is summed.
    density: Option<f64>,
}

impl<R: PairReal<D>, const D: usize> InflowZone<'_, R, D> {
    /// Fits the pressure of the fluid at the mirror images of the inflow particles in the surface.
    pub fn fit_mirrored_pressure(&mut self) {
        let InflowBuffers { fits, .. } = &mut *self.buffers;
        fits.points.clear();
        fits.points.extend(self.rows.iter().map(|&row| {
            let mirrored = self.motion.mirrored(particle(self.arrays, row as usize));
            std::array::from_fn(|axis| mirrored[axis])
        }));
        fits.find(PointFit::Pressure, self.pair, self.grid, self.arrays, self.sums);
    }

    /// Sets velocity, pressure and density of all rows.
    ///
    /// `pressure` gives the pressure (Pa) from the fit of a row, its particle and its own pressure
    /// (Pa). The pressure of the particle follows it by `share`, and equals it in the
    /// first step and after the particle entered the zone.
    pub fn set(
        &mut self,
        share: f64,
        pressure: impl Fn(Option<PointFlow>, InflowParticle, f64) -> f64 + Sync,
    ) {
        let InflowBuffers { fits, states } = &mut *self.buffers;
        let (arrays, fitted, pair, motion) = (&*self.arrays, &fits.found, self.pair, self.motion);
        let is_first_step = self.is_first_step;
        let found = self.rows.par_iter().enumerate().with_min_len(CHUNK).map(|(index, &row)| {
            let row = row as usize;
            let (particle, own) = (particle(arrays, row), arrays.pressure[row].to_f64());
            let pressure = pressure(fitted.get(index).copied().flatten(), particle, own);
            let at_once = arrays.needs_restart[row] || is_first_step;
            let pressure = if at_once { pressure } else { own + share * (pressure - own) };
            InflowState { velocity: motion.velocity(particle), pressure, density: pair.density_at(pressure) }
        });
        found.collect_into_vec(states);
        for (&row, &InflowState { velocity, pressure, density }) in self.rows.iter().zip(&*states) {
            let row = row as usize;
            set_real_vector(&mut self.arrays.velocity, row, velocity);
            self.arrays.pressure[row] = R::from_f64(pressure);
            if let Some(density) = density {
                self.arrays.density[row] = R::from_f64(density);
            }
        }
    }
}

/// Returns number and position of a row.
fn particle<R: PairReal<D>, const D: usize>(arrays: &ParticleArrays<R, D>, row: usize) -> InflowParticle {
    InflowParticle { id: arrays.id[row], position: arrays.position_of(row) }
}
