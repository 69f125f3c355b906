//! Frozen base flow with acoustic waves transmitted by their outgoing characteristic.
//!
//! ```text
//! f̄ ← f̄ + 2/(N+1) (f − f̄)   f = v_n, p of a fluid particle, only while |p − p_ref| < ½ ρ0 u²
//! J2 = ρ0 c0 (v_n − v̄_n) + (p − p̄)         over the fluid, Σ V_b J2,b W_ob / Σ V_b W_ob
//! v_o = v̄_n,o + J2/(2 ρ0 c0),   p_o = p̄_o + J2/2,   v̄_o, p̄_o those of the crossing
//! ```
//!
//! Negi et al. (2020), Eqs. 28–31. Their mean is over the last N steps, with N about the number of
//! steps in which sound travels one spacing (4 by Eq. 29; they take 6). Here it is the recursive
//! mean of the same mean age, (N − 1)/2 steps, which needs one value per particle instead of N. The
//! threshold is one of acoustic intensity, p²/(2 ρ c), Eq. 30, relative to a reference pressure
//! p_ref of the scene. Without it the mean pressure of a duct would count as sound. Tangential
//! velocities are not averaged.
//!
//! Only fluid within reach of the outlet has means. A particle that comes within reach gets the
//! mean acoustic part of the particles there. So a flow that is never below the threshold, such as
//! one that starts at once, keeps its initial base flow. Particles of the zone without fluid in
//! their support take the mean J2 of the others, in the same step. The authors switch the sound off
//! for twenty steps at the start; this is not needed here, since the first mean is the flow itself.
//!
//! A pressure that remains below the threshold becomes base flow. So the weak tail of a strong
//! pulse becomes a permanent offset.

use serde::{Deserialize, Serialize};

use super::method::{Needs, OutletMethod, OutletParameters, References};
use super::outflow_zone::OutflowZone;
use crate::particles::arrays::ParticleArrays;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// Length beyond the support, in spacings, over which the condition averages the fluid, so that the
/// mean of a crossing particle has settled.
const AVERAGED_LAYERS: f64 = 3.0;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Hybrid {
    /// Velocity u of the threshold, m/s, default the mean inflow speed, averaged over `steps`. A
    /// particle's flow counts as sound while |p − `pressure`| ≥ ½ ρ0 u².
    #[serde(default)]
    pub velocity: Option<f64>,
    /// Reference pressure about which sound oscillates, Pa, default 0.
    #[serde(default)]
    pub pressure: f64,
    /// Number N of steps of the time mean that is the base flow, dimensionless, default 6.
    #[serde(default = "default_steps")]
    pub steps: f64,
}

/// N of Negi et al. (2020), Sec. 3.4.
fn default_steps() -> f64 {
    6.0
}

/// State of the condition between steps.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HybridMemory {
    /// Means of the particles within reach and in the zone, by rising particle id.
    pub averages: Vec<(u32, Average)>,
    /// Time mean of the inflow speed, m/s; None before the first step.
    pub inflow_speed: Option<f64>,
    /// Means of the present step: first of the rows within reach, then of those in the zone.
    #[serde(skip)]
    present: Vec<(u32, Average)>,
    /// J2 of the rows within reach, Pa.
    #[serde(skip)]
    outgoing: Vec<f64>,
    /// True for entries of `present` that had a mean in the step before.
    #[serde(skip)]
    known: Vec<bool>,
}

impl HybridMemory {
    /// Returns the mean that a particle had in the step before.
    fn average(&self, id: u32) -> Option<Average> {
        let at = self.averages.binary_search_by_key(&id, |(id, _)| *id).ok()?;
        Some(self.averages[at].1)
    }
}

impl OutletParameters for Hybrid {
    fn name(&self) -> &str {
        "Hybrid"
    }

    fn needs(&self) -> Needs {
        Needs {
            upstream_layers: Some(AVERAGED_LAYERS),
            is_one_way: true,
            uses_inflow_speed: true,
            ..Needs::default()
        }
    }

