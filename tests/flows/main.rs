//! Flows with known solutions, computed through the library.
//!
//! * [`inlets`]: pressure of inflow particles
//! * [`junction`]: two outlets
//! * [`metered`]: inlets with a prescribed mass flow
//! * [`periodic`]: conservation, decay and stability without walls
//! * [`rest`]: fluid at rest, hydrostatics
//! * [`bodies`]: force and torque on bodies
//! * [`channel`]: flows along plane walls and their exact solutions
//! * [`edac`]: the scheme `EdacTvf`
//! * [`emitters`]: surfaces through which fluid enters
//! * [`movers`]: walls that move
//! * [`walls`]: every wall model, plane and curved
//! * [`slip`]: free-slip walls of every model
//! * [`shipped`]: the shipped scenes at their smoke spacings, step by step

#[path = "../common/mod.rs"]
mod common;

mod bodies;
mod channel;
mod edac;
mod emitters;
mod inlets;
mod junction;
mod metered;
mod movers;
mod periodic;
mod rest;
mod shipped;
mod slip;
mod walls;

use common::{Sets, advance, file_scene, scene_path, simulation, smoke_scene, text_scene};
use sphecs::Simulation;
use sphecs::bevy_ecs::query::With;
use sphecs::glam::DVec3;
use sphecs_engine::components::{Fluid, ParticleId, Position, Thermodynamics, Velocity};

/// Fluid particle.
#[derive(Clone, Copy, Debug)]
struct State {
    id: ParticleId,
    /// Position, m.
    position: DVec3,
    /// Velocity, m/s.
    velocity: DVec3,
    /// Density, kg/m³.
    density: f64,
    /// Pressure, Pa.
    pressure: f64,
}

/// Returns the fluid particles by number.
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

/// Builds a simulation of a scene from text.
fn flow(text: &str, sets: Sets) -> Simulation {
    simulation(text_scene("flow", text, sets))
}

/// Builds a simulation of a shipped scene with changed values.
fn shipped_flow(name: &str, sets: Sets) -> Simulation {
    simulation(file_scene(&scene_path(name), sets))
}

/// Builds a simulation of a shipped scene at its smoke spacing.
fn smoke(name: &str, sets: Sets) -> Simulation {
    simulation(smoke_scene(&scene_path(name), sets))
}
