//! Mathematics below the physics: it knows particles only as rows of numbers.
//!
//! - [`mod@column`]: named columns of numbers, the form in which a state is saved
//! - [`exact_sum`]: sums that do not depend on the order of their terms
//! - [`factors`]: factors of small symmetric matrices, one per lane
//! - [`grid`]: the cell grid, its counting sort and the search for neighbours
//! - [`kernel`]: smoothing kernels
//! - [`lanes`]: SIMD vectors of every instruction set behind one trait
//! - [`lattice`]: kernel sums on the initial lattice
//! - [`linear`]: linear systems of up to four unknowns
//! - [`real`]: the scalar type of the passes, `f64` or `f32`
//! - [`symmetric`]: symmetric tensors by component

pub mod column;
pub mod exact_sum;
pub mod factors;
pub mod grid;
pub mod kernel;
pub mod lanes;
pub mod lattice;
pub mod linear;
pub mod real;
pub mod symmetric;
