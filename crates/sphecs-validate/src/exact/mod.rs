//! Exact solutions that profiles are held against, each in a room with its checks.
//!
//! To add one: a room with a function of place and time, a variant of `ReferenceFile` in `schema`, and an arm in
//! `value/reference.rs`. What a formula of x, y, z, t can say needs none.

pub mod couette;
pub mod duct;

pub use sphecs_core::boundary::inlet::poiseuille::startup_velocity as poiseuille_startup;
