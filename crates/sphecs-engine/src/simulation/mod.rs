//! Simulation: a world with its particles, and the schedules of a step.
//!
//! - `builder`: scene, initial state and plugins
//! - `ranks`: the ranks that share the passes
//! - `readings`: what is read between two steps
//! - `stop`: reasons for which a simulation cannot continue

mod builder;
mod ranks;
mod readings;
mod stop;

use std::sync::Arc;

use bevy_ecs::world::World;
use glam::DVec3;

pub use builder::{BuildError, SimulationBuilder};
pub use stop::{Stop, StopRequest};

use self::ranks::{Command, Connection};
use self::readings::Readiness;
use crate::arrays::Arrays;
use crate::particle_state::{self, ParticleState};
use crate::particle_table::ParticleTable;
use crate::resources::clock::Clock;
use crate::resources::ledger::Ledger;
use crate::resources::pair::Pair;
use crate::resources::state_location;
use crate::resources::stopwatch::Stopwatch;
use crate::saved_state::{SavedResources, particles};
use crate::schedule::Step;
use crate::systems::body_forces::{Bodies, BodyForcesRow};
use crate::systems::boundaries::outlet_diagnostics::OutletDiagnostics;
use crate::systems::divergence::{DivergedParticle, Failure};
use crate::systems::monitor::{self, MonitorRow};
use crate::systems::sampling;
use sphecs_core::math::column::Columns;
pub use sphecs_core::particles::sample::Sample;
use sphecs_core::pass::grid_rows::{NodeRow, RowSink};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::division::Division;
use sphecs_core::pass::ranks::shares::Share;
use sphecs_core::pass::section::Section;
use sphecs_core::pass::surface_flow::{SurfaceFlow, SurfacePoint};
use sphecs_scene::model::{ProbeSight, Scene, Scheme};

/// Simulation of a scene.
pub struct Simulation {
    world: World,
    scene: Arc<Scene>,
    functions: TypedFunctions,
    /// Preparations for reading the present state.
    readiness: Readiness,
    connection: Connection,
}

/// Functions compiled for the precision and the dimensions of the scene.
#[derive(Clone, Copy)]
struct TypedFunctions {
    scatter: fn(&mut World),
    save: fn(&mut World, &mut Columns),
    save_all: fn(&mut World, &mut Columns),
    visit: fn(&mut World, &mut dyn FnMut(&ParticleState)),
    refresh: fn(&mut World),
    collect: fn(&mut World),
    table: fn(&World) -> ParticleTable,
    monitor_row: fn(&mut World) -> MonitorRow,
    gather: fn(&mut World),
    sample: fn(&World, &[(DVec3, ProbeSight)]) -> Vec<Option<Sample>>,
    pressure: fn(&World, &[(DVec3, ProbeSight)]) -> Vec<Option<f64>>,
    sample_rows: fn(&World, &[NodeRow], &mut [&mut dyn RowSink], bool),
    sample_surface: fn(&World, &[SurfacePoint], f64) -> Vec<Option<SurfaceFlow>>,
    mass_flows: fn(&World, &[&Section]) -> Vec<f64>,
    shares: fn(&mut World, usize) -> Vec<Share>,
    divide: fn(&World, usize) -> Division,
    part: fn(&mut World, &Division, usize, &mut Columns),
    keep_part: fn(&mut World, &Division),
}

impl TypedFunctions {
    fn new<R: PairReal<D>, const D: usize>(scene: &Scene) -> Self {
        Self {
            scatter: state_location::scatter::<R, D>,
            save: particles::save::<R, D>,
            save_all: particles::save_all::<R, D>,
            visit: particle_state::visit::<R, D>,
            refresh: match scene.scheme {
                Scheme::Wcsph(_) => sampling::refresh::<R, D>,
                Scheme::EdacTvf(_) => sampling::refresh_volumes::<R, D>,
            },
            collect: sampling::collect::<R, D>,
            table: |world| ParticleTable::of(&world.resource::<Arrays<R, D>>().0),
            monitor_row: monitor::monitor_row::<R, D>,
            gather: state_location::gather::<R, D>,
            sample: sampling::sample::<R, D>,
            pressure: sampling::pressure::<R, D>,
            sample_rows: sampling::sample_rows::<R, D>,
            sample_surface: sampling::sample_surface::<R, D>,
            mass_flows: sampling::mass_flows::<R, D>,
            shares: ranks::shares_of::<R, D>,
            divide: ranks::divide::<R, D>,
            part: ranks::save_part::<R, D>,
            keep_part: ranks::keep_part::<R, D>,
        }
    }
}

