//! Openings that a pressure drives: fluid may enter and leave, at once in parts of the section.
//!
//! - [`flow_share`]: a share of the prescribed inflow
//! - [`given_pressure`]: pressure that a scene gives in time
//! - [`prescribed_pressure`]: static pressure
//! - [`resistance`]: pressure in proportion to the flow
//! - [`time_function`]: a quantity that a scene gives in time
//! - [`total_pressure`]: stagnation pressure of a reservoir
//! - [`windkessel`]: three-element model of the vessels beyond an opening
//!
//! ```text
//! p_o = p_t(Q, t) + ρ0 c0 (v_o − U)        Q = A U
//! p_o + ρ0 c0 v_o = p̄ + ρ0 c0 v̄           outgoing wave
//! ```
//!
//! A condition is a law p_t of the flow Q through the opening. U is the mean velocity that the
//! nearly incompressible flow has there, known from the momentum of the whole domain, and v_o − U
//! is sound, which passes as into an endless pipe. So the pressure of a flow that accelerates is
//! the given one, and an acoustic wave is not reflected. p̄ and v̄ are means over the section of
//! the fluid next to the plane. Deviations along the section are oblique sound, see
//! [`oblique_waves`](super::non_reflecting::oblique_waves).
//!
//! The zone moves with the fluid next to it in both directions as under
//! [`wave_equation`](super::wave_equation), and each particle that enters the fluid is replaced at
//! the far end. A flow that enters does so along the normal, as in Zhang et al. (2024), Sec. 3.
//! The pressure gradient of the flow continues through the zone: a constant pressure there would
//! act a spacing inside the plane, 2.5 % of the length of a channel of 80 spacings.
//!
//! ```text
//! v_zone = v_fluid + (p_fluid − p_o)/(ρ0 c0) + e,   de/dt = (p̄ − p_o)/(ρ0 c0 τ)
//! ```
//!
//! The zone of [`convection`](super::convection) pushes fluid in if the pressure behind the plane
//! is too low. The fitted velocity of the fluid is right to some 0.4 %, and where fluid enters the
//! deficit would cost a pressure of 0.4 % of ρ0 c0 v̄, more than a friction loss. The speed e makes
//! the fluid at the plane have the pressure of the opening in the long run.

pub mod flow_share;
pub mod given_pressure;
pub mod prescribed_pressure;
pub mod resistance;
pub mod time_function;
pub mod total_pressure;
pub mod windkessel;

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::method::{Advanced, Needs, OutflowMotion, OutletMethod, OutletParameters, PlanePressure};
use super::non_reflecting::NonReflecting;
use super::non_reflecting::plane_waves::PlaneSetting;
use super::outflow_zone::{OutflowZone, settling_time};
use super::pressure::{OutletPressure, Waves};
use super::wave_equation::{WaveCondition, WaveMemory, ZoneRule, fit_fluid};
use crate::pass::fits::PointFlow;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;
use crate::physics::wave_sums::{ReferenceFrame, TransverseOperator};

/// Time over which the velocity without sound is corrected by the measured one, in times after
/// which sound has left the domain. A short one takes the start of a flow for a difference of both.
const CORRECTION: f64 = 5.0;

/// Lag of the rate of change of the pressure, in travel times of sound through the domain. The rate
/// corrects the flow, on which the pressure of a resistance depends in its turn.
const RATE_LAG: f64 = 2.0;

/// Acoustic waves at an opening of given pressure.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Acoustics {
    /// They leave as into an endless pipe. Take it unless the reservoir beyond is part of the
    /// problem.
    #[default]
    Transmitted,
    /// The pressure is held at every instant, so that they are reflected with the opposite sign.
    /// Take it for an opening into a reservoir whose reflections are studied.
    Reflected,
}

/// Law of the pressure at an opening.
pub trait PressureLaw: OutletParameters + Clone + 'static {
    /// State between steps.
    type State: Default + Serialize + DeserializeOwned + Send + Sync + 'static;

    /// Advances the state by a step and returns the pressure p_t, Pa.
    fn pressure(&self, opening: &OpeningFlow, state: &mut Self::State) -> f64;

    /// Returns the mean velocity U that the law prescribes, m/s; None if it follows the flow.
    fn velocity(&self, _opening: &OpeningFlow) -> Option<f64> {
        None
    }

    /// Returns the treatment of acoustic waves.
    fn acoustics(&self) -> Acoustics {
        Acoustics::Transmitted
    }

    /// Returns true if fluid enters from a reservoir at rest, whose static pressure it lacks.
    fn enters_from_rest(&self) -> bool {
        false
    }
}

