//! Flows with a known answer, driven as a user of the library drives them.
//!
//! * [`inlets`]: the pressure that an inlet takes from the fluid
//! * [`junction`]: two outlets at once
//! * [`metered`]: inlets by the mass they bring
//! * [`periodic`]: conservation, decay and stability without walls
//! * [`rest`]: what must not move, and water under gravity
//! * [`bodies`]: force and torque on what the fluid flows round
//! * [`channel`]: flows along plane walls, against their exact solutions
//! * [`edac`]: the scheme with an evolved pressure
//! * [`walls`]: every wall model, plane and curved
//! * [`slip`]: free-slip walls of every model
//! * [`shipped`]: the shipped scenes at their smoke spacings, step by step

mod bodies;
mod channel;
mod edac;
mod inlets;
mod junction;
mod metered;
mod periodic;
mod rest;
mod shipped;
mod slip;
mod walls;

use std::path::{Path, PathBuf};

use sphecs::bevy_ecs::query::With;
use sphecs::components::{Fluid, ParticleId, Position, Thermodynamics, Velocity};
use sphecs::glam::DVec3;
use sphecs::scene::Scene;
use sphecs::simulation::Simulation;

/// A fluid particle.
#[derive(Clone, Copy, Debug)]
struct State {
    id: ParticleId,
    /// m.
    position: DVec3,
    /// m/s.
    velocity: DVec3,
    /// kg/m³.
    density: f64,
    /// Pa.
    pressure: f64,
}

/// The fluid particles by number.
fn fluid(simulation: &mut Simulation) -> Vec<State> {
    let world = simulation.world_mut();
    let mut query =
        world.query_filtered::<(&ParticleId, &Position, &Velocity, &Thermodynamics), With<Fluid>>();
    let mut states: Vec<State> = query
        .iter(world)
        .map(|(&id, position, velocity, thermodynamics)| State {
            id,
            position: position.0,
            velocity: velocity.0,
            density: thermodynamics.density,
            pressure: thermodynamics.pressure,
        })
        .collect();
    states.sort_by_key(|state| state.id);
    states
}

/// A simulation of a scene in this crate's tests.
fn flow(text: &str, pairs: &[(&str, &str)]) -> Simulation {
    Simulation::from_scene(
        Scene::from_text("flow", text).sets(pairs).load().unwrap_or_else(|faults| panic!("{faults:?}")),
    )
}

/// The path of a shipped scene.
fn shipped_path(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes").join(name)
}

/// A simulation of a shipped scene with values of one's own.
fn shipped_flow(name: &str, pairs: &[(&str, &str)]) -> Simulation {
    let scene = Scene::from_file(&shipped_path(name)).sets(pairs).load();
    Simulation::from_scene(scene.unwrap_or_else(|faults| panic!("{name}: {faults:?}")))
}

/// A simulation of a shipped scene at its smoke spacing.
fn smoke(name: &str, pairs: &[(&str, &str)]) -> Simulation {
    let scene = Scene::from_file(&shipped_path(name)).smoke().sets(pairs).load();
    Simulation::from_scene(scene.unwrap_or_else(|faults| panic!("{name}: {faults:?}")))
}

/// Takes steps, and fails where the flow blows up.
#[track_caller]
fn advance(simulation: &mut Simulation, steps: u64) {
    for _ in 0..steps {
        simulation.step().unwrap_or_else(|stop| panic!("{stop}"));
    }
}
