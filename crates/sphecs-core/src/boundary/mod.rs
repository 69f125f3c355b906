//! Boundary conditions: inlets and outlets, with the plane openings at which they apply.
//!
//! - [`flow`]: properties of the flow and of the domain that conditions refer to
//! - [`inlet`]: inflow particles
//! - [`outlet`]: outflow particles
//! - [`patch`]: plane openings of the domain
//! - [`section_points`]: points that represent the section of an opening
//! - [`section_raster`]: sections that are no rectangle
//! - [`slow_part`]: slow part of a signal that is known in advance
//!
//! One condition is one file: equation, parameters, memory between steps, requirements, checks,
//! application and tests. Wall models are in [`physics::wall`](crate::physics::wall), because the
//! pair sums use them.

pub mod flow;
pub mod inlet;
pub mod outlet;
pub mod patch;
pub mod section_points;
pub mod section_raster;
pub mod slow_part;
