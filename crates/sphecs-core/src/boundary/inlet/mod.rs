//! Inlet conditions.
//!
//! - [`emitter_column`]: column of inflow particles behind a point of an emitter
//! - [`extrapolated`]: pressure extrapolated from the fluid
//! - [`injection`]: positions at which particles enter an inflow zone
//! - [`poiseuille`]: exact start-up profile between parallel plates
//! - [`prescribed`]: given pressure
//! - [`inflow_zone`]: the zone of inflow particles that a condition works on
//!
//! The velocity of an inflow is an expression or table of the scene. To add a condition of the
//! pressure, add a file, a variant of [`InletPressure`], its arms below, and the source in
//! docs/REFERENCES.md.

pub mod emitter_column;
pub mod extrapolated;
pub mod inflow_zone;
pub mod injection;
pub mod poiseuille;
pub mod prescribed;

use serde::{Deserialize, Serialize};

use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;
use extrapolated::Extrapolated;
use inflow_zone::InflowZone;
use prescribed::Prescribed;

/// Supply of an inflow zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Feed {
    /// One particle enters for each that crosses the plane, so the zone stays full. Take it for an
    /// inflow that lasts.
    #[default]
    Fed,
    /// The zone is filled once and drained, like a cylinder by a piston. The run stops when the
    /// zone behind a particle that crosses is shorter than the kernel's support. Take it for a
    /// limited supply of fluid.
    Once,
}

/// Pressure of inflow particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum InletPressure {
    /// Extrapolated from the fluid inside, first-order consistent. Take it unless the pressure at
    /// the inlet is known.
    #[default]
    Extrapolated,
    /// A given pressure, Pa. Take it for a stream of known pressure; elsewhere it disturbs the
    /// density.
    Prescribed(f64),
}

/// Evaluates an expression with the method of a pressure: the only match on the conditions.
macro_rules! with_pressure {
    ($pressure:expr, $method:ident => $result:expr) => {
        match $pressure {
            InletPressure::Extrapolated => {
                let $method = Extrapolated;
                $result
            }
            InletPressure::Prescribed(pressure) => {
                let $method = Prescribed(pressure);
                $result
            }
        }
    };
}

/// Condition of the inflow pressure.
pub trait InletMethod {
    /// Sets velocity, pressure and density of the inflow particles at the present time.
    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut InflowZone<'_, R, D>);

    /// Returns the parameters that the condition cannot work with.
    fn faults(&self) -> Vec<ParameterFault> {
        Vec::new()
    }
}

impl InletPressure {
    /// Sets velocity, pressure and density of the inflow particles at the present time.
    pub fn apply<R: PairReal<D>, const D: usize>(self, zone: &mut InflowZone<'_, R, D>) {
        with_pressure!(self, method => method.apply(zone));
    }

    /// Returns the parameters that are out of range.
    pub fn faults(self) -> Vec<ParameterFault> {
        with_pressure!(self, method => method.faults())
    }
}
