//! Density, gradients and pair forces of the scheme `Wcsph`.

use bevy_ecs::system::{Res, ResMut};

use crate::arrays::Arrays;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{RatesFound, StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::rates::TimeLevel;
use sphecs_core::physics::viscosity::reconstructed::NoiseDamping;
use sphecs_scene::model::Wcsph;

/// Returns true if the scheme needs the velocity gradient among the neighbours of a particle.
fn needs_strain(scheme: &Wcsph) -> bool {
    let shifting = scheme.shifting;
    scheme.noise_damping != NoiseDamping::Off || shifting.carries_velocity() || !shifting.keeps_drift()
}

/// Computes the density of fluid particles by summation and their pressure by the Tait equation.
///
/// It also sums the velocity gradient among the neighbours, if the noise damping or the shifting
/// needs it.
pub(crate) fn sum_density<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Res<StepsSinceCorrection>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    if scene.0.scheme.wcsph().is_some_and(needs_strain) {
        R::sum_density_and_strain(&pair.0, &grid.0, &mut arrays, since_correction.time_level(), &mut sums.0);
    } else {
        R::sum_density(&pair.0, &grid.0, &mut arrays, &mut sums.0);
    }
}

/// Computes velocity gradients and sub-particle stress, in a scene with `Sps` viscosity.
pub(crate) fn sum_gradients<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Res<StepsSinceCorrection>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
) {
    if !scene.0.scheme.has_stress() {
        return;
    }
    R::sum_gradients(&pair.0, &grid.0, &arrays, since_correction.time_level(), &mut sums.0);
    R::find_stress(&pair.0, &grid.0, &arrays, &mut sums.0);
}

/// Computes pair forces, shifting vector and divergence, and the extremes that limit the time step.
pub(crate) fn sum_rates<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Res<StepsSinceCorrection>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut found: ResMut<RatesFound>,
) {
    let summary = R::sum_rates(&pair.0, &grid.0, &mut arrays, since_correction.time_level(), &mut sums.0);
    *found = RatesFound {
        largest_signal: summary.signal_speed,
        largest_speed: summary.speed,
        largest_divergence: summary.divergence,
        largest_damping: summary.damping,
        largest_damping_at_walls: summary.damping_at_walls,
        largest_viscosity: scene.0.fluid.viscosity + summary.eddy_viscosity,
    };
}

/// Adds the friction at walls with a wall function, with the velocities of the other dissipative
/// terms.
pub(crate) fn add_wall_friction<R: PairReal<D>, const D: usize>(
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    since_correction: Option<Res<StepsSinceCorrection>>,
    mut arrays: ResMut<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
) {
    let level = since_correction.map_or(TimeLevel::Present, |since_correction| since_correction.time_level());
    R::add_wall_friction(&pair.0, &grid.0, &mut arrays, level, &mut sums.0);
}
