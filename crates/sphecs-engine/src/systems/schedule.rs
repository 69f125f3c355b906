//! The two schedules of a simulation and their sets.
//!
//! A step runs [`Step`]; its `Advance` set runs [`Stage`] as often as the integrator asks (Verlet: once).
//! Sets are chained, systems inside a set are not: two systems of one set that touch the same data are an error.

use bevy_ecs::schedule::{
    IntoScheduleConfigs, LogLevel, Schedule, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor,
    SystemSet,
};
use bevy_ecs::system::ResMut;

use super::stopwatch::Stopwatch;

/// One time step.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// One evaluation of the rates.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stage;

/// The sets of [`Step`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepSystems {
    /// 1. Components that a caller changed go to the arrays.
    Gather,
    /// 2. The stage: rates, then the kick.
    Advance,
    /// 3. Fluid particles are moved towards an even distribution, and held at the walls.
    Shift,
    /// 4. Particles change zone: the only structural changes.
    Transition,
    /// 5. Checks and counts. A system of one's own that watches the flow goes here.
    Observe,
}

/// The sets of [`Stage`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageSystems {
    /// 1. Cell grid, sorted arrays, distances to the walls.
    Neighbours,
    /// 2. Density of the fluid by summation, pressure by Tait.
    Density,
    /// 3. Velocity and pressure of inflow, outflow and wall particles.
    Boundary,
    /// 4. Velocity gradients and sub-particle stress.
    Gradients,
    /// 5. Pair forces, and the rates of outflow particles.
    Rates,
    /// 6. Body force. A force of one's own goes here: see [`AddedForces`](super::forces::AddedForces).
    Forces,
    /// 7. Time step, new velocities and positions.
    Kick,
}

const STEP_ORDER: [(StepSystems, &str); 5] = [
    (StepSystems::Gather, "gather"),
    (StepSystems::Advance, "advance"),
    (StepSystems::Shift, "shift"),
    (StepSystems::Transition, "transition"),
    (StepSystems::Observe, "observe"),
];

const STAGE_ORDER: [(StageSystems, &str); 7] = [
    (StageSystems::Neighbours, "neighbours"),
    (StageSystems::Density, "density"),
    (StageSystems::Boundary, "boundary"),
    (StageSystems::Gradients, "gradients"),
    (StageSystems::Rates, "rates"),
    (StageSystems::Forces, "forces"),
    (StageSystems::Kick, "kick"),
];

/// Labels of the stopwatch in the order of a step; `advance` itself is the sum of its stages.
pub const TIMED: [&str; 11] = [
    "gather",
    "neighbours",
    "density",
    "boundary",
    "gradients",
    "rates",
    "forces",
    "kick",
    "shift",
    "transition",
    "observe",
];

/// A set of systems that only read the stopwatch, one after each set of physics.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Lap(&'static str);

fn lap_index(name: &str) -> usize {
    TIMED.iter().position(|timed| *timed == name).unwrap_or(TIMED.len() - 1)
}

fn empty<L: ScheduleLabel>(label: L) -> Schedule {
    let mut schedule = Schedule::new(label);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..ScheduleBuildSettings::default()
    });
    schedule
}

fn chain<S: SystemSet + Copy>(schedule: &mut Schedule, order: &[(S, &'static str)]) {
    for window in order.windows(2) {
        schedule.configure_sets(window[0].0.before(window[1].0));
    }
    for (position, &(set, name)) in order.iter().enumerate() {
        if name == "advance" {
            continue;
        }
        let index = lap_index(name);
        schedule.configure_sets(Lap(name).after(set));
        if let Some(&(next, _)) = order.get(position + 1) {
            schedule.configure_sets(Lap(name).before(next));
        }
        schedule
            .add_systems((move |mut stopwatch: ResMut<Stopwatch>| stopwatch.lap(index)).in_set(Lap(name)));
    }
}

/// An empty [`Step`] schedule with its sets in order.
pub fn step_schedule() -> Schedule {
    let mut schedule = empty(Step);
    chain(&mut schedule, &STEP_ORDER);
    schedule
}

/// An empty [`Stage`] schedule with its sets in order.
pub fn stage_schedule() -> Schedule {
    let mut schedule = empty(Stage);
    chain(&mut schedule, &STAGE_ORDER);
    schedule
}
