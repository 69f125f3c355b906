//! Outgoing wave equation with transverse diffusion.
//!
//! ```text
//! ∂v/∂t + v_n ∂v/∂n − ν ∇²_t v = f          with the body force f
//! ∂v/∂n |_o = Σ V_b (v_b − v_o) ∂W/∂n       first term of Eq. 29
//! v̄_n,o    = Σ V_b v_n,b W / Σ V_b W        Eq. 30, normalised where the far end cuts the support
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eqs. 27, 29 and 30; the pair sums and the forms of ∇²_t are in
//! [`wave_sums`](crate::physics::wave_sums).
//!
//! `frame: Fixed` integrates the rate of a fixed point along the moving particle, as published:
//! dv/dt = −v̄_n ∂v/∂n + ν L v + f. `frame: Moving` takes the equation literally. As the particle
//! moves with the convective velocity, the convective term vanishes, dv/dt = ν L v + f: Negi et al.
//! (2020), Sec. 3.1, remark.
//!
//! A particle moves along the normal with the velocity v̄_n of [`convection`](super::convection),
//! from a fit that preserves the velocity profile where Eq. 30 takes a kernel mean. Its pressure is
//! that of [`pressure`](super::pressure). Backflow is drawn in from a reservoir at rest.
//!
//! Columns of particles that slide past each other bring particles close together, and a vortex
//! carries such pairs back into the fluid, whose density changes at once. So the zone is shifted as
//! the fluid is.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};
use serde::{Deserialize, Serialize};

use super::convection::{backflow_pressure, convective_velocity};
use super::method::{Advanced, OutflowMotion, OutletMethod, OutletParameters, References};
use super::non_reflecting::NonReflecting;
use super::outflow_zone::OutflowZone;
use super::pressure::OutletPressure;
use crate::math::lattice::ETA_SQUARED;
use crate::particles::rows::set_real_vector;
use crate::pass::fits::PointFit;
use crate::pass::pair_real::PairReal;
use crate::pass::waves::WaveFound;
use crate::physics::parameter_fault::ParameterFault;
use crate::physics::wave_sums::{ReferenceFrame, TransverseOperator, WaveSetting};

/// Smallest number of outflow particles per thread.
const CHUNK: usize = 64;

/// Layers inside the plane at which the fluid is sampled; closer to it, half of the kernel would
/// have no fluid.
const LAYERS_INSIDE: f64 = 1.0;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct WaveEquation {
    /// Frame in which ∂v/∂t is integrated.
    #[serde(default)]
    pub frame: ReferenceFrame,
    /// Form of the transverse Laplacian.
    #[serde(default)]
    pub transverse: TransverseOperator,
    /// Pressure of the outflow particles.
    #[serde(default)]
    pub pressure: OutletPressure,
}

/// State of a wave equation between steps.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct WaveMemory {
    /// State of a nonreflecting pressure.
    pub non_reflecting: NonReflecting,
    /// Buffer: results of a step by outflow particle.
    #[serde(skip)]
    moves: Vec<ZoneMove>,
    /// Buffer: pair sums by outflow particle.
    #[serde(skip)]
    sums: Vec<WaveFound>,
}

/// Results of a step for an outflow particle.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ZoneMove {
    /// Pressure, Pa.
    pressure: f64,
    /// Convective velocity, m/s.
    velocity: f64,
    /// Density that belongs to the pressure, kg/m³; None where it is summed.
    density: Option<f64>,
}

/// Motion of the zone beside that of the fluid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZoneRule {
    /// Speed in excess of that of the fluid, m/s.
    pub excess_speed: f64,
    /// True if backflow comes from a reservoir at rest, whose static pressure it lacks.
    pub enters_from_rest: bool,
}

/// Parameters of an outgoing wave equation, with or without diffusion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WaveCondition {
    /// Frame in which ∂v/∂t is integrated.
    pub frame: ReferenceFrame,
    /// Form of the transverse Laplacian; None drops the diffusion.
    pub transverse: Option<TransverseOperator>,
    /// Pressure of the outflow particles.
    pub pressure: OutletPressure,
}

