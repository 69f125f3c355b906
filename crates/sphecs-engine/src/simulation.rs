//! A running simulation: the world, its schedules and the plugin list.

use std::sync::Arc;

use bevy_ecs::schedule::Schedules;
use bevy_ecs::world::World;
use glam::DVec3;

use crate::systems::bodies::{Bodies, BodyForcesRow};
use crate::systems::boundaries::outlet_diagnostics::OutletDiagnostics;
use crate::systems::boundaries::outlets::insert_outlets;
use crate::systems::checkpoint::{Kept, particles};
use crate::systems::clock::Clock;
use crate::systems::core_plugins::{
    BoundaryPlugin, EdacTvfPlugin, NeighboursPlugin, ObservePlugin, WcsphPlugin,
};
use crate::systems::failure::{Failure, Fault};
use crate::systems::home::{self, FreshHome};
use crate::systems::ledger::Ledger;
use crate::systems::monitor::{self, MonitorRow};
use crate::systems::neighbours::{Grid, scene_grid};
use crate::systems::pair::{Pair, pair_settings};
use crate::systems::plugin::{Parts, Plugin};
use crate::systems::readings;
use crate::systems::schedule::{Step, stage_schedule, step_schedule};
use crate::systems::setup::{Resolution, SceneInUse, insert_registers, spawn_particles};
use crate::systems::stopwatch::Stopwatch;
use sphecs_core::math::column::{Columns, Misfit};
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
pub use sphecs_core::particles::sample::Sample;
use sphecs_core::pass::section::Section;
use sphecs_scene::model::{ParticleSeed, Precision, ProbeSight, Scene, Scheme};
use sphecs_scene::spawn;

/// A scene in motion.
pub struct Simulation {
    world: World,
    scene: Arc<Scene>,
    typed: Typed,
    /// Whether the arrays are sorted, and have the density, at the present positions: a row of the monitor, probes and a frame of one time
    /// are read from the same.
    is_refreshed: bool,
}

/// The functions that know precision and dimension, chosen once.
#[derive(Clone, Copy)]
struct Typed {
    scatter: fn(&mut World),
    save: fn(&mut World, &mut Columns),
    refresh: fn(&mut World),
    monitor_row: fn(&mut World) -> MonitorRow,
    gather: fn(&mut World),
    sample: fn(&World, &[(DVec3, ProbeSight)]) -> Vec<Option<Sample>>,
    mass_flows: fn(&World, &[&Section]) -> Vec<f64>,
}

/// What a world begins with.
enum Start {
    /// The particles of the scene.
    Seeds(Vec<ParticleSeed>),
    /// A state that was kept.
    State(Columns),
}

impl Start {
    fn grid<const D: usize>(&mut self, scene: &Scene, pair: &Pair) -> Result<CellGrid<D>, Misfit> {
        match self {
            Start::Seeds(seeds) => Ok(scene_grid(scene, &pair.0, seeds)),
            Start::State(state) => particles::restore_grid(scene, pair, state),
        }
    }
}

/// Why a run cannot go on.
#[derive(Clone, Debug, thiserror::Error)]
pub enum Stop {
    /// The flow blew up.
    #[error("the flow blew up at step {step}, t = {time:.6} s: {what}")]
    BlowUp {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Particle, zone, position and what was found.
        what: String,
        /// What a user can do about it.
        cure: &'static str,
    },
    /// An inlet that is filled once has nothing left.
    #[error("{inlet} is drained at step {step}, t = {time:.6} s")]
    Drained {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
        /// Name of the inlet.
        inlet: String,
    },
    /// An inlet found the reservoir empty and the scene says to stop.
    #[error("the reservoir is empty at step {step}, t = {time:.6} s")]
    ReservoirEmpty {
        /// Step.
        step: u64,
        /// Time, s.
        time: f64,
    },
}

impl Simulation {
    /// Builds the world of a scene, ready for its first step.
    pub fn from_scene(scene: Scene) -> Self {
        Self::with_plugins(scene, &[])
    }

    /// Builds the world of a scene with plugins of one's own, which come after those of the engine.
    pub fn with_plugins(scene: Scene, plugins: &[&dyn Plugin]) -> Self {
        let seeds = spawn::seeds(&scene);
        Self::from_seeds(scene, seeds, plugins)
    }

