//! What an outlet does to the flow before it that it should not: said once, while the run goes on.
//!
//! Nothing here stops a run or changes it. A condition that has no anchor can let the stream run away, keep sound or let the level of the pressure
//! wander for as long as one looks, without a particle that is impossible ([`check_state`](crate::systems::divergence::check_state)).

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use serde::{Deserialize, Serialize};

use super::absorb::settling_time;
use super::outlets::OutletStates;
use crate::resources::clock::Clock;
use crate::resources::ledger::Ledger;
use crate::resources::scene::ActiveScene;
use sphecs_core::particles::zone::Zone;
use sphecs_core::physics::outlet::OutletCondition;
use sphecs_scene::model::{Outlet, Scene};

/// Share of the fluid that may be gained or lost: the density of what stays is as far off, and the scheme is made for 1 %.
const CONTENT: f64 = 0.05;

/// Whole rows of particles that enter before one leaves, or leave before one enters: a short channel gains and loses as many all the time.
const ROWS: f64 = 2.0;

/// Pressure over ρ0 c0² that sound before an outlet, or a wandering level, may have: its velocity is half of a flow's at Mach 0.1.
const PRESSURE: f64 = 0.05;

/// Normal velocity over the scene's reference speed below which the flow comes back.
const BACKFLOW: f64 = 0.02;

/// What the outlets of a scene were seen to do.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletWatch {
    /// Fluid particles at the first look.
    fluid: Option<u64>,
    content_said: bool,
    outlets: Vec<Watched>,
    /// What was said, in its order.
    pub notes: Vec<String>,
}

/// One outlet: means over the time in which sound settles, and what was said of it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Watched {
    velocity: f64,
    pressure: f64,
    /// Time that the means are of, s.
    age: f64,
    /// The mean pressure when they had settled, Pa.
    level: Option<f64>,
    backflow_said: bool,
    sound_said: bool,
    level_said: bool,
}

/// What was found of an outlet.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Finding {
    Backflow { velocity: f64 },
    Sound { pressure: f64 },
    Level { pressure: f64, before: f64 },
}

/// Bounds for an outlet.
struct Bounds {
    /// ρ0 c0², Pa.
    stiffness: f64,
    /// m/s.
    reference_velocity: f64,
    /// s.
    settling: f64,
    /// Whether a flow that comes back finds nothing there that was made for it.
    one_way: bool,
}

impl Watched {
    /// Takes up a step; what is found for the first time is returned.
    fn look(&mut self, velocity: f64, pressure: f64, time_step: f64, bounds: &Bounds) -> Option<Finding> {
        self.age += time_step;
        let share = time_step / self.age.min(bounds.settling);
        self.velocity += share * (velocity - self.velocity);
        self.pressure += share * (pressure - self.pressure);
        if self.age < 2.0 * bounds.settling {
            return None;
        }
        let level = *self.level.get_or_insert(self.pressure);
        let most = PRESSURE * bounds.stiffness;
        let first = |said: &mut bool, is: bool| is && !std::mem::replace(said, *said || is);
        let comes_back = bounds.one_way && self.velocity < -BACKFLOW * bounds.reference_velocity;
        if first(&mut self.backflow_said, comes_back) {
            return Some(Finding::Backflow { velocity: self.velocity });
        }
        if first(&mut self.sound_said, (pressure - self.pressure).abs() > most) {
            return Some(Finding::Sound { pressure: pressure - self.pressure });
        }
        if first(&mut self.level_said, (self.pressure - level).abs() > most) {
            return Some(Finding::Level { pressure: self.pressure, before: level });
        }
        None
    }
}

impl Finding {
    fn text(self, outlet: &Outlet, number: usize, time: f64) -> String {
        let condition = outlet.condition.name();
        let of = format!("outlet {number}, `{condition}`, at t = {time:.4} s:");
        match self {
            Finding::Backflow { velocity } => format!(
                "{of} the flow comes back, mean normal velocity {velocity:.4} m/s, and finds nothing behind the plane that belongs to it; \
                 move the outlet downstream or take `WaveEquation()`"
            ),
            Finding::Sound { pressure } => format!(
                "{of} sound of {pressure:.0} Pa before it, as fast as half of a flow at Mach 0.1, does not leave; take `WaveEquation()`"
            ),
            Finding::Level { pressure, before } => format!(
                "{of} the mean pressure before it has gone from {before:.0} to {pressure:.0} Pa: the condition holds no level; take \
                 `WaveEquation()`, or a slower start"
            ),
        }
    }
}

