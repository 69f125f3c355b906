//! Physics: one method, one file. Pure functions of a particle or of a pair of particles.
//!
//! Pair functions take a particle a and a vector of its neighbours b, one per lane ([`pair`]).

pub mod density;
pub mod edac;
pub mod eos;
pub mod inlet;
pub mod integrator;
pub mod momentum;
pub mod outlet;
pub mod pair;
pub mod parameters;
pub mod shifting;
pub mod timestep;
pub mod viscosity;
pub mod wall;