impl WaveEquation {
    fn wave(&self) -> WaveCondition {
        WaveCondition { frame: self.frame, transverse: Some(self.transverse), pressure: self.pressure }
    }
}

impl OutletParameters for WaveEquation {
    fn name(&self) -> &str {
        "WaveEquation"
    }

    fn references(&self) -> References {
        self.wave().references()
    }

    fn faults(&self) -> Vec<ParameterFault> {
        self.pressure.faults()
    }
}

impl OutletMethod for WaveEquation {
    type Memory = WaveMemory;

    fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut WaveMemory,
    ) {
        self.wave().apply(zone, memory);
    }

    fn find_rates<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut WaveMemory,
    ) {
        self.wave().find_rates(zone, memory);
    }

    fn advance(&self, particle: &OutflowMotion) -> Advanced {
        self.wave().advance(particle)
    }
}

impl WaveCondition {
    /// Returns the stated pressure of the surroundings.
    pub fn references(&self) -> References {
        References { velocity: 0.0, pressure: self.pressure.target() }
    }

    /// Sets pressure and density of the outflow particles and finds their convective velocities.
    pub fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut WaveMemory,
    ) {
        self.pressure.set(zone);
        if let OutletPressure::NonReflecting { target, time, waves } = self.pressure {
            fit_fluid(zone, Some(&mut memory.non_reflecting));
            memory.non_reflecting.advance(zone, target, time, waves);
        } else {
            fit_fluid(zone, None);
        }
        let rule = ZoneRule { excess_speed: 0.0, enters_from_rest: self.pressure.is_set_each_step() };
        self.move_zone(zone, memory, rule);
    }

    /// Sets the outflow particles from the fitted fluid and the pressure of the plane.
    pub fn move_zone<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut WaveMemory,
        rule: ZoneRule,
    ) {
        let mut moves = std::mem::take(&mut memory.moves);
        self.find_moves(zone, &memory.non_reflecting, rule, &mut moves);
        let normal = zone.normal();
        for (&row, &ZoneMove { pressure, velocity, density }) in zone.rows.iter().zip(&moves) {
            let row = row as usize;
            zone.arrays.pressure[row] = R::from_f64(pressure);
            zone.speeds.push(velocity);
            if let Some(density) = density {
                zone.set_density(row, density);
            } else if self.frame == ReferenceFrame::Moving {
                // The divergence drives an evolved pressure. With the velocity of the crossing
                // instead of that with which the zone moves, the outlet would reflect a quarter of
                // an acoustic pulse.
                let own = zone.arrays.velocity_of(row);
                let moved = own + normal * (velocity - own.dot(normal));
                set_real_vector(&mut zone.arrays.velocity, row, moved);
            }
        }
        memory.moves = moves;
    }

    /// Finds pressure, convective velocity and density of the outflow particles.
    fn find_moves<R: PairReal<D>, const D: usize>(
        &self,
        zone: &OutflowZone<'_, R, D>,
        non_reflecting: &NonReflecting,
        rule: ZoneRule,
        moves: &mut Vec<ZoneMove>,
    ) {
        let (flow, patch, mean, impedance) = (zone.flow, zone.patch, zone.adjacent, zone.flow.impedance());
        let (arrays, found, pair) = (&*zone.arrays, zone.fitted(), zone.pair);
        let transmits = matches!(self.pressure, OutletPressure::NonReflecting { .. });
        let all = zone.rows.par_iter().enumerate().with_min_len(CHUNK).map(|(at, &row)| {
            let row = row as usize;
            let fluid = found[at].unwrap_or(mean);
            let own = arrays.pressure[row].to_f64();
            let (pressure, velocity) = if transmits {
                non_reflecting.at(&flow, patch, arrays.position_of(row), fluid)
            } else {
                (own, convective_velocity(fluid.velocity, fluid.pressure, own, impedance))
            };
            let velocity = velocity + rule.excess_speed;
            let pressure = if rule.enters_from_rest {
                backflow_pressure(pressure, velocity, flow.density)
            } else {
                pressure
            };
            ZoneMove { pressure, velocity, density: pair.density_at(pressure) }
        });
        all.collect_into_vec(moves);
    }

    /// Finds the rates of the outflow particles and their shifting vectors.
    pub fn find_rates<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut WaveMemory,
    ) {
        let setting = WaveSetting {
            frame: self.frame,
            transverse: self.transverse,
            normal: zone.normal(),
            dimensions: zone.flow.dimensions,
            eta_squared: ETA_SQUARED,
            viscosity: zone.flow.viscosity,
        };
        R::sum_waves(&setting, zone.pair, zone.grid, zone.arrays, zone.sums, zone.rows, &mut memory.sums);
        let mut friction = 0.0;
        for (&row, wave) in zone.rows.iter().zip(&memory.sums) {
            let row = row as usize;
            let rate = wave.sums.rate(&setting);
            friction += rate.dot(setting.normal);
            set_real_vector(&mut zone.arrays.acceleration, row, rate);
            let mut concentration = wave.concentration;
            // The support is empty beyond the far end, so the normal part would empty the zone.
            if zone.patch.along(zone.arrays.position_of(row))
                > zone.patch.depth - zone.pair.discretisation.support
            {
                concentration -= setting.normal * concentration.dot(setting.normal);
            }
            zone.sums.set_outflow_shift(row, concentration);
        }
        memory.non_reflecting.friction = friction / zone.rows.len().max(1) as f64;
    }

    /// Advances an outflow particle: in the moving frame at its convective velocity, in the fixed
    /// frame at its own, never backwards.
    pub fn advance(&self, particle: &OutflowMotion) -> Advanced {
        let mut next = particle.accelerated();
        let speed = match self.frame {
            ReferenceFrame::Moving => {
                if particle.speed < 0.0 {
                    // Backflow has the velocity with which it is drawn in, not that of its
                    // crossing.
                    next += particle.normal * (particle.speed - next.dot(particle.normal));
                }
                particle.speed
            }
            ReferenceFrame::Fixed => {
                next -= particle.normal * next.dot(particle.normal).min(0.0);
                0.5 * (particle.velocity + next).dot(particle.normal)
            }
        };
        Advanced { velocity: next, speed }
    }
}

