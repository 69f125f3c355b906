//! Floor 1: one method, one room. Pure functions of a particle or of a pair of lanes.

pub mod density;
pub mod edac;
pub mod eos;
pub mod integrator;
pub mod momentum;
pub mod shifting;
pub mod sps;
pub mod timestep;
pub mod viscosity;
pub mod wall;
pub mod wave_sums;