/// Flow through an opening in a step; outflow counts positive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpeningFlow {
    /// Present value of the quantity that the scene gives in time; else 0.
    pub given: f64,
    /// Mean velocity U without sound, m/s.
    pub velocity: f64,
    /// Mean velocity v̄ + e at which the zone carries the fluid off, m/s.
    pub measured_velocity: f64,
    /// Area A, m² (m in 2D).
    pub area: f64,
    /// Volume flow that all inlets prescribe, m³/s (m²/s in 2D); None without inlets.
    pub total_inflow: Option<f64>,
    /// Acoustic impedance ρ0 c0, kg/(m² s).
    pub impedance: f64,
    /// Time after which sound has left the domain, s.
    pub settling_time: f64,
    /// Time step, s.
    pub time_step: f64,
}

impl OpeningFlow {
    /// Returns the volume flow Q = A U, m³/s (m²/s in 2D).
    pub fn rate(&self) -> f64 {
        self.area * self.velocity
    }
}

/// State of an opening between steps.
#[derive(Default, Serialize, Deserialize)]
#[serde(bound = "S: Serialize + DeserializeOwned", deny_unknown_fields)]
pub struct DrivenMemory<S> {
    /// State of the law.
    law: S,
    /// Waves at the plane and in the zone.
    wave: WaveMemory,
    /// Rate of change of the pressure p_t.
    rate: FollowedRate,
    /// Rate of change of p_t, and pressure of sound.
    plane: PlanePressure,
    /// Speed e of the zone in excess of the fitted velocity of the fluid, m/s.
    excess_speed: f64,
}

/// Rate of change of a pressure, smooth enough to be fed back.
///
/// ```text
/// T dp1/dt = p − p1,   r1 = (p − p1)/T,   T dr2/dt = r1 − r2,   r = 2 r1 − r2
/// ```
///
/// r1 lags behind the rate by T, and r2 by 2 T. Their difference takes the lag away: the error is
/// of second order in ω T, 9 % at ω T = 0.3, where r1 alone is 30 % off.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct FollowedRate {
    /// Pressure p1, Pa; None before the first step.
    pressure: Option<f64>,
    /// Rate r2, Pa/s.
    second: f64,
}

impl FollowedRate {
    /// Advances by a step (s) to a pressure (Pa) and returns the rate r, Pa/s, for the time T, s.
    fn advance(&mut self, pressure: f64, lag: f64, time_step: f64) -> f64 {
        let share = -(-time_step / lag).exp_m1();
        let followed = self.pressure.get_or_insert(pressure);
        let first = (pressure - *followed) / lag;
        *followed += share * (pressure - *followed);
        self.second += share * (first - self.second);
        2.0 * first - self.second
    }
}

/// Returns the motion of the zone.
fn wave() -> WaveCondition {
    WaveCondition {
        frame: ReferenceFrame::Moving,
        transverse: Some(TransverseOperator::default()),
        pressure: OutletPressure::default(),
    }
}

impl<L: PressureLaw> OutletMethod for L {
    type Memory = DrivenMemory<L::State>;

    fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut DrivenMemory<L::State>,
    ) {
        fit_fluid(zone, Some(&mut memory.wave.non_reflecting));
        let mean = memory.wave.non_reflecting.mean(zone);
        let Plane { pressure, dynamic, waves } = plane_pressure(self, zone, mean, memory);
        // The zone takes the dynamic pressure of inflow away again, at each point by itself.
        let base = zone.through_velocity.unwrap_or(0.0);
        memory.wave.non_reflecting.spread(zone, pressure + dynamic, base, waves);
        let compliance = zone.flow.impedance() * settling_time(zone.extent, zone.flow.sound_speed);
        memory.excess_speed += (mean.pressure - pressure) * zone.time_step / compliance;
        let rule = ZoneRule { excess_speed: memory.excess_speed, enters_from_rest: self.enters_from_rest() };
        wave().move_zone(zone, &mut memory.wave, rule);
    }

    fn find_rates<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut DrivenMemory<L::State>,
    ) {
        wave().find_rates(zone, &mut memory.wave);
    }

    fn plane_pressure(&self, memory: &DrivenMemory<L::State>) -> PlanePressure {
        memory.plane
    }

    fn advance(&self, particle: &OutflowMotion) -> Advanced {
        let mut advanced = wave().advance(particle);
        if advanced.speed < 0.0 {
            advanced.velocity = particle.normal * advanced.speed;
        }
        advanced
    }
}

