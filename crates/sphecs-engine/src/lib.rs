//! Engine of sphecs: components, resources, systems, schedules and plugins of a simulation.
//!
//! A [`Simulation`](simulation::Simulation) holds a bevy_ecs world with one entity per particle; of
//! several ranks, the particles are in the columns alone.
//!
//! - [`arrays`]: the sorted particle columns as a resource
//! - [`components`]: the state of a particle between two steps
//! - [`particle_state`]: the state of single particles, with or without components
//! - [`particle_table`]: the state of all particles in the order of their numbers
//! - [`plugins`]: the [`Plugin`](plugins::Plugin) interface, and the plugins of the engine itself
//! - [`resources`]: scene, clock, particle counts and other data of the world apart from the
//!   particles
//! - [`saved_state`]: everything that the next step depends on, as named columns
//! - [`schedule`]: the two schedules of a step and their sets
//! - [`simulation`]: the simulation, its builder and the reasons to stop
//! - `spawn`: the particles of a scene or of a saved state as entities or columns
//! - [`systems`]: the functions that run in the sets
//! - `transfer`: copies between components and arrays

pub mod arrays;
pub mod components;
pub mod particle_state;
pub mod particle_table;
pub mod plugins;
pub mod resources;
pub mod saved_state;
pub mod schedule;
pub mod simulation;
pub(crate) mod spawn;
pub mod systems;
pub(crate) mod transfer;
