//! Particles whose motion a condition prescribes: inflow, outflow and wall.
//!
//! - [`absorb`]: the zone of an absorbing outlet
//! - [`entrance`]: where stored particles enter an inflow zone
//! - [`hold`]: particles that got behind a wall go back onto it
//! - [`inlets`]: velocity and pressure of inflow particles
//! - [`motion`]: how inflow and outflow particles move in the kick
//! - [`outlets`]: pressure, convective velocity and rates of outflow particles
//! - [`rows`]: which rows belong to which patch
//! - [`section`]: points that stand for the section of an opening
//! - [`walls`]: velocity and pressure of wall particles

pub mod absorb;
pub mod entrance;
pub mod hold;
pub mod inlets;
pub mod motion;
pub mod outlets;
pub mod rows;
pub mod section;
pub mod walls;
