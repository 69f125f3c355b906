//! Physics, one method per file, as pure functions of a particle or of a vector of particle pairs.
//!
//! - [`density`], [`momentum`]: the pair terms of `Wcsph`
//! - [`edac`]: the pair terms of `EdacTvf`
//! - [`eos`]: the equation of state
//! - [`inlet`], [`outlet`], [`wall`]: boundary conditions
//! - [`integrator`], [`timestep`]: integration in time
//! - [`pair`]: a particle and a vector of its neighbours, as the pair terms take them
//! - [`parameters`]: parameters that are out of bounds
//! - [`shifting`]: particle shifting
//! - [`viscosity`]: viscous and turbulent stresses

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
