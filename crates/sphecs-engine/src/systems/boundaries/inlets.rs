//! Velocity and pressure of inflow particles.
//!
//! The velocity is the scene's. An extrapolated pressure is the fluid's at the mirror image of the particle in the
//! inlet plane, by first-order corrected sums, carried back over the distance by the pressure gradient that the
//! prescribed motion needs:
//!
//! ```text
//! p_o = p(x_k) + ρ0 (g − dv_in/dt + ν ∇²v_in)·(x_o − x_k),   x_k = x_o − 2 ((x_o − x_plane)·n) n
//! ```
//!
//! Negi et al. (2020), Eq. 22, for the first term. Extrapolating the sampled gradient instead would multiply its
//! noise by the distance.
//!
//! The particle's pressure follows it over the time in which sound passes two particles. At once, the inlet is a wall
//! that reflects sound with a gain, for the sums extrapolate where the first row of fluid stands away from the plane:
//! Poiseuille flow at c0 = 2 m/s burst when its first particles came to cross. A wall whose pressure lags gives way to
//! the wave and takes its energy: the flow stays within 0.1 % of the series.

use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::rows::PatchRows;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use crate::systems::forces::body_force;
use sphecs_core::math::real::Real;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::pass::fits::PointFit;
use sphecs_core::pass::points::PointFlows;
use sphecs_core::physics::inlet::InletPressure;
use sphecs_scene::model::{Inlet, Scene};

/// Time over which an extrapolated pressure is followed, in passages of sound over Δ.
const LAG: f64 = 2.0;

/// Inflow particles that a thread takes at least.
const CHUNK: usize = 32;

/// Velocity that an inlet prescribes at a point and time, m/s.
pub fn inlet_velocity(inlet: &Inlet, viscosity: f64, point: DVec3, time: f64) -> DVec3 {
    inlet.velocity_at(viscosity, point, time)
}

/// What an inflow particle has in a step.
pub struct Prescribed {
    /// Velocity, m/s.
    velocity: DVec3,
    /// Pressure, Pa.
    pressure: f64,
    /// Density that the pressure belongs to, kg/m³; None where it is summed.
    density: Option<f64>,
}

/// Sets velocity, pressure and density of inflow particles at the present time.
pub fn apply_inlets<R: Real, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    pair: Res<Pair>,
    grid: Res<Grid<D>>,
    rows: Res<PatchRows>,
    mut flows: Local<PointFlows<D>>,
    mut inflow: Local<Vec<Prescribed>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    let nu = scene.fluid.viscosity;
    let lag = LAG * scene.spacing / scene.fluid.sound_speed;
    for (inlet, rows) in scene.inlets.iter().zip(&rows.inflow) {
        let share = match inlet.pressure {
            InletPressure::Prescribed(_) => 1.0,
            InletPressure::Extrapolated => clock.time_step / (clock.time_step + lag),
        };
        if inlet.pressure == InletPressure::Extrapolated {
            flows.points.clear();
            flows.points.extend(rows.iter().map(|&row| {
                let mirrored = mirrored(inlet, arrays.position_of(row as usize));
                std::array::from_fn(|axis| mirrored[axis])
            }));
            flows.find(PointFit::Pressure, &pair.0, &grid.0, &arrays, &mut sums.0);
        }
        let (before, found) = (&**arrays, &flows.found);
        let prescribed = rows.par_iter().enumerate().with_min_len(CHUNK).map(|(index, &row)| {
            let row = row as usize;
            let (place, own) = (before.position_of(row), before.pressure[row].to_f64());
            let pressure = match inlet.pressure {
                InletPressure::Prescribed(pressure) => pressure,
                InletPressure::Extrapolated => match found[index] {
                    Some(flow) => flow.pressure - rise(scene, inlet, place, clock.time),
                    None => own,
                },
            };
            let at_once = before.fresh[row] || clock.step == 0;
            let pressure = if at_once { pressure } else { own + share * (pressure - own) };
            let velocity = inlet_velocity(inlet, nu, place, clock.time);
            Prescribed { velocity, pressure, density: pair.0.density_at(pressure) }
        });
        prescribed.collect_into_vec(&mut inflow);
        for (&row, &Prescribed { velocity, pressure, density }) in rows.iter().zip(&*inflow) {
            let row = row as usize;
            set_real_vector(&mut arrays.velocity, row, velocity);
            arrays.pressure[row] = R::from_f64(pressure);
            if let Some(density) = density {
                arrays.density[row] = R::from_f64(density);
            }
        }
    }
}

/// The mirror image of a point in the plane of an inlet.
fn mirrored(inlet: &Inlet, point: DVec3) -> DVec3 {
    point - inlet.patch.towards * (2.0 * inlet.patch.along(point))
}

/// By how much the prescribed motion makes the pressure rise from a point to its mirror image, Pa.
fn rise(scene: &Scene, inlet: &Inlet, point: DVec3, time: f64) -> f64 {
    // Short against any ramp, and against any profile that the particles can follow.
    let (moment, step) = (1e-4 * scene.spacing / scene.fluid.sound_speed, 0.25 * scene.spacing);
    let viscosity = if scene.scheme.is_viscous() { scene.fluid.viscosity } else { 0.0 };
    let inertia = inlet.inertia(viscosity, point, time, step, moment);
    let gradient = (body_force(&scene.body_force, point, time) - inertia) * scene.fluid.density;
    gradient.dot(mirrored(inlet, point) - point)
}
