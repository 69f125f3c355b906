//! Detection of a diverging flow after each step.
//!
//! A flow has diverged if a value is not finite or a particle is outside the grid. Densities,
//! speeds and the time step must also be within bounds.
//!
//! - `failure`: the reasons to stop that a step found
//! - `neighbourhood`: the particles around a diverged particle

mod failure;
mod neighbourhood;

use std::ops::Range;

use bevy_ecs::system::{Res, ResMut};

pub use failure::{DivergedParticle, Failure};
pub use neighbourhood::{NearbyParticle, Neighbourhood};

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::scene::ActiveScene;
use failure::{Finding, STEP_ADVICE};
use sphecs_core::format::significant;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::join_parts;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::integrator::friction;
use sphecs_core::physics::timestep::TimeStepLimits;
use sphecs_scene::model::{Scene, Scheme};

/// Largest speed of a flow that has not diverged, over the sound speed. Weakly compressible flow
/// stays below a tenth.
const LARGEST_MACH: f64 = 3.0;

/// Largest deviation of the density of a flow that has not diverged, over the reference density.
/// The scheme is meant for 1 %.
const LARGEST_DENSITY_DEVIATION: f64 = 0.5;

/// Smallest time step of a flow that has not diverged, over the step that sound speed and viscosity
/// allow in a fluid at rest. Only an acceleration a million times the physical one causes a smaller
/// step, with which the run would never end.
const SMALLEST_STEP: f64 = 1e-3;

/// Checks every particle after the step, and records the one with the smallest number that has
/// diverged.
pub fn check_state<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    (pair, mut grid): (Res<Pair>, ResMut<Grid<D>>),
    mut arrays: ResMut<Arrays<R, D>>,
    mut failure: ResMut<Failure>,
) {
    if failure.diverged.is_some() || failure.is_elsewhere || clock.step == 0 {
        return;
    }
    let scene = &*scene.0;
    let bounds = Bounds::new(scene);
    let support = pair.0.discretisation.support;
    let smallest = SMALLEST_STEP * step_at_rest(scene);
    if pair.0.ranks.size() > 1 {
        let has_diverged = clock.time_step < smallest || bounds.first_violation(&arrays.0).is_some();
        if pair.0.ranks.joined(u8::from(has_diverged), u8::max) == 0 {
            return;
        }
        // Rank 0 alone records what it finds among the particles of all.
        pair.0.ranks.assemble(&mut grid.0, &mut arrays.0);
        failure.is_elsewhere = pair.0.ranks.rank() > 0;
        if failure.is_elsewhere {
            return;
        }
    }
    if let Some(row) = bounds.first_violation(&arrays.0) {
        failure.record(&arrays, row, support, bounds.finding(scene, &arrays.0, row));
        return;
    }
    if clock.time_step < smallest
        && let Some(row) = most_accelerated(&arrays.0)
    {
        let acceleration = arrays.acceleration_of(row).length();
        let found = format!(
            "time step `{:.3e}` s, least `{smallest:.3e}` s, by the acceleration `{acceleration:.3e}` m/s²",
            clock.time_step
        );
        failure.record(&arrays, row, support, Finding { found, advice: START_ADVICE });
    }
}

/// Advice on forces that are too large.
const START_ADVICE: &str = "check for particles that overlap at the start and for a wall that intersects the fluid, or start with a smoother ramp";

/// Bounds of density and speed in a flow that has not diverged.
struct Bounds {
    /// Reference density, kg/m³.
    density: f64,
    /// Largest speed, m/s.
    speed: f64,
}

impl Bounds {
    fn new(scene: &Scene) -> Self {
        Self { density: scene.fluid.density, speed: LARGEST_MACH * scene.fluid.sound_speed }
    }

    /// Returns the row with the smallest particle number that violates the bounds.
    fn first_violation<R: PairReal<D>, const D: usize>(
        &self,
        arrays: &ParticleArrays<R, D>,
    ) -> Option<usize> {
        let smaller_number =
            |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min_by_key(|&row| arrays.id[row]);
        let quick = QuickBounds::<R>::new(self);
        let find = |rows: Range<usize>| {
            if quick.hold(arrays, rows.clone()) {
                return None;
            }
            rows.filter(|&row| !self.hold(arrays, row))
                .fold(None, |first, row| smaller_number(first, Some(row)))
        };
        join_parts(0..arrays.len(), &find, &smaller_number)
    }

