//! Floor 3: the hot loops over the arrays.
//!
//! | pass | rows it writes | what |
//! |---|---|---|
//! | [`density`] | fluid (inflow, outflow) | density by summation, pressure by Tait |
//! | [`wall_distance`] | fluid, inflow, outflow | distance to the nearest wall surface |
//! | [`walls`] | walls | pressure and density extrapolated from the fluid |
//! | [`gradients`] | fluid, inflow, outflow | velocity gradient, corrected where the support is cut |
//! | [`stress`] | all | sub-particle stress from the gradient, extrapolated to walls |
//! | [`strain`] | fluid, inflow, outflow | velocity gradient among the neighbours and rate of strain, summed with the density |
//! | [`points`] | none | fits of the fluid's fields at the points of inlets and outlets, by [`fits`] |
//! | [`waves`] | outflow | what the wave equation of an outlet sums over its neighbours |
//! | [`sampling`] | none | the fluid's fields at arbitrary points, one by one |
//! | [`section`] | none | mass flow through planes |
//! | [`rates`] | fluid | acceleration, shifting vector, divergence, time-step signal: one fused pair loop |
//! | [`wall_friction`] | fluid | what walls with a wall function take |
//! | [`edac`] | fluid | the same where the pressure evolves, with the pressure's own rate and the drift |
//!
//! A pass goes over blocks of cells in parallel; for each cell it packs the neighbourhood once ([`pack`]) and runs
//! every row of the cell over it. A row's sums depend on its cell's pack alone, so they are the same bits for any
//! number of threads. Each ordered pair is computed for its own row: nothing is scattered, nothing is locked.

pub mod blocks;
pub mod body;
pub mod density;
pub mod edac;
pub mod fits;
pub(crate) mod fused;
pub mod gradients;
pub mod neighbours;
pub mod pack;
pub mod points;
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
pub mod wall_distance;
pub mod wall_friction;
pub mod wall_velocity;
pub mod walls;
pub mod waves;
