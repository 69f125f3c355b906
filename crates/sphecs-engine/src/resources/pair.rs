//! Settings of the pair sums, derived from a scene.

use bevy_ecs::resource::Resource;

use sphecs_core::pass::settings::{PairSettings, PressureLaw, WallPartSettings};
use sphecs_core::physics::shifting::Shifting;
use sphecs_core::physics::wall::Slip;
use sphecs_scene::model::{BodyForce, Scene, Scheme};

/// Settings of the pair sums.
#[derive(Resource, Clone, Debug)]
pub struct Pair(pub PairSettings);

/// Returns the settings of a scene.
pub(crate) fn pair_settings(scene: &Scene) -> PairSettings {
    let scheme = &scene.scheme;
    let mut pair = PairSettings::new(&scene.discretisation, scene.fluid.tait());
    pair.viscosity = scene.fluid.viscosity;
    match scheme {
        Scheme::Wcsph(scheme) => {
            pair.viscous_term = scheme.viscosity;
            pair.noise_damping = scheme.noise_damping.alpha();
            pair.shifting = scheme.shifting;
            pair.tensile_control = scheme.tensile_control;
        }
        Scheme::EdacTvf(scheme) => {
            pair.pressure = PressureLaw::Evolved(scheme.terms);
            // The transport velocity replaces shifting, and the mean pressure p̄ replaces the
            // tensile control.
            pair.shifting = Shifting::NONE;
            pair.tensile_control = false;
        }
    }
    pair.wall_model = scene.walls.model;
    if let BodyForce::Constant(force) = scene.body_force {
        pair.body_force = force.to_array();
    }
    pair.wall_parts = scene
        .walls
        .parts
        .iter()
        .map(|part| WallPartSettings {
            free_slip: part.slip.is_free_in_pairs(),
            wall_function: part.slip == Slip::WallFunction,
        })
        .collect();
    pair
}
