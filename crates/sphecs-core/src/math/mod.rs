//! Numbers: vectors of lanes, kernels, the cell grid, named columns, small linear systems and tensors.

pub mod column;
pub mod grid;
pub mod kernel;
pub mod lanes;
pub mod lattice;
pub mod linear;
pub mod real;
pub mod symmetric;
