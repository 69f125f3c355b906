//! Time integrators: the door lists the rooms.
//!
//! - [`verlet`]: leapfrog with a plain step now and then

pub mod verlet;