/// Whether a flow that comes back has what left, frozen, or a reference of the stream alone.
fn is_one_way(condition: OutletCondition) -> bool {
    match condition {
        OutletCondition::WaveEquation { .. }
        | OutletCondition::Orlanski { .. }
        | OutletCondition::Mirror { .. } => false,
        OutletCondition::DoNothing
        | OutletCondition::ModifiedDoNothing { .. }
        | OutletCondition::Hybrid { .. } => true,
        // A stream that is meant to come in has its reference.
        OutletCondition::Characteristic { velocity, .. } => velocity >= 0.0,
    }
}

/// Particles that enter at once, about.
fn row_of_inlets(scene: &Scene, inflow: u64) -> f64 {
    let layers =
        scene.inlets.iter().map(|inlet| inlet.patch.depth / scene.spacing).fold(f64::INFINITY, f64::min);
    inflow as f64 / layers
}

/// Looks at the outlets after the step.
pub fn watch_outlets(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    ledger: Res<Ledger>,
    states: Res<OutletStates>,
    mut watch: ResMut<OutletWatch>,
) {
    let scene: &Scene = &scene.0;
    if scene.outlets.is_empty() || clock.step == 0 {
        return;
    }
    let OutletWatch { fluid, content_said, outlets, notes } = &mut *watch;
    let now = ledger.count(Zone::Fluid);
    let before = *fluid.get_or_insert(now);
    let most = (CONTENT * before as f64).max(ROWS * row_of_inlets(scene, ledger.count(Zone::Inflow)));
    if (now as f64 - before as f64).abs() > most && !*content_said {
        *content_said = true;
        let way = if now < before { "more leaves than comes in" } else { "less leaves than comes in" };
        notes.push(format!(
            "outlets, at t = {:.4} s: {before} fluid particles have become {now}, {way}; a condition with an anchor is `WaveEquation()`",
            clock.time
        ));
    }
    outlets.resize_with(scene.outlets.len(), Watched::default);
    for (number, (outlet, state)) in scene.outlets.iter().zip(&states.0).enumerate() {
        let bounds = Bounds {
            stiffness: scene.fluid.density * scene.fluid.sound_speed.powi(2),
            reference_velocity: scene.reference_velocity,
            settling: settling_time(scene, outlet),
            one_way: is_one_way(outlet.condition),
        };
        let found =
            outlets[number].look(state.fluid_velocity, state.fluid_pressure, clock.time_step, &bounds);
        if let Some(found) = found {
            notes.push(found.text(outlet, number, clock.time));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds = Bounds { stiffness: 1e5, reference_velocity: 1.0, settling: 1.0, one_way: true };

    /// What is found of a flow over 20 s.
    fn found(velocity: impl Fn(f64) -> f64, pressure: impl Fn(f64) -> f64, bounds: &Bounds) -> Vec<Finding> {
        let mut watched = Watched::default();
        let times = (1..=2000).map(|step| 0.01 * f64::from(step));
        times.filter_map(|t| watched.look(velocity(t), pressure(t), 0.01, bounds)).collect()
    }

    #[test]
    fn a_flow_with_the_usual_sound_is_not_worth_a_word() {
        assert_eq!(found(|_| 1.0, |t| 300.0 + 2e3 * (20.0 * t).sin(), &BOUNDS), []);
        // The start may be loud, and a steady pressure as high as it likes.
        assert_eq!(found(|_| 1.0, |t| 2e4 + 2e4 * (20.0 * t).sin() * (-5.0 * t).exp(), &BOUNDS), []);
    }

    #[test]
    fn sound_that_grows_a_level_that_wanders_and_a_flow_that_comes_back_are_said_once() {
        let sound = found(|_| 1.0, |t| 1e3 * t * (20.0 * t).sin(), &BOUNDS);
        assert!(matches!(sound[..], [Finding::Sound { pressure }] if pressure.abs() > 5e3), "{sound:?}");
        let level = found(|_| 1.0, |t| -600.0 * t, &BOUNDS);
        assert!(
            matches!(level[..], [Finding::Level { pressure, before }] if pressure < before - 5e3),
            "{level:?}"
        );
        let back = found(|t| (1.0 - 0.2 * t).max(-0.1), |_| 0.0, &BOUNDS);
        assert!(matches!(back[..], [Finding::Backflow { velocity }] if velocity < -0.02), "{back:?}");
        let two_ways = Bounds { one_way: false, ..BOUNDS };
        assert_eq!(found(|_| -0.1, |_| 0.0, &two_ways), []);
    }
}
