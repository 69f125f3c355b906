//! Signs that an outlet condition does not suit the flow, each noted once during a run.
//!
//! Notes neither stop nor change a run. A condition without an anchor can let the stream
//! accelerate, trap sound or let the mean pressure drift for any length of time, without an
//! impossible particle ([`check_state`](crate::systems::divergence::check_state)).

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use serde::{Deserialize, Serialize};

use super::outlets::Outlets;
use crate::resources::clock::Clock;
use crate::resources::ledger::Ledger;
use crate::resources::scene::ActiveScene;
use sphecs_core::boundary::outlet::outflow_zone::settling_time;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::fits::PointFlow;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::{Outlet, Scene};

/// Share of the fluid that may be gained or lost. The density of the rest is as far off, and the
/// scheme is made for 1 %.
const CONTENT: f64 = 0.05;

/// Layers of particles that may enter before one leaves, or leave before one enters: a short
/// channel gains and loses as many all the time.
const LAYERS: f64 = 2.0;

/// Largest acoustic pressure at an outlet and largest drift of its mean pressure, over ρ0 c0². The
/// particle velocity of such a wave is half the velocity of a flow at Mach 0.1.
const PRESSURE: f64 = 0.05;

/// Normal velocity, over the reference velocity of the scene, at which the mean flow counts as
/// backflow.
const BACKFLOW: f64 = 0.02;

/// Condition whose pressure is anchored.
const ANCHORED: &str = "WaveEquation";

/// Diagnostics of the outlets of a scene.
#[derive(Resource, Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct OutletDiagnostics {
    /// Fluid particles after the first step.
    fluid: Option<u64>,
    content_noted: bool,
    outlets: Vec<OutletMeans>,
    /// Notes in the order in which they were made.
    pub notes: Vec<String>,
}

/// Means at an outlet over the time after which sound has left, and the notes that were made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct OutletMeans {
    velocity: f64,
    pressure: f64,
    /// Time over which the means were taken, s.
    age: f64,
    /// Mean pressure when the means had settled, Pa.
    level: Option<f64>,
    backflow_noted: bool,
    sound_noted: bool,
    level_noted: bool,
}

/// A sign that a condition does not suit the flow.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Finding {
    Backflow { velocity: f64 },
    Sound { pressure: f64 },
    Level { pressure: f64, before: f64 },
}

/// Bounds of the means at an outlet.
struct Bounds {
    /// ρ0 c0², Pa.
    stiffness: f64,
    /// Reference velocity of the scene, m/s.
    reference_velocity: f64,
    /// Time after which sound has left, s.
    settling: f64,
    /// True if backflow would re-enter with frozen or prescribed values.
    is_one_way: bool,
}

impl OutletMeans {
    /// Updates the means by a step and returns a sign that is found for the first time.
    fn update(&mut self, velocity: f64, pressure: f64, time_step: f64, bounds: &Bounds) -> Option<Finding> {
        self.age += time_step;
        let share = time_step / self.age.min(bounds.settling);
        self.velocity += share * (velocity - self.velocity);
        self.pressure += share * (pressure - self.pressure);
        if self.age < 2.0 * bounds.settling {
            return None;
        }
        let level = *self.level.get_or_insert(self.pressure);
        let largest = PRESSURE * bounds.stiffness;
        let first = |noted: &mut bool, is: bool| is && !std::mem::replace(noted, *noted || is);
        let flows_back = bounds.is_one_way && self.velocity < -BACKFLOW * bounds.reference_velocity;
        if first(&mut self.backflow_noted, flows_back) {
            return Some(Finding::Backflow { velocity: self.velocity });
        }
        if first(&mut self.sound_noted, (pressure - self.pressure).abs() > largest) {
            return Some(Finding::Sound { pressure: pressure - self.pressure });
        }
        if first(&mut self.level_noted, (self.pressure - level).abs() > largest) {
            return Some(Finding::Level { pressure: self.pressure, before: level });
        }
        None
    }
}

impl Finding {
    /// Returns the note: where it is, what is, what to do.
    fn text(self, outlet: &Outlet, number: usize, time: f64) -> String {
        let condition = outlet.condition.parameters().name();
        let better = if condition == ANCHORED {
            "its default pressure, `NonReflecting()`"
        } else {
            "`WaveEquation()`"
        };
        let place = format!("outlet {number}, `{condition}`, at t = {time:.3e} s:");
        match self {
            Finding::Backflow { velocity } => format!(
                "{place} backflow of mean normal velocity {velocity:.3e} m/s would enter with frozen or prescribed \
                 values; move the outlet downstream or take {better}"
            ),
            Finding::Sound { pressure } => format!(
                "{place} sound of {pressure:.3e} Pa, more than {:.0} % of ρ0 c0², does not leave; take {better}",
                100.0 * PRESSURE
            ),
            Finding::Level { pressure, before } => format!(
                "{place} the mean pressure has drifted from {before:.3e} to {pressure:.3e} Pa, the condition anchors \
                 none; take {better} or a slower start"
            ),
        }
    }
}

