//! Inlets: the door lists the rooms and holds the closed choices.
//!
//! - [`poiseuille`]: the exact start-up profile between parallel plates

pub mod poiseuille;

use serde::{Deserialize, Serialize};

/// What follows the particles of an inflow zone.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Feed {
    /// One for each that crosses the plane: the zone stays full.
    #[default]
    Fed,
    /// Nothing: the zone is filled once and drained, as a cylinder by its piston. The run stops when what is left behind a
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
    /// Given, Pa.
    Prescribed(f64),
}