    /// Builds the world of a scene with these particles, which are those of [`scene::seeds`](sphecs_scene::seeds), moved or with other velocities.
    pub fn from_seeds(scene: Scene, seeds: Vec<ParticleSeed>, plugins: &[&dyn Plugin]) -> Self {
        match Self::of_scene(scene, Start::Seeds(seeds), plugins) {
            Ok(simulation) => simulation,
            // Only columns can misfit.
            Err(misfit) => unreachable!("a scene gives its own start: {misfit}"),
        }
    }

    /// Builds the world of a scene in the state that [`Self::state`] gave of the same scene with the same plugins: it goes on to the
    /// same bits, with any number of threads.
    ///
    /// # Errors
    /// [`Misfit`] when the state is not one of this scene and these plugins.
    pub fn from_state(scene: Scene, state: Columns, plugins: &[&dyn Plugin]) -> Result<Self, Misfit> {
        Self::of_scene(scene, Start::State(state), plugins)
    }

    fn of_scene(scene: Scene, start: Start, plugins: &[&dyn Plugin]) -> Result<Self, Misfit> {
        match (scene.precision, scene.dimensions) {
            (Precision::F64, 2) => Self::build::<f64, 2>(scene, start, plugins),
            (Precision::F64, _) => Self::build::<f64, 3>(scene, start, plugins),
            (Precision::F32, 2) => Self::build::<f32, 2>(scene, start, plugins),
            (Precision::F32, _) => Self::build::<f32, 3>(scene, start, plugins),
        }
    }

    fn build<R: Real, const D: usize>(
        scene: Scene,
        mut start: Start,
        plugins: &[&dyn Plugin],
    ) -> Result<Self, Misfit> {
        let typed = std::marker::PhantomData::<R>;
        let scene = Arc::new(scene);
        let mut world = World::new();
        world.insert_resource(SceneInUse(scene.clone()));
        world.insert_resource(Resolution::of(&scene));
        let pair = Pair(pair_settings(&scene));
        world.insert_resource(Grid::<D>(start.grid(&scene, &pair)?));
        world.insert_resource(pair);
        let (mut step, mut stage) = (step_schedule(), stage_schedule());
        let mut parts = Parts { world: &mut world, step: &mut step, stage: &mut stage };
        let scheme: &dyn Plugin = match scene.scheme {
            Scheme::Wcsph(_) => &WcsphPlugin::<R, D>(typed),
            Scheme::EdacTvf(_) => &EdacTvfPlugin::<R, D>(typed),
        };
        let own: [&dyn Plugin; 4] = [
            &NeighboursPlugin::<R, D>(typed),
            scheme,
            &BoundaryPlugin::<R, D>(typed),
            &ObservePlugin::<R, D>(typed),
        ];
        for plugin in own.iter().chain(plugins) {
            plugin.build(&mut parts);
        }
        insert_registers(&mut parts);
        insert_outlets::<R, D>(&mut world, &scene).unwrap_or_else(|faults| panic!("{faults}"));
        let mut schedules = Schedules::default();
        schedules.insert(step);
        schedules.insert(stage);
        world.insert_resource(schedules);
        // Last: a resource is kept in a table of its own that reaches as far as its entity's index, 4 B a particle for each that
        // came after them.
        match start {
            Start::Seeds(seeds) => spawn_particles(&mut world, &scene, &seeds),
            Start::State(mut state) => {
                particles::restore::<R, D>(&mut world, &mut state)?;
                Kept::restore(&mut world, &mut state)?;
                particles::check_ledger(&mut world)?;
            }
        }
        Ok(Self {
            world,
            typed: Typed {
                scatter: home::scatter::<R, D>,
                refresh: match scene.scheme {
                    Scheme::Wcsph(_) => readings::refresh::<R, D>,
                    Scheme::EdacTvf(_) => readings::refresh_volumes::<R, D>,
                },
                save: particles::save::<R, D>,
                monitor_row: monitor::monitor_row::<R, D>,
                gather: home::gather::<R, D>,
                sample: readings::sample::<R, D>,
                mass_flows: readings::mass_flows::<R, D>,
            },
            scene,
            is_refreshed: false,
        })
    }

    /// Everything that the next step depends on, and every output: what a checkpoint holds. Reading it changes no bit of a run.
    pub fn state(&mut self) -> Columns {
        let mut state = Columns::default();
        (self.typed.save)(&mut self.world, &mut state);
        Kept::save(&self.world, &mut state);
        state
    }