/// Returns the advice on a content that changes: another condition, or patience if all outlets
/// have the one that anchors the pressure.
fn content_advice(scene: &Scene) -> String {
    let is_anchored = |outlet: &Outlet| outlet.condition.parameters().name() == ANCHORED;
    if !scene.outlets.iter().all(is_anchored) {
        return "take `WaveEquation()`, which anchors the pressure".to_owned();
    }
    let settling = scene
        .outlets
        .iter()
        .map(|outlet| settling_time(scene.extent_along(outlet.patch.towards), scene.fluid.sound_speed))
        .fold(0.0, f64::max);
    format!(
        "the pressure of a start leaves within some {settling:.3e} s; begin means later, or start more slowly \
         or with `initial.velocity`"
    )
}

/// Returns the approximate number of particles in a layer of the inlets.
fn particles_per_layer(scene: &Scene, inflow: u64) -> f64 {
    let layers =
        scene.inlets.iter().map(|inlet| inlet.patch.depth / scene.spacing).fold(f64::INFINITY, f64::min);
    inflow as f64 / layers
}

/// Updates the diagnostics of the outlets after a step.
pub fn diagnose_outlets<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    ledger: Res<Ledger>,
    running: Res<Outlets<R, D>>,
    mut diagnostics: ResMut<OutletDiagnostics>,
) {
    let scene: &Scene = &scene.0;
    if scene.outlets.is_empty() || clock.step == 0 {
        return;
    }
    let OutletDiagnostics { fluid, content_noted, outlets, notes } = &mut *diagnostics;
    let now = ledger.count(Zone::Fluid);
    let before = *fluid.get_or_insert(now);
    let layer = particles_per_layer(scene, ledger.count(Zone::Inflow));
    let largest = (CONTENT * before as f64).max(LAYERS * layer);
    if (now as f64 - before as f64).abs() > largest && !*content_noted {
        *content_noted = true;
        let change = if now < before { "outflow exceeds inflow" } else { "inflow exceeds outflow" };
        notes.push(format!(
            "outlets, at t = {:.3e} s: the number of fluid particles has changed from {before} to {now}, {change}; {}",
            clock.time,
            content_advice(scene)
        ));
    }
    outlets.resize_with(scene.outlets.len(), OutletMeans::default);
    for (number, (outlet, running_outlet)) in scene.outlets.iter().zip(&running.all).enumerate() {
        let extent = scene.extent_along(outlet.patch.towards);
        let bounds = Bounds {
            stiffness: scene.fluid.density * scene.fluid.sound_speed.powi(2),
            reference_velocity: scene.reference_velocity,
            settling: settling_time(extent, scene.fluid.sound_speed),
            is_one_way: running.needs()[number].is_one_way,
        };
        let PointFlow { velocity, pressure, .. } = running_outlet.adjacent;
        let found = outlets[number].update(velocity, pressure, clock.time_step, &bounds);
        if let Some(found) = found {
            notes.push(found.text(outlet, number, clock.time));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BOUNDS: Bounds =
        Bounds { stiffness: 1e5, reference_velocity: 1.0, settling: 1.0, is_one_way: true };

    /// Returns the signs that are found in a flow over 20 s.
    fn found(velocity: impl Fn(f64) -> f64, pressure: impl Fn(f64) -> f64, bounds: &Bounds) -> Vec<Finding> {
        let mut means = OutletMeans::default();
        let times = (1..=2000).map(|step| 0.01 * f64::from(step));
        times.filter_map(|t| means.update(velocity(t), pressure(t), 0.01, bounds)).collect()
    }

    #[test]
    fn a_flow_with_ordinary_sound_gets_no_note() {
        assert_eq!(found(|_| 1.0, |t| 300.0 + 2e3 * (20.0 * t).sin(), &BOUNDS), []);
        // The start may be loud, and a steady pressure may have any value.
        assert_eq!(found(|_| 1.0, |t| 2e4 + 2e4 * (20.0 * t).sin() * (-5.0 * t).exp(), &BOUNDS), []);
    }

    #[test]
    fn growing_sound_a_drifting_mean_pressure_and_backflow_are_noted_once() {
        let sound = found(|_| 1.0, |t| 1e3 * t * (20.0 * t).sin(), &BOUNDS);
        assert!(matches!(sound[..], [Finding::Sound { pressure }] if pressure.abs() > 5e3), "{sound:?}");
        let level = found(|_| 1.0, |t| -600.0 * t, &BOUNDS);
        assert!(
            matches!(level[..], [Finding::Level { pressure, before }] if pressure < before - 5e3),
            "{level:?}"
        );
        let back = found(|t| (1.0 - 0.2 * t).max(-0.1), |_| 0.0, &BOUNDS);
        assert!(matches!(back[..], [Finding::Backflow { velocity }] if velocity < -0.02), "{back:?}");
        let two_ways = Bounds { is_one_way: false, ..BOUNDS };
        assert_eq!(found(|_| -0.1, |_| 0.0, &two_ways), []);
    }
}
