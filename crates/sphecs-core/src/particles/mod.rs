//! Particles as sorted columns, the authoritative state within a step.
//!
//! - [`arrays`]: the table of columns, and sorting
//! - [`quantity`]: columns of one quantity, scalar or vector
//! - [`record`]: one particle as bytes
//! - [`rows`]: one particle of the arrays as vectors
//! - [`sample`]: the fluid's fields at a point
//! - [`saved`]: the columns in a checkpoint
//! - `table`: the macro behind the table of columns
//! - [`zone`]: the five zones

pub mod arrays;
pub mod quantity;
pub mod record;
pub mod rows;
pub mod sample;
pub mod saved;
mod table;
pub mod zone;
