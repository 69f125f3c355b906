//! Particles whose motion a condition prescribes: inflow, outflow and wall.
//!
//! - [`absorb`]: the zone of an absorbing outlet
//! - [`entrance`]: where stored particles enter an inflow zone
//! - [`hold`]: particles that got behind a wall go back onto it
//! - [`hybrid`]: the zone of a hybrid outlet
//! - [`inlets`]: velocity and pressure of inflow particles
//! - [`kept`]: conditions that say in every step what an outflow particle has
//! - [`motion`]: how inflow and outflow particles move in the kick
//! - [`near`]: the rows among which those of the zones are
//! - [`outlets`]: what each outlet remembers, and which room applies its condition
//! - [`rows`]: which rows belong to which patch
//! - [`section`]: points that stand for the section of an opening
//! - [`walls`]: velocity and pressure of wall particles
//! - [`watch`]: what an outlet does that it should not, said while the run goes on
//! - [`wave_zone`]: the zone of a wave equation

pub mod absorb;
pub mod entrance;
pub mod hold;
pub mod hybrid;
pub mod inlets;
pub mod kept;
pub mod motion;
pub mod near;
pub mod outlets;
pub mod rows;
pub mod section;
pub mod walls;
pub mod watch;
pub mod wave_zone;
