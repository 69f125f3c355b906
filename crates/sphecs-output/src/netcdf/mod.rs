//! NetCDF files of a run; no module outside this folder names the netcdf crate.
//!
//! - `file`: creating, opening and closing of files, and the errors of the library
//! - `chunks`: compressed chunks, read and written past the filters of HDF5
//! - [`compression`]: columns of a frame as chunks
//! - `slots`: particles that the slots of a file belong to
//! - `layout`: dimensions, variables and attributes of `particles.nc`
//! - [`particles`]: frames written and read in that layout
//! - [`dataset`]: tables and probes
//! - [`grids`]: fields on grids
//! - [`wall_points`]: quantities at the walls
//! - [`point_sets`]: point clouds in the layout of VTKHDF
//! - [`trajectories`]: particles as trajectories

mod chunks;
pub(crate) mod compression;
pub(crate) mod dataset;
mod file;
pub(crate) mod grids;
mod layout;
pub(crate) mod particles;
pub(crate) mod point_sets;
pub(crate) mod slots;
pub(crate) mod trajectories;
pub(crate) mod wall_points;

pub(crate) use chunks::deflated;