/// Returns the mean over the section of the dynamic pressure of inflow, Pa.
fn dynamic_pressure<R: PairReal<D>, const D: usize>(
    zone: &OutflowZone<'_, R, D>,
    section: &NonReflecting,
) -> f64 {
    let points = &zone.fitted()[zone.rows.len()..];
    let of_point = |flow: &Option<PointFlow>| flow.map_or(0.0, |flow| flow.velocity.min(0.0).powi(2));
    0.5 * zone.flow.density * section.section_mean(points.iter().map(of_point))
}

/// Pressure at the plane in a step.
struct Plane {
    /// Mean pressure of the plane waves, Pa.
    pressure: f64,
    /// The part of it that inflow lacks in the mean, Pa.
    dynamic: f64,
    /// Waves added to it.
    waves: Waves,
}

/// Returns the pressure at the plane.
fn plane_pressure<L: PressureLaw, R: PairReal<D>, const D: usize>(
    law: &L,
    zone: &OutflowZone<'_, R, D>,
    mean: PointFlow,
    memory: &mut DrivenMemory<L::State>,
) -> Plane {
    let impedance = zone.flow.impedance();
    let section = &memory.wave.non_reflecting;
    let dynamic = if law.enters_from_rest() { dynamic_pressure(zone, section) } else { 0.0 };
    // What the zone carries off, as a law that prescribes it needs.
    let measured = mean.velocity + memory.excess_speed;
    let plane = &mut memory.wave.non_reflecting.plane;
    let through = zone.through_velocity.unwrap_or(0.0);
    let mut opening = OpeningFlow {
        given: zone.given,
        velocity: through + plane.mean_velocity.unwrap_or(mean.velocity - through),
        measured_velocity: measured,
        area: zone.patch.area,
        total_inflow: zone.total_inflow,
        impedance,
        settling_time: settling_time(zone.extent, zone.flow.sound_speed),
        time_step: zone.time_step,
    };
    let prescribed = law.velocity(&opening);
    opening.velocity = prescribed.unwrap_or(opening.velocity);
    let level = law.pressure(&opening, &mut memory.law);
    let target = level - dynamic;
    let lag = RATE_LAG * zone.extent / zone.flow.sound_speed;
    let rate = memory.rate.advance(target, lag, zone.time_step);
    let outgoing = mean.pressure + impedance * measured;
    let (pressure, waves) = match (law.acoustics(), prescribed) {
        (Acoustics::Reflected, _) => (target, Waves::Plane),
        (_, Some(velocity)) => (0.5 * (outgoing + target - impedance * velocity), Waves::All),
        _ => {
            let setting = PlaneSetting {
                target,
                time: CORRECTION * opening.settling_time,
                density: zone.flow.density,
                sound_speed: zone.flow.sound_speed,
            };
            let rest = mean.velocity - through;
            (plane.advance(&setting, mean.pressure, rest, zone.time_step), Waves::All)
        }
    };
    memory.plane = PlanePressure { rate, sound: pressure - target };
    Plane { pressure, dynamic, waves }
}

/// Returns the requirements of a law that follows the flow.
fn needs() -> Needs {
    Needs { is_bidirectional: true, uses_through_flow: true, ..Needs::default() }
}

/// Returns a fault unless a value, in `unit`, is finite and at least 0.
fn unless_not_negative(field: &'static str, value: f64, unit: &str) -> Option<ParameterFault> {
    let holds = value.is_finite() && value >= 0.0;
    ParameterFault::unless(holds, field, value, unit, "finite and not negative")
}

/// Returns an opening at a velocity U (m/s) of area 0.01 m², for tests.
#[cfg(test)]
fn opening_at(velocity: f64, given: f64) -> OpeningFlow {
    OpeningFlow {
        given,
        velocity,
        measured_velocity: velocity,
        area: 0.01,
        total_inflow: Some(4e-3),
        impedance: 1e4,
        settling_time: 0.1,
        time_step: 1e-3,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn followed_rate_has_no_lag_of_first_order() {
        let (lag, time_step, frequency) = (0.05, 1e-4, 6.0);
        let mut rate = FollowedRate::default();
        let (mut error, mut largest) = (0.0_f64, 0.0_f64);
        for step in 0..20_000 {
            let phase = frequency * f64::from(step) * time_step;
            let found = rate.advance(phase.sin(), lag, time_step);
            if phase > 6.0 {
                error = error.max((found - frequency * phase.cos()).abs());
                largest = largest.max(found.abs());
            }
        }
        // ω T = 0.3: 0.09/1.09 of the rate.
        assert!((error / frequency - 0.0826).abs() < 0.01, "error {}", error / frequency);
        assert!(largest < 1.1 * frequency, "{largest}");
    }

    #[test]
    fn followed_rate_starts_at_rest() {
        assert_eq!(FollowedRate::default().advance(40.0, 0.05, 1e-3), 0.0);
    }
}
