//! Smoothed particle hydrodynamics (SPH) of flows with open boundaries.
//!
//! * **A scene describes the flow.**
//!   [`Scene::from_file`] reads it from a RON file, changes values on request, and reports all
//!   errors at once. [`Scene::builder`] makes a scene of the types in [`scene`], with the same
//!   checks.
//! * **A simulation computes it.**
//!   [`Simulation::builder`] takes the scene and plugins. [`Simulation::run_until`] advances the
//!   flow until a time, or returns a [`Stop`] that tells why it cannot continue.
//! * **Results are read between two steps.**
//!   [`Simulation::sample`] returns the fields at points, [`Simulation::monitor_row`] the integral
//!   quantities and [`Simulation::mass_flows`] the flows through sections. [`Simulation::world`]
//!   holds the particles as entities with components.
//!
//! All quantities are in SI units.
//!
//! ```
//! use sphecs::glam::DVec3;
//! use sphecs::{AddedForces, ParticleState, Plugin, PluginContext, Scene, Simulation};
//!
//! /// Spring that attracts the fluid to the axis of the channel.
//! struct Spring {
//!     /// Stiffness per mass, 1/s².
//!     stiffness: f64,
//! }
//!
//! impl Plugin for Spring {
//!     fn build(&self, context: &mut PluginContext<'_>) {
//!         let stiffness = self.stiffness;
//!         let force = move |at: &ParticleState| DVec3::Y * (-stiffness * at.position.y);
//!         context.world.get_resource_or_init::<AddedForces>().add(force);
//!     }
//! }
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let scene = Scene::from_file("scenes/quickstart.ron").set("spacing", 2.5e-3).load()?;
//! let mut simulation = Simulation::builder(scene).plugin(Spring { stiffness: 2.0 }).build()?;
//! simulation.run_until(0.01)?;
//! for sample in simulation.sample(&[DVec3::new(0.05, 0.0, 0.0)]).into_iter().flatten() {
//!     println!("{} m/s, {} Pa", sample.velocity, sample.pressure);
//! }
//! # Ok(())
//! # }
//! ```
//!
//! A plugin adds its systems to the sets of [`StepSet`] and [`StageSet`]. The folder `examples/`
//! has complete programs: a force, an outlet, sampled fields and a sweep over a parameter.
//!
//! Everything else is in the crates of the layers: `sphecs_core` (kernels, physics, pair passes),
//! `sphecs_scene`, `sphecs_engine` (components, resources, systems), `sphecs_output` (files) and
//! `sphecs_run` (the loop of the program `sphecs`).

// The versions in the public interface: types of other versions would not match.
pub use bevy_ecs;
pub use glam;

pub use sphecs_core::particles::zone::Zone;
pub use sphecs_core::pass::section::Section;
pub use sphecs_engine::components::{ParticleId, Position, Thermodynamics, Velocity};
pub use sphecs_engine::plugins::{Plugin, PluginContext};
pub use sphecs_engine::resources::clock::Clock;
pub use sphecs_engine::resources::ledger::Ledger;
pub use sphecs_engine::schedule::{StageSet, StepSet};
pub use sphecs_engine::simulation::{BuildError, Sample, Simulation, SimulationBuilder, Stop, StopRequest};
pub use sphecs_engine::systems::force_fields::FluidState;
pub use sphecs_engine::systems::forces::{AddedForces, ParticleState};
pub use sphecs_engine::systems::monitor::MonitorRow;
pub use sphecs_scene::model::Precision;
pub use sphecs_scene::{Scene, SceneBuilder, SceneErrors, SceneLoader};

/// Parts of a scene that is described in Rust by [`Scene::builder`].
///
/// Choices such as [`OutletCondition`](scene::OutletCondition) are the types that the engine
/// computes with.
///
/// ```
/// use sphecs::Scene;
/// use sphecs::scene::{
///     Fluid, Inlet, Mirror, Outlet, OutletCondition, Output, PoiseuilleStartup, Shape, Time,
/// };
///
/// # fn main() -> Result<(), sphecs::SceneErrors> {
/// // Plane channel of 1 mm that the flow starts in from rest.
/// let scene = Scene::builder(2)
///     .spacing(5e-5)
///     .constant("H", 1e-3)
///     .fluid(Fluid::new().density(1000.0).viscosity(1e-6).sound_speed(0.2))
///     .domain(Shape::cuboid((0.0, "-H/2"), ("3*H", "H/2")))
///     .inlet(Inlet::new((0.0, 0.0), (1.0, 0.0), PoiseuilleStartup::new(0.1)))
///     .outlet(
///         Outlet::new(("3*H", 0.0), (1.0, 0.0))
///             .condition(OutletCondition::Mirror(Mirror::default())),
///     )
///     .time(Time::until(1.0))
///     .output(Output::at_interval(0.1))
///     .build()?;
/// assert_eq!(scene.spacing, 5e-5);
/// # Ok(())
/// # }
/// ```
pub mod scene {
    pub use sphecs_core::boundary::inlet::{Feed, InletPressure};
    pub use sphecs_core::boundary::outlet::OutletCondition;
    pub use sphecs_core::boundary::outlet::parameters::*;
    pub use sphecs_core::boundary::patch::Extent;
    pub use sphecs_core::math::kernel::Kernel;
    pub use sphecs_core::physics::integrator::Integrator;
    pub use sphecs_core::physics::shifting::Shifting;
    pub use sphecs_core::physics::shifting::parameters::*;
    pub use sphecs_core::physics::viscosity::Viscosity;
    pub use sphecs_core::physics::viscosity::parameters::*;
    pub use sphecs_core::physics::wall::{Slip, WallModel, WallPressure};
    pub use sphecs_scene::builder::{
        BendSection, Body, Components, Concentric, EdacTvf, Fill, Fluid, Formula, Initial, Inlet,
        InletVelocity, Interval, Lattice, MassFlow, MassFlux, Number, Outlet, Output, Packed,
        PoiseuilleStartup, Probe, ProbeKind, Reference, Reservoir, Rotation, Scheme, Shape, Time, Vector,
        VectorFormula, WallFill, WallFitted, WallPart, Walls, Wcsph,
    };
    pub use sphecs_scene::model::{ForcesEvery, ProbeSight, WhenEmpty};
    pub use sphecs_scene::rings::FirstRing;
}

/// Interface of the outlet conditions that plugins add by [`PluginContext::add_outlet`].
pub mod outlet {
    pub use sphecs_core::boundary::outlet::method::{
        Advanced, Needs, OutflowMotion, OutflowState, OutletMethod, OutletParameters, References,
    };
    pub use sphecs_core::boundary::outlet::outflow_zone::OutflowZone;
    pub use sphecs_core::pass::fits::{PointFit, PointFlow};
    pub use sphecs_core::pass::pair_real::PairReal;
    pub use sphecs_core::physics::parameter_fault::ParameterFault;
}

#[cfg(feature = "output")]
pub use sphecs_output as output;
#[cfg(feature = "output")]
pub use sphecs_run as run;

#[cfg(feature = "cli")]
#[doc(hidden)]
pub mod cli;

/// Compiles the examples of the README.
#[cfg(doctest)]
#[doc = include_str!("../README.md")]
struct Readme;
