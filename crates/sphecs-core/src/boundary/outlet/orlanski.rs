//! Outgoing wave equation without diffusion.
//!
//! ```text
//! ∂v/∂t + v_n ∂v/∂n = f
//! ```
//!
//! Alvarado-Rodríguez et al. (2017), Eq. 28, with the body force f. All else is as
//! for [`wave_equation`](super::wave_equation), Eq. 27, which adds the transverse diffusion.

use serde::{Deserialize, Serialize};

use super::method::{Advanced, OutflowMotion, OutletMethod, OutletParameters, References};
use super::outflow_zone::OutflowZone;
use super::pressure::OutletPressure;
use super::wave_equation::{WaveCondition, WaveMemory};
use crate::pass::pair_real::PairReal;
use crate::physics::parameter_fault::ParameterFault;
use crate::physics::wave_sums::ReferenceFrame;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Orlanski {
    /// Frame in which ∂v/∂t is integrated.
    #[serde(default)]
    pub frame: ReferenceFrame,
    /// Pressure of the outflow particles.
    #[serde(default)]
    pub pressure: OutletPressure,
}

impl Orlanski {
    fn wave(&self) -> WaveCondition {
        WaveCondition { frame: self.frame, transverse: None, pressure: self.pressure }
    }
}

impl OutletParameters for Orlanski {
    fn name(&self) -> &str {
        "Orlanski"
    }

    fn references(&self) -> References {
        self.wave().references()
    }

    fn faults(&self) -> Vec<ParameterFault> {
        self.pressure.faults()
    }
}

impl OutletMethod for Orlanski {
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
