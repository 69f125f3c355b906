//! Boundary particles: inflow, outflow and wall.
//!
//! - [`emitter_states`]: volumes that the columns of emitters emitted
//! - [`emitters`]: inflow particles of emitters
//! - [`inflow_columns`]: compression of inflow zones
//! - [`inlets`]: velocity, pressure and motion of inflow particles
//! - [`movers`]: positions, velocities and normals of walls that move
//! - [`opening_numbers`]: numbers of the openings that the conditions of others use
//! - [`opening_regions`]: regions around the openings, of which a rank holds those that it touches
//! - [`outlet_balance`]: balance of a body force at an outlet
//! - [`outlet_diagnostics`]: signs that an outlet condition does not suit the flow
//! - [`outlet_records`]: saved state of the outlets
//! - [`outlet_registry`]: outlet conditions that plugins add
//! - [`outlets`]: state, pressure, rates and motion of outflow particles
//! - [`patch_cells`]: grid cells near inlets and outlets
//! - [`patch_rows`]: rows of the arrays that belong to each inlet and outlet
//! - [`prescribed_inflow`]: volume flow that the inlets prescribe
//! - [`through_flow`]: flow through the openings from the velocities in the whole domain
//! - [`wall_contacts`]: forces on bodies by particles that were returned to their surfaces
//! - [`wall_projection`]: return of particles from behind a wall to its surface
//! - [`walls`]: velocity and pressure of wall particles
//!
//! The conditions are in `sphecs_core::boundary`; the systems here call them.

pub mod emitter_states;
pub mod emitters;
pub mod inflow_columns;
pub mod inlets;
pub mod movers;
pub mod opening_numbers;
pub mod opening_regions;
pub mod outlet_balance;
pub mod outlet_diagnostics;
pub mod outlet_records;
pub mod outlet_registry;
pub mod outlets;
pub mod patch_cells;
pub mod patch_rows;
pub mod prescribed_inflow;
pub mod through_flow;
pub mod wall_contacts;
pub mod wall_projection;
pub mod walls;
