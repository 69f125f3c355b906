//! Pair passes: the loops over particles and their neighbours.
//!
//! | pass | particles it writes | result |
//! |---|---|---|
//! | [`density`] | fluid (inflow, outflow) | density by summation, pressure by Tait |
//! | [`wall_distance`] | fluid, inflow, outflow | distance to the nearest wall surface |
//! | [`walls`] | walls | pressure and density extrapolated from the fluid |
//! | [`gradients`] | fluid, inflow, outflow | velocity gradient, corrected where the support is cut |
//! | [`stress`] | all | sub-particle stress from the gradient, extrapolated to walls |
//! | [`strain`] | fluid, inflow, outflow | velocity gradient among the neighbours and rate of strain, summed with the density |
//! | [`points`] | none | fits of the fluid's fields at the points of inlets and outlets, by [`fits`] |
//! | [`waves`] | outflow | sums of an outlet's wave equation, and concentration gradient |
//! | [`sampling`] | none | the fluid's fields at arbitrary points, vectorised over the neighbours |
//! | [`grid_rows`] | none | the fluid's fields and their curl at the nodes of a grid, vectorised over the nodes |
//! | [`surface_flow`] | none | pressure and shear stress at points of the walls |
//! | [`section`] | none | mass flow through planes |
//! | [`rates`] | fluid | acceleration, shifting vector, divergence, time-step signal: one fused pair loop |
//! | [`wall_friction`] | fluid | friction of walls with a wall function |
//! | [`edac`] | fluid | rates where the pressure evolves, with that of the pressure and the drift |
//!
//! A pass runs over blocks of cells in parallel (`row_pass`). For each cell it packs the
//! neighbourhood once ([`pack`]) and sums over it for every particle of the cell. The sums of a
//! particle depend on the pack of its cell alone, so they are bitwise identical for any number of
//! threads. Each ordered pair is computed for its own particle: no scatter, no lock.
//!
//! The engine calls them through [`pair_real`], where they are compiled for every precision.
//!
//! Modules that are not passes:
//!
//! - [`blocks`]: parallel loops over blocks and parts
//! - [`body`]: force and torque on a body
//! - [`column_access`]: which pass reads which columns
//! - [`neighbours`]: neighbours of a point, one by one
//! - `near_columns`: neighbours of a point as columns
//! - [`ranks`]: processes that share the passes
//! - [`settings`]: the scene in the form of plain values
//! - [`sums`]: columns that the passes write
//! - [`wall_velocity`]: velocities of dummy walls
//! - [`wall_sides`]: sides of thin walls

pub mod blocks;
pub mod body;
pub mod column_access;
pub mod density;
pub mod edac;
pub mod fits;
pub(crate) mod fused;
pub mod gradients;
pub mod grid_rows;
mod near_columns;
pub mod neighbours;
pub mod pack;
pub mod pair_real;
pub mod points;
pub mod ranks;
pub mod rates;
mod row_pass;
#[cfg(test)]
mod samples;
pub mod sampling;
pub mod section;
pub mod settings;
pub mod strain;
pub mod stress;
pub mod sums;
pub mod surface_flow;
pub mod wall_distance;
pub mod wall_friction;
pub mod wall_sides;
pub mod wall_velocity;
pub mod walls;
pub mod waves;
