//! Builder of a simulation: scene, initial state and plugins.

use std::sync::Arc;

use bevy_ecs::change_detection::Mut;
use bevy_ecs::schedule::{Schedule, Schedules};
use bevy_ecs::world::World;

use super::ranks::{Connection, FirstDivision};
use super::readings::Readiness;
use super::{Simulation, TypedFunctions};
use crate::arrays::Arrays;
use crate::plugins::builtin::add_builtin;
use crate::plugins::{Plugin, PluginContext};
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::grid::{Grid, scene_grid};
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::{InflowCapacity, Ledger};
use crate::resources::pair::{Pair, pair_settings};
use crate::resources::scene::ActiveScene;
use crate::saved_state::{SavedResources, part, particles};
use crate::schedule::{stage_schedule, step_schedule};
use crate::spawn::{count_particles, fill_arrays, spawn_particles};
use crate::systems::boundaries::emitter_states::EmitterStates;
use crate::systems::boundaries::movers::{MoverParticles, find_poses, orient};
use crate::systems::boundaries::outlet_registry::OutletFaults;
use crate::systems::boundaries::outlets::insert_outlets;
use crate::systems::transitions::refill::WaitingInjections;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::math::grid::CellGrid;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::division::Division;
use sphecs_scene::model::{ParticleSeed, Precision, Scene};

/// Builder of a [`Simulation`], from [`Simulation::builder`].
#[must_use = "a builder does nothing until `build` is called"]
pub struct SimulationBuilder {
    scene: Scene,
    start: Start,
    plugins: Vec<Box<dyn Plugin>>,
    has_components: bool,
}

/// Initial state of a simulation.
enum Start {
    /// Particles that the scene fills in.
    Scene,
    /// Particles of the caller.
    Particles(Vec<ParticleSeed>),
    /// State of another simulation of the same scene.
    State(Columns),
    /// Part of the state of a simulation that this one follows.
    Part(Columns),
}

/// Reason for which a simulation cannot be built.
#[derive(Clone, Debug, thiserror::Error)]
#[non_exhaustive]
pub enum BuildError {
    /// The initial state does not fit the scene and the plugins.
    #[error(transparent)]
    State(#[from] ColumnMismatch),
    /// No plugin adds an outlet condition of the scene, or its parameters are out of range.
    #[error(transparent)]
    Outlets(#[from] OutletFaults),
    /// Two resources are saved under one name, or one resource under two names.
    #[error(
        "plugins: `{name}` and `{other}` are saved as one resource; each resource needs one name of its own"
    )]
    SavedTwice {
        /// Name that a plugin saves a resource under.
        name: &'static str,
        /// Name under which a plugin before it saves a resource.
        other: &'static str,
    },
    /// The systems cannot be ordered.
    #[error("plugins: the systems cannot be ordered; order them with `before` or `after`: {0}")]
    Schedule(String),
}

impl SimulationBuilder {
    pub(super) fn new(scene: Scene) -> Self {
        Self { scene, start: Start::Scene, plugins: Vec::new(), has_components: true }
    }

    /// Adds a plugin, which is built after those of the engine and those added before.
    pub fn plugin(mut self, plugin: impl Plugin + 'static) -> Self {
        self.plugins.push(Box::new(plugin));
        self
    }

    /// Starts from these particles in place of those that the scene fills in.
    ///
    /// They are the particles of [`sphecs_scene::seeds`](sphecs_scene::spawn::seeds), displaced or
    /// with other velocities.
    pub fn particles(mut self, particles: Vec<ParticleSeed>) -> Self {
        self.start = Start::Particles(particles);
        self
    }

    /// Starts from a state that [`Simulation::state`] returned for the same scene with the same
    /// plugins.
    ///
    /// The results are bitwise identical to those of an uninterrupted run, with any number of
    /// threads.
    pub fn state(mut self, state: Columns) -> Self {
        self.start = Start::State(state);
        self
    }

    /// Starts from what [`Simulation::part`] returned for a rank, which
    /// [follows](Simulation::follow) that simulation.
    ///
    /// Its particles have no components.
    pub fn part(mut self, part: Columns) -> Self {
        self.start = Start::Part(part);
        self
    }

    /// Gives the particles no components, for a simulation that [leads](Simulation::lead) several
    /// ranks: there they have none, and would take memory until then.
    ///
    /// Its particles are read by [`Simulation::for_each_particle`] and [`Simulation::particles`].
    pub fn without_components(mut self) -> Self {
        self.has_components = false;
        self
    }

    /// Builds the simulation, ready for its first step.
    ///
    /// # Errors
    /// [`BuildError`] if a state does not fit the scene, if no plugin adds an outlet condition of
    /// the scene, or if plugins contradict each other.
    pub fn build(self) -> Result<Simulation, BuildError> {
        match (self.scene.precision, self.scene.dimensions) {
            (Precision::F64, 2) => self.build_typed::<f64, 2>(),
            (Precision::F64, _) => self.build_typed::<f64, 3>(),
            (Precision::F32, 2) => self.build_typed::<f32, 2>(),
            (Precision::F32, _) => self.build_typed::<f32, 3>(),
        }
    }

