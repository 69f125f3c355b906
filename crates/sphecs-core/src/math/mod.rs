//! Floor 0: numbers. Vectors, lanes, kernels, the cell grid, named columns and small linear systems.

pub mod column;
pub mod grid;
pub mod kernel;
pub mod lanes;
pub mod lattice;
pub mod linear;
pub mod real;
