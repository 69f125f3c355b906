//! Time integrators: the door lists the rooms.
//!
//! - [`kick_drift`]: kick–drift–kick for evolved pressure and transport velocity
//! - [`verlet`]: leapfrog with a plain step now and then

pub mod kick_drift;
pub mod verlet;