    fn build_typed<R: PairReal<D>, const D: usize>(self) -> Result<Simulation, BuildError> {
        let Self { scene, start, plugins, has_components } = self;
        let mut contents = match start {
            Start::Scene => Contents::Particles(sphecs_scene::spawn::seeds(&scene)),
            Start::Particles(particles) => Contents::Particles(particles),
            Start::State(state) => Contents::State(state),
            Start::Part(part) => Contents::Part(part),
        };
        let scene = Arc::new(scene);
        let mut world = World::new();
        world.insert_resource(ActiveScene(scene.clone()));
        let pair = Pair(pair_settings(&scene));
        world.insert_resource(Grid::<D>(contents.grid(&scene, &pair)?));
        world.insert_resource(pair);
        let schedules = build_plugins::<R, D>(&scene, &plugins, &mut world)?;
        add_schedules(&mut world, schedules)?;
        // The particles come last: bevy keeps each resource in a table whose size is the index of
        // its entity, 4 B per particle for each resource inserted after the particles.
        match contents {
            Contents::Particles(particles) => {
                if scene.has_moving_walls() {
                    world.insert_resource(MoverParticles::new(&scene, &particles));
                }
                if !scene.emitters.is_empty() {
                    world.insert_resource(EmitterStates::new(&scene, &particles));
                }
                count_particles(&mut world, &scene, &particles);
                if has_components {
                    spawn_particles(&mut world, &scene, &particles);
                } else {
                    fill_arrays::<R, D>(&mut world, &scene, particles);
                }
            }
            Contents::State(mut state) => {
                particles::restore::<R, D>(&mut world, has_components, &mut state)?;
                SavedResources::restore(&mut world, &mut state)?;
                particles::check_ledger::<R, D>(&world)?;
            }
            Contents::Part(mut part) => {
                world.insert_resource(FirstDivision(Division::restore(&mut part)?));
                part::restore::<R, D>(&mut world, &mut part)?;
                SavedResources::restore(&mut world, &mut part)?;
            }
        }
        find_poses(&mut world);
        if !has_components {
            world.resource_scope(|world, mut arrays: Mut<Arrays<R, D>>| orient(world, &mut arrays));
        }
        let functions = TypedFunctions::new::<R, D>(&scene);
        Ok(Simulation {
            world,
            scene,
            functions,
            readiness: Readiness::default(),
            connection: Connection::default(),
        })
    }
}

/// Particles of a new world.
enum Contents {
    /// Initial particles.
    Particles(Vec<ParticleSeed>),
    /// Saved state.
    State(Columns),
    /// Part of a state.
    Part(Columns),
}

impl Contents {
    fn grid<const D: usize>(&mut self, scene: &Scene, pair: &Pair) -> Result<CellGrid<D>, ColumnMismatch> {
        match self {
            Self::Particles(particles) => Ok(scene_grid(scene, &pair.0, particles)),
            Self::State(state) | Self::Part(state) => particles::restore_grid(scene, pair, state),
        }
    }
}

/// Builds the plugins of the engine and of the caller; returns both schedules.
fn build_plugins<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    plugins: &[Box<dyn Plugin>],
    world: &mut World,
) -> Result<[Schedule; 2], BuildError> {
    let (mut step, mut stage) = (step_schedule(), stage_schedule());
    let mut context = PluginContext { world, step: &mut step, stage: &mut stage };
    add_builtin::<R, D>(scene, &mut context);
    for plugin in plugins {
        plugin.build(&mut context);
    }
    insert_outlets::<R, D>(context.world, scene)?;
    context.world.init_resource::<EntityIndex>();
    context.world.init_resource::<FreeParticles>();
    context.world.init_resource::<InflowParticles>();
    context.save_resource::<InflowCapacity>("inflow_capacity");
    context.save_resource::<WaitingInjections>("waiting_injections");
    context.save_resource::<Ledger>("ledger");
    match context.world.resource::<SavedResources>().collision() {
        Some([name, other]) => Err(BuildError::SavedTwice { name, other }),
        None => Ok([step, stage]),
    }
}

/// Orders the systems of the schedules and adds them to the world.
fn add_schedules(world: &mut World, schedules: [Schedule; 2]) -> Result<(), BuildError> {
    let mut added = Schedules::default();
    for mut schedule in schedules {
        schedule
            .initialize(world)
            .map_err(|error| BuildError::Schedule(error.to_string(schedule.graph(), world)))?;
        added.insert(schedule);
    }
    world.insert_resource(added);
    Ok(())
}