    fn references(&self) -> References {
        References { velocity: self.velocity.unwrap_or(0.0), pressure: self.pressure }
    }

    fn faults(&self) -> Vec<ParameterFault> {
        let velocity =
            self.velocity.and_then(|velocity| ParameterFault::unless_positive("velocity", velocity, "m/s"));
        let pressure = ParameterFault::unless_finite("pressure", self.pressure, "Pa");
        let is_long_enough = self.steps.is_finite() && self.steps >= 1.0;
        let steps = ParameterFault::unless(is_long_enough, "steps", self.steps, "", "finite and at least 1");
        velocity.into_iter().chain(pressure).chain(steps).collect()
    }
}

impl OutletMethod for Hybrid {
    type Memory = HybridMemory;

    fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut HybridMemory,
    ) {
        self.average_upstream(zone, memory);
        let (normal, impedance) = (zone.normal(), zone.flow.impedance());
        let upstream = zone.upstream.iter().map(|&row| row as usize);
        zone.fit_mean(upstream.zip(memory.outgoing.iter().copied()));
        let others = zone.mean_fitted(|mean| mean.pressure).unwrap_or(0.0);
        for (at, &row) in zone.rows.iter().enumerate() {
            let row = row as usize;
            let (own, pressure) = zone.state(row);
            let id = zone.arrays.id[row];
            let base = memory.average(id).unwrap_or(Average { velocity: own.dot(normal), pressure });
            let outgoing = zone.fitted()[at].map_or(others, |mean| mean.pressure);
            let state = base.references().outflow(own, outgoing, impedance, normal);
            memory.present.push((id, base));
            zone.set(row, state);
        }
        // Ids are unique, so that the order does not depend on the sort.
        memory.present.sort_unstable_by_key(|(id, _)| *id);
        std::mem::swap(&mut memory.averages, &mut memory.present);
    }
}

impl Hybrid {
    /// Updates the means of the fluid within reach and finds its J2.
    fn average_upstream<R: PairReal<D>, const D: usize>(
        &self,
        zone: &OutflowZone<'_, R, D>,
        memory: &mut HybridMemory,
    ) {
        let (normal, impedance, density) = (zone.normal(), zone.flow.impedance(), zone.flow.density);
        let share = share(self.steps);
        let followed = inflow_speed(zone, share, memory);
        let threshold = self.velocity.unwrap_or(followed);
        let normal_flow = |row: usize, arrays: &ParticleArrays<R, D>| {
            (arrays.velocity_of(row).dot(normal), arrays.pressure[row].to_f64())
        };
        memory.present.clear();
        memory.known.clear();
        let (mut sound, mut count) = (0.0, 0.0);
        for &row in zone.upstream {
            let row = row as usize;
            let (v, p) = normal_flow(row, zone.arrays);
            let id = zone.arrays.id[row];
            let before = memory.average(id);
            let mut average = before.unwrap_or_default();
            if before.is_some() {
                if !is_sound(p - self.pressure, density, threshold) {
                    average.follow(v, p, share);
                }
                sound += average.references().outgoing(v, p, impedance);
                count += 1.0;
            }
            memory.known.push(before.is_some());
            memory.present.push((id, average));
        }
        let sound = if count > 0.0 { sound / count } else { 0.0 };
        memory.outgoing.clear();
        for (at, &row) in zone.upstream.iter().enumerate() {
            let (v, p) = normal_flow(row as usize, zone.arrays);
            if !memory.known[at] {
                memory.present[at].1 = Average::without_sound(v, p, sound, impedance);
            }
            memory.outgoing.push(memory.present[at].1.references().outgoing(v, p, impedance));
        }
    }
}

/// Returns the speed of the threshold, m/s: the time mean of the inflow speed, or of the scene's
/// reference velocity if nothing flows in.
fn inflow_speed<R: PairReal<D>, const D: usize>(
    zone: &OutflowZone<'_, R, D>,
    share: f64,
    memory: &mut HybridMemory,
) -> f64 {
    let present = zone.inflow_speed.unwrap_or(zone.flow.reference_velocity);
    let before = memory.inflow_speed.unwrap_or(present);
    let followed = before + share * (present - before);
    memory.inflow_speed = Some(followed);
    followed
}

