//! sphecs: a data-oriented ECS engine for smoothed particle hydrodynamics with open boundaries.
//!
//! The house has floors, and a file imports from its own floor or lower ones only:
//!
//! ```text
//!   cli ── bench ── run ── simulation   what the user asks, figures of speed, the run loop, the plugin list
//!   6  output     frames, probes, pictures: reads the world, never changes it
//!   5  systems    thin systems, sets, plugins: the schedule of a step
//!   4  scene      from a RON file to a scene that cannot be wrong
//!   3  pass       the hot loops over the arrays                            ┐
//!   2  particles  components (between steps) and arrays (within a step)    │ 0, 1 and 3 know no ECS,
//!   1  physics    one method per room, as pure functions                   │ no files and no clock
//!   0  math       lanes, kernels, the cell grid                            ┘
//! ```
//!
//! A scene becomes a flow:
//!
//! ```no_run
//! use std::path::Path;
//!
//! use sphecs::glam::DVec3;
//! use sphecs::scene;
//! use sphecs::simulation::Simulation;
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = scene::load(Path::new("scenes/quickstart.ron"), &[])?;
//! let mut simulation = Simulation::from_scene(scene);
//! simulation.run_until(0.1)?;
//! for sample in simulation.sample(&[DVec3::new(0.05, 0.0, 0.0)]).into_iter().flatten() {
//!     println!("{} m/s, {} Pa", sample.velocity, sample.pressure);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! What the engine does not have is a plugin of one's own: here a spring that draws the fluid to the axis.
//!
//! ```
//! use std::path::Path;
//!
//! use sphecs::glam::DVec3;
//! use sphecs::scene;
//! use sphecs::simulation::Simulation;
//! use sphecs::systems::forces::{AddedForces, ParticleState};
//! use sphecs::plugins::{Parts, Plugin};
//!
//! struct Spring {
//!     /// Stiffness per mass, 1/s².
//!     stiffness: f64,
//! }
//!
//! impl Plugin for Spring {
//!     fn build(&self, parts: &mut Parts<'_>) {
//!         let stiffness = self.stiffness;
//!         let force = move |particle: &ParticleState| DVec3::new(0.0, -stiffness * particle.position.y, 0.0);
//!         parts.world.get_resource_or_init::<AddedForces>().add(force);
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = scene::load_smoke(Path::new("scenes/quickstart.ron"), &[])?;
//! let mut simulation = Simulation::with_plugins(scene, &[&Spring { stiffness: 2.0 }]);
//! simulation.step()?;
//! # Ok(())
//! # }
//! ```
//!
//! A plugin adds systems to the sets of [`StepSet`](schedule::StepSet) and
//! [`StageSet`](schedule::StageSet) in the same way.
//! SI units everywhere.

// The versions that the public interface speaks: a user's own would be other types.
pub use bevy_ecs;
pub use glam;

#[cfg(feature = "cli")]
pub use sphecs_bench as bench;
pub use sphecs_core::{math, particles, pass, physics};
pub use sphecs_engine::{arrays, components, simulation, systems, transfer};
#[cfg(feature = "output")]
pub use sphecs_output as output;
#[cfg(feature = "output")]
pub use sphecs_run as run;
pub use sphecs_scene as scene;
#[cfg(feature = "cli")]
pub use sphecs_validate as validate;

#[cfg(feature = "cli")]
pub mod cli;

/// The examples of the README compile.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
