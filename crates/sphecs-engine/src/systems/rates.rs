//! Density, gradients and pair forces: the systems that call the hot passes.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use serde::{Deserialize, Serialize};

use super::neighbours::Grid;
use super::pair::Pair;
use super::setup::SceneInUse;
use crate::arrays::Arrays;
use sphecs_core::math::real::Real;
use sphecs_core::pass::density;
use sphecs_core::pass::gradients;
use sphecs_core::pass::rates::{self, VelocityLevel};
use sphecs_core::pass::sums::PairSums;
use sphecs_core::pass::{strain, stress, wall_friction};
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;
use sphecs_scene::model::Wcsph;

/// Sums of the pair pass that are not part of the state.
#[derive(Resource, Default)]
pub struct Sums<R: Real, const D: usize>(pub PairSums<R, D>);

/// Extremes that the pair pass found.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RatesFound {
    /// Largest c_a + max_b |h x·v/(r² + η²)|, m/s.
    pub largest_signal: f64,
    /// Largest speed of a fluid particle, m/s.
    pub largest_speed: f64,
    /// Largest |∇·v|, 1/s.
    pub largest_divergence: f64,
    /// Largest kinematic viscosity, eddy viscosity included, m²/s.
    pub largest_viscosity: f64,
    /// Largest rate at which the viscous term damps a particle, 1/s; under `Wcsph` of those with no wall in their support.
    pub largest_damping: f64,
    /// Largest one of those with a wall in their support, 1/s; 0 where the pressure evolves.
    pub largest_damping_at_walls: f64,
}

/// Steps since the last plain one; 0: the present step is plain, as the first and then every so many are, and all of kick–drift–kick.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct StepsSincePlain(pub u32);

/// The velocities that the dissipative terms take in the present step: see `physics/integrator/verlet.rs`.
pub fn level(since_plain: StepsSincePlain) -> VelocityLevel {
    if since_plain.0 == 0 { VelocityLevel::Present } else { VelocityLevel::Previous }
}

/// Whether a particle's neighbours are asked for their velocity gradient.
fn needs_strain(scheme: &Wcsph) -> bool {
    let shifting = scheme.shifting;
    scheme.noise_damping != NoiseDamping::Off || shifting.carries_velocity() || !shifting.keeps_drift()
}

/// Density of fluid particles by summation, pressure by Tait; on the way the velocity gradient among the neighbours, where
/// noise is damped or shifting carries velocities or no mass.
pub fn sum_density<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_plain: Res<StepsSincePlain>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    if scene.0.scheme.wcsph().is_some_and(needs_strain) {
        strain::sum_density_and_strain(&pair.0, &grid.0, &mut arrays, level(*since_plain), &mut sums.0);
    } else {
        density::sum_density(&pair.0, &grid.0, &mut arrays, &mut sums.0);
    }
}

/// Velocity gradients and sub-particle stress, in a scene that has it.
pub fn sum_gradients<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_plain: Res<StepsSincePlain>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
) {
    if !scene.0.scheme.has_stress() {
        return;
    }
    gradients::sum_gradients(&pair.0, &grid.0, &arrays, level(*since_plain), &mut sums.0);
    stress::find_stress(&pair.0, &grid.0, &arrays, &mut sums.0);
}

/// Pair forces, shifting vector, divergence and the extremes that limit the step.
pub fn sum_rates<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_plain: Res<StepsSincePlain>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut found: ResMut<RatesFound>,
) {
    let summary = rates::sum_rates(&pair.0, &grid.0, &mut arrays, level(*since_plain), &mut sums.0);
    *found = RatesFound {
        largest_signal: summary.signal_speed.max(scene.0.fluid.sound_speed),
        largest_speed: summary.speed,
        largest_divergence: summary.divergence,
        largest_damping: summary.damping,
        largest_damping_at_walls: summary.damping_at_walls,
        largest_viscosity: scene.0.fluid.viscosity + summary.eddy_viscosity,
    };
}

/// What walls with a wall function take, by the velocities that the scheme's dissipative terms take.
pub fn add_wall_friction<R: Real, const D: usize>(
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_plain: Option<Res<StepsSincePlain>>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
) {
    let level = since_plain.map_or(VelocityLevel::Present, |since_plain| level(*since_plain));
    wall_friction::add_wall_friction(&pair.0, &grid.0, &mut arrays, level, &mut sums.0);
}