/// Time mean of a particle's flow: its base flow without sound.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Average {
    /// Normal velocity v̄_n, m/s.
    pub velocity: f64,
    /// Pressure p̄, Pa.
    pub pressure: f64,
}

/// Returns the weight of the present value in a recursive mean over `steps`.
pub fn share(steps: f64) -> f64 {
    2.0 / (steps + 1.0)
}

/// Returns true if a pressure (Pa, less the reference pressure) counts as sound: it is at least ½
/// ρ0 u², density in kg/m³, velocity in m/s.
pub fn is_sound(pressure: f64, density: f64, velocity: f64) -> bool {
    pressure.abs() >= 0.5 * density * velocity * velocity
}

impl Average {
    /// Returns the references of the characteristics about this mean.
    pub fn references(&self) -> References {
        References { velocity: self.velocity, pressure: self.pressure }
    }

    /// Adds a normal velocity (m/s) and a pressure (Pa) to the mean, with the weight of a
    /// [`share`].
    pub fn follow(&mut self, velocity: f64, pressure: f64, share: f64) {
        self.velocity += share * (velocity - self.velocity);
        self.pressure += share * (pressure - self.pressure);
    }

    /// Returns the mean of a flow with a normal velocity (m/s) and a pressure (Pa) that contain an
    /// outgoing wave J2 (Pa).
    pub fn without_sound(velocity: f64, pressure: f64, outgoing: f64, impedance: f64) -> Self {
        Self { velocity: velocity - 0.5 * outgoing / impedance, pressure: pressure - 0.5 * outgoing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_recursive_mean_has_the_age_of_the_mean_over_steps() {
        // On a ramp of one per step the mean of the last six lags by 2.5.
        let mut average = Average::default();
        for step in 0..200 {
            average.follow(f64::from(step), 2.0 * f64::from(step), share(6.0));
        }
        assert!((199.0 - average.velocity - 2.5).abs() < 1e-9, "{average:?}");
        assert!((398.0 - average.pressure - 5.0).abs() < 1e-9, "{average:?}");
    }

    #[test]
    fn the_threshold_is_the_dynamic_pressure() {
        assert!(is_sound(500.0, 1000.0, 1.0) && is_sound(-501.0, 1000.0, 1.0));
        assert!(!is_sound(499.0, 1000.0, 1.0) && !is_sound(-499.0, 1000.0, 1.0));
        assert!(is_sound(0.0, 1000.0, 0.0), "every oscillation about rest is sound");
    }

    #[test]
    fn a_wave_on_a_base_flow_is_transmitted() {
        let base = Average { velocity: 0.7, pressure: -40.0 };
        let (velocity, pressure) = (0.7 + 0.02, -40.0 + 200.0);
        let outgoing = base.references().outgoing(velocity, pressure, 1e4);
        let (v, p) = base.references().at(outgoing, 1e4);
        assert!((v - velocity).abs() < 1e-14 && (p - pressure).abs() < 1e-11, "{v} {p}");
        let found = Average::without_sound(velocity, pressure, outgoing, 1e4);
        assert!((found.velocity - 0.7).abs() < 1e-14 && (found.pressure + 40.0).abs() < 1e-11, "{found:?}");
    }

    #[test]
    fn parameters_out_of_range_are_all_named() {
        let hybrid = Hybrid { velocity: Some(-1.0), pressure: f64::NAN, steps: 0.0 };
        let fields: Vec<_> = hybrid.faults().iter().map(|fault| fault.field).collect();
        assert_eq!(fields, ["velocity", "pressure", "steps"]);
        assert_eq!(Hybrid { velocity: None, pressure: 0.0, steps: 6.0 }.faults(), []);
    }
}