/// Fits the fluid a layer inside the feet of the outflow particles and, for a nonreflecting
/// pressure, at the points of the section.
pub fn fit_fluid<R: PairReal<D>, const D: usize>(
    zone: &mut OutflowZone<'_, R, D>,
    non_reflecting: Option<&mut NonReflecting>,
) {
    let (flow, patch, normal) = (zone.flow, zone.patch, zone.normal());
    let inside = |foot: DVec3| foot - normal * (LAYERS_INSIDE * flow.spacing);
    let offsets = non_reflecting.map_or(&[][..], |state| state.section(&flow, patch).offsets.as_slice());
    zone.fit_fluid(
        PointFit::Section { normal, across: patch.across },
        |point| inside(point - normal * patch.along(point)),
        offsets.iter().map(|&offset| inside(patch.at + offset)),
    );
}

#[cfg(test)]
mod tests {
    use super::*;

    const BACKFLOW: OutflowMotion = OutflowMotion {
        velocity: DVec3::new(0.2, 0.1, 0.0),
        acceleration: DVec3::new(-3.0, 1.0, 0.0),
        speed: -0.05,
        normal: DVec3::X,
        time_step: 0.1,
    };

    #[test]
    fn backflow_is_drawn_in_at_the_convective_velocity_in_the_moving_frame() {
        let advanced = WaveEquation::default().advance(&BACKFLOW);
        assert_eq!(advanced.speed, -0.05);
        assert!((advanced.velocity - DVec3::new(-0.05, 0.2, 0.0)).length() < 1e-15, "{advanced:?}");
    }

    #[test]
    fn no_particle_returns_in_the_fixed_frame() {
        let fixed = WaveEquation { frame: ReferenceFrame::Fixed, ..WaveEquation::default() };
        let advanced = fixed.advance(&BACKFLOW);
        assert!((advanced.velocity - DVec3::new(0.0, 0.2, 0.0)).length() < 1e-15, "{advanced:?}");
        assert!((advanced.speed - 0.1).abs() < 1e-15, "the mean of both ends, {}", advanced.speed);
    }
}
