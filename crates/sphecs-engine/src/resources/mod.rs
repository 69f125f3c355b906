//! Data of the world apart from the particles.
//!
//! - [`clock`]: time, step and step size
//! - [`entity_index`]: the entity of each particle number, and the particles in the reservoir
//! - [`grid`]: the cell grid and the buffers for sorting
//! - [`inflow_particles`]: which particles of the inflow zones returned from the fluid
//! - [`ledger`]: particle counts by zone and through the openings
//! - [`pair`]: the settings of the pair sums
//! - [`pair_sums`]: the results of the pair passes
//! - [`particle_details`]: what only components have, of particles without components
//! - [`scene`]: the scene, its lengths and its mass
//! - [`state_location`]: which copy of the particle state is current
//! - [`stopwatch`]: wall-clock time by set

pub mod clock;
pub mod entity_index;
pub mod grid;
pub mod inflow_particles;
pub mod ledger;
pub mod pair;
pub mod pair_sums;
pub mod particle_details;
pub mod scene;
pub mod state_location;
pub mod stopwatch;
