//! What makes a run stop: values that are not finite, densities, speeds and time steps out of bounds, particles lost.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use glam::DVec3;

use super::clock::Clock;
use super::neighbourhood::Neighbourhood;
use super::pair::Pair;
use super::setup::SceneInUse;
use crate::arrays::Arrays;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::join_parts;
use sphecs_core::physics::integrator::friction;
use sphecs_core::physics::timestep::TimeStepLimits;
use sphecs_scene::model::{Scene, Scheme};

/// The first reason to stop that a step found.
#[derive(Resource, Clone, Debug, Default)]
pub struct Failure {
    /// An impossible state.
    pub fault: Option<Fault>,
    /// An inlet found the reservoir empty and the scene says to stop.
    pub reservoir_empty: bool,
    /// Index of an inlet that is filled once and has nothing left.
    pub drained: Option<u16>,
}

/// A particle in an impossible state.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// Number of the particle.
    pub id: u32,
    /// Its zone.
    pub zone: Zone,
    /// Its position, m.
    pub position: DVec3,
    /// What was found, with the bound it broke.
    pub found: String,
    /// What a user can do about it.
    pub cure: &'static str,
    /// What stood around it.
    pub neighbourhood: Neighbourhood,
}

/// A speed beyond this multiple of the sound speed is a blow-up: weakly compressible flow needs ten times less
/// than the sound speed.
const LARGEST_MACH: f64 = 3.0;

/// A density off its reference by more than this is a blow-up: 1 % is what the scheme is made for.
const LARGEST_DENSITY_DEVIATION: f64 = 0.5;

/// A step below this part of what sound and viscosity allow in a fluid at rest is a blow-up: an acceleration a million times
/// as large as any that the fluid can bear forces it, and the run would not come to its end.
const SMALLEST_STEP: f64 = 1e-3;

impl Failure {
    /// Records that a row left the grid, unless something was recorded before.
    pub fn outside_grid<R: Real, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        row: usize,
        support: f64,
    ) {
        let finite = arrays.position_of(row).is_finite();
        let found = if finite {
            "position outside the domain".to_owned()
        } else {
            "position is not finite".to_owned()
        };
        self.record(arrays, row, support, found, STEP_CURE);
    }

    fn record<R: Real, const D: usize>(
        &mut self,
        arrays: &ParticleArrays<R, D>,
        row: usize,
        support: f64,
        found: String,
        cure: &'static str,
    ) {
        if self.fault.is_none() {
            self.fault = Some(Fault {
                id: arrays.id[row],
                zone: arrays.zone[row],
                position: arrays.position_of(row),
                found,
                cure,
                neighbourhood: Neighbourhood::around(arrays, row, support),
            });
        }
    }
}

/// What usually helps where a step was too long.
const STEP_CURE: &str =
    "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or refine `spacing`";

/// Looks at every particle after the step; records the one with the smallest number.
pub fn check_state<R: Real, const D: usize>(
    scene: Res<SceneInUse>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    arrays: Res<Arrays<R, D>>,
    mut failure: ResMut<Failure>,
) {
    if failure.fault.is_some() || clock.step == 0 {
        return;
    }
    let scene = &*scene.0;
    let fluid = scene.fluid;
    let speed_limit = LARGEST_MACH * fluid.sound_speed;
    // A zone that its condition does not keep even may clump, as one at rest that a flow from rest runs into. Where densities are summed and
    // say nothing of the pressure, what counts is the fluid.
    let evolves = arrays.evolves_pressure;
    let smaller_number =
        |a: Option<usize>, b: Option<usize>| a.into_iter().chain(b).min_by_key(|&row| arrays.id[row]);
    let within = Within::<R>::new(fluid.density, speed_limit);
    let find = |rows: Range<usize>| {
        let mut first: Option<usize> = None;
        // Most parts are sound, which a glance finds.
        if within.holds(&arrays, rows.clone()) {
            return None;
        }
        for row in rows {
            let mut squared = 0.0;
            for axis in 0..D {
                let v = arrays.velocity[axis][row].to_f64();
                squared += v * v;
            }
            let deviation = (arrays.density[row].to_f64() / fluid.density - 1.0).abs();
            let may_clump = evolves && arrays.zone[row] == Zone::Outflow;
            let limit = if may_clump { f64::INFINITY } else { LARGEST_DENSITY_DEVIATION };
            // Written so that a NaN fails too.
            let sound = squared <= speed_limit * speed_limit
                && deviation <= limit
                && arrays.pressure[row].to_f64().is_finite();
            if !sound {
                first = smaller_number(first, Some(row));
            }
        }
        first
    };
    let support = pair.0.support();
    if let Some(row) = join_parts(0..arrays.len(), &find, &smaller_number) {
        let (found, cure) = what_is_wrong(scene, &arrays, row, speed_limit);
        failure.record(&arrays, row, support, found, cure);
        return;
    }
    let least = SMALLEST_STEP * step_at_rest(scene);
    if clock.time_step < least
        && let Some(row) = most_accelerated(&arrays)
    {
        let acceleration = arrays.acceleration_of(row).length();
        let found = format!(
            "time step `{:.3e}` s, least `{least:.3e}` s, by the acceleration `{acceleration:.3e}` m/s²",
            clock.time_step
        );
        failure.record(&arrays, row, support, found, START_CURE);
    }
}

