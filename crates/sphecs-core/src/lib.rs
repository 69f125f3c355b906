//! Numerical core of sphecs: kernels, the cell grid, particle columns, physics and the pair passes.
//!
//! Knows no ECS, no files and no clock.

pub mod discretisation;
pub mod math;
pub mod particles;
pub mod pass;
pub mod physics;
