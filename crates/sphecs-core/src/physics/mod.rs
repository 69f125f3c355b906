//! Physics, one method per file, as pure functions of a particle or of a vector of particle pairs.
//!
//! - [`summed_density`], [`momentum`]: the pair terms of `Wcsph`
//! - [`edac`]: the pair terms of `EdacTvf`
//! - [`eos`]: the equation of state
//! - [`integrator`], [`timestep`]: integration in time
//! - [`pair`]: a particle and a vector of its neighbours, as the pair terms take them
//! - [`parameter_fault`]: parameters that a method cannot work with
//! - [`pose`]: place, orientation and rates of a rigid body
//! - [`shifting`]: particle shifting
//! - [`viscosity`]: viscous and turbulent stresses
//! - [`wall`]: wall models
//! - [`wave_sums`]: pair sums of the outgoing wave equation of an outlet

pub mod edac;
pub mod eos;
pub mod integrator;
pub mod momentum;
pub mod pair;
pub mod parameter_fault;
pub mod pose;
pub mod shifting;
pub mod summed_density;
pub mod timestep;
pub mod viscosity;
pub mod wall;
pub mod wave_sums;
