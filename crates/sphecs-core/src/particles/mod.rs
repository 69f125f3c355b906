//! Floor 2: what a particle is. Components (the truth between steps), the sorted arrays (the truth within a step).
//!
//! - [`arrays`]: the columns of the working set
//! - [`rows`]: one row of the arrays as vectors
//! - [`sample`]: the fluid's fields at a point
//! - [`saved`]: the arrays as named columns, for checkpoints
//! - [`zone`]: the five zones

pub mod arrays;
pub mod rows;
pub mod sample;
pub mod saved;
pub mod zone;
