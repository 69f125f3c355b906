//! Interface of an outlet condition: parameters, memory, requirements and application.
//!
//! Conditions of the engine and conditions that a plugin adds implement the same two traits.

use std::fmt::Debug;

use glam::DVec3;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::outflow_zone::OutflowZone;
use super::pressure_driven::time_function::Given;
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;

/// Parameters of an outlet condition, as a scene states them.
pub trait OutletParameters: Debug + Send + Sync {
    /// Returns the name of the condition in a scene.
    fn name(&self) -> &str;

    /// Returns the requirements of the condition.
    fn needs(&self) -> Needs {
        Needs::default()
    }

    /// Returns velocity and pressure of the surroundings that the scene gives; 0 by default.
    fn references(&self) -> References {
        References::default()
    }

    /// Returns the share of the prescribed inflow that the condition takes; None by default.
    fn share(&self) -> Option<f64> {
        None
    }

    /// Returns the quantity that the scene gives as a function of time; None by default.
    fn given(&self) -> Option<Given<'_>> {
        None
    }

    /// Returns the parameters that are out of range.
    fn faults(&self) -> Vec<ParameterFault> {
        Vec::new()
    }
}

/// An outlet condition.
///
/// A time step calls [`apply`](Self::apply) before the rates are summed, then
/// [`find_rates`](Self::find_rates), and [`advance`](Self::advance) for each particle of the zone.
pub trait OutletMethod: OutletParameters + Clone + 'static {
    /// State of the condition between steps. A checkpoint saves it by `serde`; buffers are skipped.
    type Memory: Default + Serialize + DeserializeOwned + Send + Sync + 'static;

    /// Sets velocity and pressure of the outflow particles and the speed at which they move: calls
    /// [`OutflowZone::set`] once for each row of the zone, in their order.
    fn apply<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        memory: &mut Self::Memory,
    );

    /// Finds acceleration and shifting vector of the outflow particles; by default both are 0.
    fn find_rates<R: PairReal<D>, const D: usize>(
        &self,
        zone: &mut OutflowZone<'_, R, D>,
        _memory: &mut Self::Memory,
    ) {
        zone.clear_rates();
    }

    /// Returns the pressure at the plane by its parts; 0 by default.
    fn plane_pressure(&self, _memory: &Self::Memory) -> PlanePressure {
        PlanePressure::default()
    }

    /// Advances an outflow particle by a time step. By default it moves at the speed that
    /// [`apply`](Self::apply) set.
    fn advance(&self, particle: &OutflowMotion) -> Advanced {
        Advanced { velocity: particle.accelerated(), speed: particle.speed }
    }
}

/// Requirements of an outlet condition.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Needs {
    /// Length, in spacings, beyond the kernel's support over which the condition follows the fluid
    /// upstream of the plane; None if it follows none.
    pub upstream_layers: Option<f64>,
    /// True if backflow would re-enter with frozen or prescribed values.
    pub is_one_way: bool,
    /// True if fluid may enter for good. The pressure gradient of the flow then continues into the
    /// zone, so that the pressure at the plane is that of the condition, and the zone is kept full.
    pub is_bidirectional: bool,
    /// True if the condition uses the flow rate that the whole domain has, without sound.
    pub uses_through_flow: bool,
    /// True if the condition uses the mean speed of the inflow particles.
    pub uses_inflow_speed: bool,
}

/// Velocity and pressure of the surroundings.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct References {
    /// Velocity along the normal, m/s.
    pub velocity: f64,
    /// Pressure, Pa.
    pub pressure: f64,
}

/// Mean pressure at the plane of an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PlanePressure {
    /// Rate of change of the pressure that the condition approaches, Pa/s.
    pub rate: f64,
    /// Pressure of sound: that at the plane less the one that the condition approaches, Pa.
    pub sound: f64,
}

/// State of an outflow particle that a condition prescribes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct OutflowState {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Speed along the normal at which the particle moves, m/s.
    pub speed: f64,
}

impl OutflowState {
    /// Returns a state whose particle moves along the normal at its own normal velocity.
    pub fn moving(velocity: DVec3, pressure: f64, normal: DVec3) -> Self {
        Self { velocity, pressure, speed: velocity.dot(normal) }
    }

    /// Returns the state with another velocity along the normal, m/s.
    #[must_use]
    pub fn at_speed(self, speed: f64, normal: DVec3) -> Self {
        Self { velocity: self.velocity + normal * (speed - self.velocity.dot(normal)), speed, ..self }
    }
}

/// Motion of an outflow particle at the start of a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OutflowMotion {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// Acceleration, m/s².
    pub acceleration: DVec3,
    /// Speed along the normal that the condition set, m/s.
    pub speed: f64,
    /// Unit normal in the direction of the outflow.
    pub normal: DVec3,
    /// Time step, s.
    pub time_step: f64,
}

impl OutflowMotion {
    /// Returns the velocity after a forward Euler step, m/s.
    ///
    /// The rates are dissipative: a leapfrog would amplify them.
    pub fn accelerated(&self) -> DVec3 {
        self.velocity + self.acceleration * self.time_step
    }
}

/// Motion of an outflow particle over a time step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Advanced {
    /// Velocity at the end of the step, m/s.
    pub velocity: DVec3,
    /// Speed along the normal at which the particle moved, m/s.
    pub speed: f64,
}
