//! Systems of the scheme `Wcsph`.
//!
//! - [`kick`]: time step, new velocities and positions
//! - [`rates`]: density, gradients and pair forces
//! - [`shift`]: particle shifting

pub mod kick;
pub mod rates;
pub mod shift;