impl Simulation {
    /// Returns a builder of a simulation of this scene.
    ///
    /// ```no_run
    /// # use sphecs_engine::simulation::{BuildError, Simulation};
    /// # fn build(scene: sphecs_scene::model::Scene) -> Result<Simulation, BuildError> {
    /// let simulation = Simulation::builder(scene).build()?;
    /// # Ok(simulation)
    /// # }
    /// ```
    pub fn builder(scene: Scene) -> SimulationBuilder {
        SimulationBuilder::new(scene)
    }

    /// Returns everything that the next steps and their output depend on: the contents of a
    /// checkpoint.
    ///
    /// Later steps are bitwise identical whether it is called or not.
    pub fn state(&mut self) -> Columns {
        let mut state = Columns::default();
        if self.connection.is_shared() {
            self.begin_reading();
            self.connection.announce(Command::State);
            (self.functions.save_all)(&mut self.world, &mut state);
        } else {
            (self.functions.save)(&mut self.world, &mut state);
        }
        SavedResources::save(&self.world, &mut state);
        state
    }

    /// Advances by one time step.
    ///
    /// # Errors
    /// [`Stop`] if the flow diverged or an inlet found no particle. The world keeps the state of
    /// that step.
    pub fn step(&mut self) -> Result<(), Stop> {
        self.connection.announce(Command::Step);
        self.own_step()
    }

    /// Takes a step on this rank.
    fn own_step(&mut self) -> Result<(), Stop> {
        self.world.resource::<Pair>().0.ranks.begin_step();
        self.world.resource_mut::<Stopwatch>().start();
        self.readiness = Readiness::default();
        let world = &mut self.world;
        // On a thread of the pool: from any other thread, each parallel loop would wake the pool
        // and wait for it.
        rayon::scope(|_| world.run_schedule(Step));
        self.world.resource::<Pair>().0.ranks.end_step();
        // Otherwise bevy's list of removed components and resources grows with every step.
        self.world.clear_trackers();
        self.stop_reason().map_or(Ok(()), Err)
    }

    /// Returns the reason to stop that the last step found.
    fn stop_reason(&self) -> Option<Stop> {
        let Clock { step, time, .. } = self.clock();
        if let Some(reason) = self.world.get_resource::<StopRequest>().and_then(StopRequest::reason) {
            return Some(Stop::Requested { step, time, reason: reason.to_owned() });
        }
        let failure = self.world.resource::<Failure>();
        if let Some(particle) = &failure.diverged {
            return Some(Stop::Diverged { step, time, found: particle.describe(), advice: particle.advice });
        }
        if let Some(inlet) = failure.drained {
            let inlet = self.scene.inlets[usize::from(inlet)].patch.name.clone();
            return Some(Stop::Drained { step, time, inlet });
        }
        failure.reservoir_empty.then_some(Stop::ReservoirEmpty { step, time })
    }

    /// Advances until the first time at or after `time`, s.
    ///
    /// # Errors
    /// [`Stop`] as for [`Self::step`].
    pub fn run_until(&mut self, time: f64) -> Result<(), Stop> {
        while self.clock().time < time {
            self.step()?;
        }
        Ok(())
    }

    /// Returns the scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Returns the scene as a reference of its own, which lets the simulation be changed beside
    /// it.
    pub fn shared_scene(&self) -> Arc<Scene> {
        Arc::clone(&self.scene)
    }

    /// Returns time, step and step size.
    pub fn clock(&self) -> Clock {
        *self.world.resource::<Clock>()
    }

    /// Returns the particle with an impossible value that stopped the flow, with the particles
    /// around it.
    pub fn diverged_particle(&self) -> Option<&DivergedParticle> {
        self.world.resource::<Failure>().diverged.as_ref()
    }

    /// Returns the notes on outlets that do not behave as intended, in the order of their
    /// detection.
    pub fn notes(&self) -> &[String] {
        &self.world.resource::<OutletDiagnostics>().notes
    }

    /// Returns the particle counts.
    pub fn ledger(&self) -> &Ledger {
        self.world.resource::<Ledger>()
    }

    /// Returns force and torque of the fluid on the bodies of the scene at the beginning of the
    /// last step.
    pub fn body_forces(&self) -> &BodyForcesRow {
        &self.world.resource::<Bodies>().row
    }

    /// Returns name and wall-clock seconds of each set, in the order of the step.
    pub fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.world.resource::<Stopwatch>().table()
    }
}
