//! Inlets: the door lists the rooms and holds the closed choices.
//!
//! - [`poiseuille`]: the exact start-up profile between parallel plates

pub mod poiseuille;

use serde::{Deserialize, Serialize};

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
