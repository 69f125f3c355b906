//! Exact solutions as references of profiles, one module each.
//!
//! To add one: a module with a function of position and time, a variant of `ReferenceFile` in
//! `schema`, and an arm in `measures/reference.rs`. Solutions that a formula of x, y, z and t can
//! express need no module.

pub mod couette;
pub mod duct;

pub use sphecs_core::boundary::inlet::poiseuille::startup_velocity as poiseuille_startup;