    /// Returns true if a row is within the bounds.
    fn hold<R: PairReal<D>, const D: usize>(&self, arrays: &ParticleArrays<R, D>, row: usize) -> bool {
        let mut squared = 0.0;
        for axis in 0..D {
            let v = arrays.velocity[axis][row].to_f64();
            squared += v * v;
        }
        let deviation = (arrays.density[row].to_f64() / self.density - 1.0).abs();
        // Under `EdacTvf` the pressure does not follow from the density. So an outflow zone may
        // have any density unless its condition keeps it uniform, as at an impulsive start.
        let has_any_density = arrays.evolves_pressure && arrays.zone[row] == Zone::Outflow;
        let limit = if has_any_density { f64::INFINITY } else { LARGEST_DENSITY_DEVIATION };
        // Comparisons with a NaN are false.
        squared <= self.speed * self.speed && deviation <= limit && arrays.pressure[row].to_f64().is_finite()
    }

    /// Describes the violation of a row, with advice to the user.
    fn finding<R: PairReal<D>, const D: usize>(
        &self,
        scene: &Scene,
        arrays: &ParticleArrays<R, D>,
        row: usize,
    ) -> Finding {
        let speed = arrays.velocity_of(row).length();
        let (density, pressure) = (arrays.density[row].to_f64(), arrays.pressure[row].to_f64());
        if !pressure.is_finite() {
            let found = format!("pressure `{pressure}` Pa, which is not finite");
            return Finding { found, advice: STEP_ADVICE };
        }
        if speed <= self.speed {
            let advice = match scene.scheme {
                Scheme::Wcsph(_) => {
                    "check that no wall or zone is missing, raise `fluid.sound_speed`, or keep `tensile_control` and shifting on"
                }
                Scheme::EdacTvf(_) => {
                    "check that no wall or zone is missing, raise `scheme.background`, or start with a less regular distribution: see scenes/taylor_green_edac.ron"
                }
            };
            let found = format!(
                "density `{}` kg/m³, reference `{}` kg/m³ ± 50 %",
                significant(density),
                self.density
            );
            return Finding { found, advice };
        }
        Finding {
            found: format!("speed `{}` m/s, limit `{}` m/s (3 c0)", significant(speed), self.speed),
            advice: "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or start with a smoother ramp",
        }
    }
}

/// Bounds well inside [`Bounds`], for a quick check of many rows.
struct QuickBounds<R> {
    speed: R,
    density: R,
    deviation: R,
}

impl<R: Real> QuickBounds<R> {
    fn new(Bounds { density, speed }: &Bounds) -> Self {
        // The bound of a component is half the largest speed, so a velocity of three such
        // components is below it.
        let [speed, density, deviation] =
            [0.5 * speed, *density, 0.98 * LARGEST_DENSITY_DEVIATION * density].map(R::from_f64);
        Self { speed, density, deviation }
    }

    /// Returns true if all rows are within the bounds and no value is a NaN. Without branches, so
    /// that the compiler vectorises the loops.
    fn hold<const D: usize>(&self, arrays: &ParticleArrays<R, D>, rows: Range<usize>) -> bool {
        let is_slow = arrays.velocity.iter().fold(true, |slow, column| {
            column[rows.clone()].iter().fold(slow, |all, v| all & (v.abs() <= self.speed))
        });
        let densities = arrays.density[rows.clone()].iter();
        let is_regular =
            densities.fold(true, |all, &rho| all & ((rho - self.density).abs() <= self.deviation));
        let pressures = arrays.pressure[rows].iter();
        is_slow & is_regular & pressures.fold(true, |all, &p| all & (p * R::default() == R::default()))
    }
}

/// Returns the time step, s, that sound speed and viscosity allow in a fluid at rest.
fn step_at_rest(scene: &Scene) -> f64 {
    let limits = TimeStepLimits {
        cfl: scene.time.cfl,
        viscous: scene.time.viscous,
        damping: friction::DAMPING,
        smoothing_length: scene.discretisation.smoothing_length,
        viscosity: scene.fluid.viscosity,
    };
    limits.time_step(0.0, scene.fluid.sound_speed, 0.0)
}

/// Returns the fluid row with the largest acceleration.
fn most_accelerated<R: PairReal<D>, const D: usize>(arrays: &ParticleArrays<R, D>) -> Option<usize> {
    let fluid = (0..arrays.len()).filter(|&row| arrays.zone[row] == Zone::Fluid);
    let size = |row: &usize| arrays.acceleration_of(*row).length_squared();
    fluid.max_by(|a, b| size(a).total_cmp(&size(b)).then(arrays.id[*b].cmp(&arrays.id[*a])))
}
