//! The two schedules of a simulation and their sets.
//!
//! A step runs [`Step`], whose `Advance` set runs [`Stage`] once per evaluation of the rates. Both
//! integrators evaluate them once per step. Sets are chained, systems inside a set are not: two
//! systems of one set that access the same data without an explicit order are an error.

use bevy_ecs::schedule::{
    IntoScheduleConfigs, LogLevel, Schedule, ScheduleBuildSettings, ScheduleLabel, SingleThreadedExecutor,
    SystemSet,
};
use bevy_ecs::system::ResMut;

use crate::resources::stopwatch::Stopwatch;

/// One time step.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Step;

/// One evaluation of the rates.
#[derive(ScheduleLabel, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stage;

/// Sets of [`Step`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StepSet {
    /// 1. Components that a caller changed are copied to the arrays.
    Gather,
    /// 2. The stage: rates, then the kick.
    Advance,
    /// 3. Fluid particles are shifted towards a uniform distribution, and projected back at walls.
    Shift,
    /// 4. Particles change zone: the only structural changes.
    Transition,
    /// 5. Checks and counts; the set for user systems that observe the flow.
    Observe,
}

/// Sets of [`Stage`], in the order in which they run.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum StageSet {
    /// 1. Cell grid, sorted arrays, distances to the walls.
    Neighbours,
    /// 2. Density by summation, pressure by the equation of state.
    Density,
    /// 3. Velocity and pressure of inflow, outflow and wall particles.
    Boundary,
    /// 4. Velocity gradients and sub-particle stress.
    Gradients,
    /// 5. Pair forces and the rates of outflow particles.
    Rates,
    /// 6. Body force; the set for user forces: see
    ///    [`AddedForces`](crate::systems::forces::AddedForces).
    Forces,
    /// 7. Time step, new velocities and positions.
    Kick,
}

impl StepSet {
    /// All sets, in the order in which they run.
    pub const ALL: [Self; 5] = [Self::Gather, Self::Advance, Self::Shift, Self::Transition, Self::Observe];

    /// Returns the name in tables of wall-clock times.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Gather => "gather",
            Self::Advance => "advance",
            Self::Shift => "shift",
            Self::Transition => "transition",
            Self::Observe => "observe",
        }
    }
}

impl StageSet {
    /// All sets, in the order in which they run.
    pub const ALL: [Self; 7] = [
        Self::Neighbours,
        Self::Density,
        Self::Boundary,
        Self::Gradients,
        Self::Rates,
        Self::Forces,
        Self::Kick,
    ];

    /// Returns the name in tables of wall-clock times.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Neighbours => "neighbours",
            Self::Density => "density",
            Self::Boundary => "boundary",
            Self::Gradients => "gradients",
            Self::Rates => "rates",
            Self::Forces => "forces",
            Self::Kick => "kick",
        }
    }
}

/// Number of timed sets: those of both schedules without `Advance`, which is the sum of its stages.
pub(crate) const TIMED_SETS: usize = StepSet::ALL.len() - 1 + StageSet::ALL.len();

/// Returns the names of the timed sets in the order of a step.
pub(crate) fn timed_names() -> impl Iterator<Item = &'static str> {
    StepSet::ALL.into_iter().flat_map(|set| {
        let stages: &[StageSet] = if set == StepSet::Advance { &StageSet::ALL } else { &[] };
        let own = (set != StepSet::Advance).then(|| set.name());
        own.into_iter().chain(stages.iter().map(|stage| stage.name()))
    })
}

/// Set of the system that reads the stopwatch after the timed set with this index.
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
struct Lap(usize);

/// Returns an empty [`Step`] schedule with its sets in order.
pub(crate) fn step_schedule() -> Schedule {
    let mut schedule = empty_schedule(Step);
    chain_sets(&mut schedule, &StepSet::ALL, StepSet::name);
    schedule
}

/// Returns an empty [`Stage`] schedule with its sets in order.
pub(crate) fn stage_schedule() -> Schedule {
    let mut schedule = empty_schedule(Stage);
    chain_sets(&mut schedule, &StageSet::ALL, StageSet::name);
    schedule
}

fn empty_schedule<L: ScheduleLabel>(label: L) -> Schedule {
    let mut schedule = Schedule::new(label);
    schedule.set_executor(SingleThreadedExecutor::new());
    schedule.set_build_settings(ScheduleBuildSettings {
        ambiguity_detection: LogLevel::Error,
        ..ScheduleBuildSettings::default()
    });
    schedule
}

/// Chains the sets, and reads the stopwatch after each set that is timed.
fn chain_sets<S: SystemSet + Copy>(schedule: &mut Schedule, sets: &[S], name: fn(S) -> &'static str) {
    for (position, &set) in sets.iter().enumerate() {
        let next = sets.get(position + 1).copied();
        if let Some(next) = next {
            schedule.configure_sets(set.before(next));
        }
        let Some(index) = timed_names().position(|timed| timed == name(set)) else { continue };
        schedule.configure_sets(Lap(index).after(set));
        if let Some(next) = next {
            schedule.configure_sets(Lap(index).before(next));
        }
        let read = move |mut stopwatch: ResMut<Stopwatch>| stopwatch.lap(index);
        schedule.add_systems(read.in_set(Lap(index)));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timed_sets_are_those_of_a_step_with_the_stage_in_place_of_advance() {
        let names: Vec<&str> = timed_names().collect();
        let stage = StageSet::ALL.map(StageSet::name);
        let expected = [&["gather"], &stage[..], &["shift", "transition", "observe"]].concat();
        assert_eq!(names, expected);
        assert_eq!(names.len(), TIMED_SETS);
    }
}