    /// One time step.
    ///
    /// # Errors
    /// [`Stop`] when the flow blew up or an inlet found no particle; the world keeps the state found.
    pub fn step(&mut self) -> Result<(), Stop> {
        self.world.resource_mut::<Stopwatch>().start();
        self.is_refreshed = false;
        let world = &mut self.world;
        // On a thread of the pool: from outside, each parallel loop would wake the pool and sleep until it is done.
        rayon::scope(|_| world.run_schedule(Step));
        // bevy notes each removed component, and each resource taken out for a while, until it is told to forget.
        self.world.clear_trackers();
        let clock = self.clock();
        let failure = self.world.resource::<Failure>();
        if let Some(fault) = &failure.fault {
            return Err(Stop::BlowUp {
                step: clock.step,
                time: clock.time,
                what: format!(
                    "{} of {} particle {} at ({:.6}, {:.6}, {:.6}) m",
                    fault.found,
                    fault.zone.name(),
                    fault.id,
                    fault.position.x,
                    fault.position.y,
                    fault.position.z
                ),
                cure: fault.cure,
            });
        }
        if let Some(inlet) = failure.drained {
            let inlet = self.scene.inlets[usize::from(inlet)].patch.name.clone();
            return Err(Stop::Drained { step: clock.step, time: clock.time, inlet });
        }
        if failure.reservoir_empty {
            return Err(Stop::ReservoirEmpty { step: clock.step, time: clock.time });
        }
        Ok(())
    }

    /// Steps until the first time at or past `time`, s.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn run_until(&mut self, time: f64) -> Result<(), Stop> {
        while self.clock().time < time {
            self.step()?;
        }
        Ok(())
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// The world with all components brought up to date, density and pressure at the present positions. What a caller changes in the
    /// components is seen by the next step only after [`Self::world_mut`].
    pub fn world(&mut self) -> &World {
        self.bring_up_to_date();
        &self.world
    }

    /// The world, up to date; the next step starts from what the caller leaves in its components.
    pub fn world_mut(&mut self) -> &mut World {
        self.bring_up_to_date();
        self.is_refreshed = false;
        self.world.insert_resource(FreshHome::Components);
        &mut self.world
    }

    fn bring_up_to_date(&mut self) {
        self.refresh();
        (self.typed.scatter)(&mut self.world);
    }

    fn refresh(&mut self) {
        if !self.is_refreshed {
            (self.typed.refresh)(&mut self.world);
            self.is_refreshed = true;
        }
    }

    /// Time, step and step size.
    pub fn clock(&self) -> Clock {
        *self.world.resource::<Clock>()
    }

    /// The particle in an impossible state that made the flow stop, with what stood around it.
    pub fn fault(&self) -> Option<&Fault> {
        self.world.resource::<Failure>().fault.as_ref()
    }

    /// What outlets were seen to do that they should not, in the order in which it was found.
    pub fn notes(&self) -> &[String] {
        &self.world.resource::<OutletDiagnostics>().notes
    }

    /// The particle ledger.
    pub fn ledger(&self) -> &Ledger {
        self.world.resource::<Ledger>()
    }

    /// Integral figures at the present time; the mean mass flows are those since the previous call.
    pub fn monitor_row(&mut self) -> MonitorRow {
        self.refresh();
        (self.typed.monitor_row)(&mut self.world)
    }

    /// Force and torque of the fluid on the bodies of the scene, as the last step had them at its beginning.
    pub fn body_forces(&self) -> &BodyForcesRow {
        &self.world.resource::<Bodies>().row
    }

    /// Velocity (m/s), pressure (Pa) and density (kg/m³) of the fluid at points, by corrected kernel sums;
    /// None where no fluid is near.
    pub fn sample(&mut self, points: &[DVec3]) -> Vec<Option<Sample>> {
        let fluid: Vec<_> = points.iter().map(|&point| (point, ProbeSight::Fluid)).collect();
        self.sample_seeing(&fluid)
    }

    /// The same, of what is seen at each point.
    pub fn sample_seeing(&mut self, points: &[(DVec3, ProbeSight)]) -> Vec<Option<Sample>> {
        self.refresh();
        (self.typed.sample)(&self.world, points)
    }

    /// Mass flow through sections of the flow along their normals, kg/s (per metre of depth in 2D): of what moves, velocity and shift, where the scene
    /// has a section among its probes; else `Wcsph` keeps no shift, and flows are of velocities alone.
    pub fn mass_flows(&mut self, sections: &[&Section]) -> Vec<f64> {
        (self.typed.gather)(&mut self.world);
        (self.typed.mass_flows)(&self.world, sections)
    }

    /// Wall-clock seconds by stage: name and seconds, in the order of the step.
    pub fn stage_times(&self) -> Vec<(&'static str, f64)> {
        self.world.resource::<Stopwatch>().table()
    }
}
