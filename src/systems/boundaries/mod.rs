//! Particles whose motion a condition prescribes: inflow, outflow and wall.
//!
//! - [`entrance`]: where stored particles enter an inflow zone
//! - [`hold`]: fluid particles that got behind a wall go back onto it
//! - [`inlets`]: velocity and pressure of inflow particles
//! - [`motion`]: how inflow and outflow particles move in the kick
//! - [`outlets`]: pressure, convective velocity and rates of outflow particles
//! - [`rows`]: which rows belong to which patch
//! - [`walls`]: velocity and pressure of wall particles

pub mod entrance;
pub mod hold;
pub mod inlets;
pub mod motion;
pub mod outlets;
pub mod rows;
pub mod walls;