/// Bounds well inside of what is sound, for a glance at many rows.
struct Within<R> {
    speed: R,
    density: R,
    deviation: R,
}

impl<R: Real> Within<R> {
    fn new(density: f64, speed_limit: f64) -> Self {
        // A component of half the limit: a velocity of three of them is within it.
        let [speed, density, deviation] =
            [0.5 * speed_limit, density, 0.98 * LARGEST_DENSITY_DEVIATION * density].map(R::from_f64);
        Self { speed, density, deviation }
    }

    /// Whether all of the rows are sound beyond doubt. Without branches, so that its loops are over vectors; nothing that is no number is within bounds.
    fn holds<const D: usize>(&self, arrays: &ParticleArrays<R, D>, rows: Range<usize>) -> bool {
        let slow = arrays.velocity.iter().fold(true, |slow, column| {
            column[rows.clone()].iter().fold(slow, |all, v| all & (v.abs() <= self.speed))
        });
        let densities = arrays.density[rows.clone()].iter();
        let even = densities.fold(true, |all, &rho| all & ((rho - self.density).abs() <= self.deviation));
        let pressures = arrays.pressure[rows].iter();
        slow & even & pressures.fold(true, |all, &p| all & (p * R::default() == R::default()))
    }
}

/// What usually helps where forces are too large.
const START_CURE: &str = "look for particles that overlap at the start or a wall that cuts the fluid, or start with a smoother ramp";

/// What is wrong with a row, and what usually helps.
fn what_is_wrong<R: Real, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    row: usize,
    speed_limit: f64,
) -> (String, &'static str) {
    let speed = arrays.velocity_of(row).length();
    let (density, pressure) = (arrays.density[row].to_f64(), arrays.pressure[row].to_f64());
    if !pressure.is_finite() {
        return (format!("pressure `{pressure}` Pa, which is not finite"), STEP_CURE);
    }
    if speed <= speed_limit {
        let cure = match scene.scheme {
            Scheme::Wcsph(_) => {
                "check that no wall or zone is missing, raise `fluid.sound_speed`, or keep `tensile_control` and shifting on"
            }
            Scheme::EdacTvf(_) => {
                "check that no wall or zone is missing, raise `scheme.background`, or start less even: see scenes/taylor_green_edac.ron"
            }
        };
        return (
            format!("density `{density:.4}` kg/m³, reference `{}` kg/m³ ± 50 %", scene.fluid.density),
            cure,
        );
    }
    (
        format!("speed `{speed:.4}` m/s, limit `{speed_limit}` m/s (3 c0)"),
        "lower `time.cfl`, raise `fluid.sound_speed` to ten times the largest speed, or start with a smoother ramp",
    )
}

/// Time step that sound and viscosity allow in a fluid at rest, s.
fn step_at_rest(scene: &Scene) -> f64 {
    let limits = TimeStepLimits {
        cfl: scene.time.cfl,
        viscous: scene.time.viscous,
        damping: friction::DAMPING,
        smoothing_length: scene.scheme.smoothing_ratio() * scene.spacing,
        viscosity: scene.fluid.viscosity,
    };
    limits.time_step(0.0, scene.fluid.sound_speed, 0.0)
}

/// The fluid row with the largest acceleration.
fn most_accelerated<R: Real, const D: usize>(arrays: &ParticleArrays<R, D>) -> Option<usize> {
    let fluid = (0..arrays.len()).filter(|&row| arrays.zone[row] == Zone::Fluid);
    let size = |row: &usize| arrays.acceleration_of(*row).length_squared();
    fluid.max_by(|a, b| size(a).total_cmp(&size(b)).then(arrays.id[*b].cmp(&arrays.id[*a])))
}
