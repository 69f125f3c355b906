//! Floor 5: thin systems, their sets and plugins.
//!
//! - [`boundaries`]: inflow, outflow and wall particles
//! - [`checkpoint`]: everything that the next step depends on, as named columns
//! - [`clock`]: time, step and step size
//! - [`core_plugins`]: which system runs in which set
//! - [`edac`]: the systems of the scheme `EdacTvf`
//! - [`failure`]: what makes a run stop
//! - [`forces`]: the body force, and forces that a user adds
//! - [`home`]: which home of the state is fresh
//! - [`integrate`]: the kick of the scheme `Wcsph`
//! - [`ledger`]: the particle ledger
//! - [`monitor`]: integral figures of the flow
//! - [`neighbourhood`]: what stood around a particle when the flow blew up
//! - [`neighbours`]: the cell grid and the sorted arrays
//! - [`pair`]: the settings of the pair sums
//! - [`plugin`]: what a simulation is made of
//! - [`rates`]: the systems that call the hot passes, of the scheme `Wcsph`
//! - [`schedule`]: the two schedules and their sets
//! - [`setup`]: from a scene to a world
//! - [`shift`]: particle shifting, of the scheme `Wcsph`
//! - [`stopwatch`]: wall-clock time by set
//! - [`surface_shear`]: what the pairs leave out of the shear on a body whose surface turns
//! - [`transitions`]: particles change zone

pub mod bodies;
pub mod boundaries;
pub mod checkpoint;
pub mod clock;
pub mod core_plugins;
pub mod edac;
pub mod failure;
pub mod forces;
pub mod home;
pub mod integrate;
pub mod ledger;
pub mod monitor;
pub mod neighbourhood;
pub mod neighbours;
pub mod pair;
pub mod plugin;
pub mod rates;
pub mod readings;
pub mod schedule;
pub mod setup;
pub mod shift;
pub mod stopwatch;
pub mod surface_shear;
pub mod transitions;
