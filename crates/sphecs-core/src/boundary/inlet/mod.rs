//! Inlet conditions.
//!
//! - [`injection`]: positions at which particles enter an inflow zone
//! - [`poiseuille`]: exact start-up profile between parallel plates

pub mod injection;
pub mod poiseuille;

use serde::{Deserialize, Serialize};

/// Supply of an inflow zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Feed {
    /// One particle enters for each that crosses the plane: the zone stays full.
    #[default]
    Fed,
    /// The zone is filled once and drained, as a cylinder by its piston. The run stops when the zone behind a
    /// particle that crosses is shorter than the kernel's support.
    Once,
}

/// Pressure of inflow particles.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum InletPressure {
    /// Extrapolated from the fluid inside, first-order consistent.
    #[default]
    Extrapolated,
    /// A given pressure, Pa.
    Prescribed(f64),
}
