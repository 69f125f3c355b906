//! Scenes: from a RON file to a checked description without faults.
//!
//! ```text
//! text ─ notation ─▶ tree with places ─ schema ─▶ SceneFile ─ check ─▶ Scene ─ spawn ─▶ particles
//!        (--set)                       (serde)              (checks)          (fill, walls)
//! ```
//!
//! * [`notation`]: RON with places, `--set`
//! * [`schema`]: fields of a file
//! * [`constants`]: named numbers
//! * [`expression`], [`geometry`]: fields and shapes
//! * [`check`]: every check of values
//! * [`model`], [`scheme`]: the checked scene
//! * [`lattice`], [`lattice_rotation`], [`fill`], [`rows`], [`rings`], [`layers`],
//!   [`periodic_curves`], [`wall_particles`], [`spawn`]: its particles
//! * [`inflow`]: velocities of its inlets
//! * [`emitters`]: surfaces through which fluid enters along the normal, and their particles
//! * [`time_value`], [`potential_flow`]: quantities of its openings in time, and weights that give
//!   the flow through them
//! * [`body`], [`probe`]: bodies and probes, which are measured
//! * [`result_name`](mod@result_name): their names in the results
//! * [`summary`], [`oblique_walls`]: figures and notes of `sphecs check`
//! * [`passage`], [`flow_path`], [`opening_figures`], [`driven_flow`]: its narrowest passage, the
//!   flow from its inlets, its openings, and the flow that pressures drive
//! * [`meshes`]: files of meshes and outlines of its shapes
//! * [`motion`]: prescribed motions of walls
//! * [`movers`], [`mover_places`]: walls that move, and their particles
//! * [`displaced_flow`], [`closing_gaps`]: the flow that they displace, and gaps that they close
//! * [`wall_points`]: points of its walls at which pressure and shear stress are measured
//! * [`thin_walls`], [`missing_walls`]: solid that is thinner than the kernel reaches, and solid
//!   without particles
//! * [`given_speed`], [`sampled_times`]: the largest prescribed speeds, and the times at which they
//!   are sought
//! * [`disk_estimate`], [`memory_estimate`]: disk space and memory of its run
//! * [`faults`]: faults of its text
//! * `manual`: reference of the file from the doc lines of its types, behind the feature `schema`
//! * [`builder`]: a scene described in Rust, written as the text of a scene file

pub mod body;
pub mod builder;
pub mod check;
pub mod closing_gaps;
pub mod constants;
pub mod disk_estimate;
pub mod displaced_flow;
pub mod distance_grid;
mod domain_cells;
pub mod driven_flow;
pub mod emitters;
pub mod expression;
pub mod faults;
pub mod field_grid;
pub mod fill;
pub mod flow_path;
pub mod geometry;
pub mod given_speed;
pub mod inflow;
pub mod lattice;
pub mod lattice_rotation;
pub mod layers;
pub mod loader;
#[cfg(feature = "schema")]
pub mod manual;
pub mod memory_estimate;
pub mod meshes;
pub mod missing_walls;
pub mod model;
pub mod motion;
pub mod mover_places;
pub mod movers;
mod near_points;
pub mod notation;
pub mod oblique_walls;
pub mod opening_figures;
pub mod outline;
pub mod output_settings;
pub mod packing;
pub mod passage;
pub mod periodic_curves;
pub mod potential_flow;
pub mod probe;
pub mod result_name;
pub mod rings;
pub mod rows;
pub mod sampled_times;
pub mod schema;
pub mod scheme;
pub mod sheets;
pub mod spawn;
pub mod summary;
mod synonyms;
mod text_file;
pub mod thin_walls;
pub mod time_value;
mod units;
pub mod wall_particles;
pub mod wall_points;

#[cfg(test)]
mod tests;

pub use builder::SceneBuilder;
pub use faults::SceneErrors;
pub use loader::{SceneLoader, SceneValue};
pub use model::Scene;
pub use spawn::seeds;
