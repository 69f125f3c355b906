//! How inflow and outflow particles move in the kick.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::inlets::inlet_velocity;
use super::outlets::OutletState;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{real_vector, set_real_vector};
use sphecs_core::physics::outlet::Frame;
use sphecs_scene::model::{Inlet, Outlet};

/// Inflow particles that a thread takes at least: a profile may be an expression.
const CHUNK: usize = 32;

/// Moves the particles of an inlet by one step from `time` (s) with the prescribed velocity; `velocities` is kept from step to step.
pub fn move_inflow<R: Real, const D: usize>(
    inlet: &Inlet,
    viscosity: f64,
    rows: &[u32],
    time: f64,
    time_step: f64,
    velocities: &mut Vec<DVec3>,
    arrays: &mut ParticleArrays<R, D>,
) {
    let before = &*arrays;
    let next = rows
        .par_iter()
        .with_min_len(CHUNK)
        .map(|&row| inlet_velocity(inlet, viscosity, before.position_of(row as usize), time + time_step));
    next.collect_into_vec(velocities);
    for (&row, &next) in rows.iter().zip(&*velocities) {
        let row = row as usize;
        let v = arrays.velocity_of(row);
        set_real_vector(&mut arrays.previous_velocity, row, v);
        set_real_vector(&mut arrays.velocity, row, next);
        // The mean of both ends carries the prescribed flux through a ramp to second order.
        move_row(arrays, row, (v + next) * (0.5 * time_step));
    }
}

/// Moves the particles of an outlet by one step, s.
///
/// The rates are dissipative, so each step is a plain one: the leapfrog would let them grow. A particle moves along the normal only, with
/// the speed that its condition found; in the fixed frame of a wave equation with its own, never back.
pub fn move_outflow<R: Real, const D: usize>(
    outlet: &Outlet,
    state: &OutletState,
    rows: &[u32],
    time_step: f64,
    arrays: &mut ParticleArrays<R, D>,
) {
    let normal = outlet.patch.towards;
    let frame = outlet.condition.wave().map(|wave| wave.frame);
    for (&row, &convective) in rows.iter().zip(&state.convective) {
        let row = row as usize;
        let v = arrays.velocity_of(row);
        let mut next = v + real_vector(&arrays.acceleration, row) * time_step;
        let speed = match frame {
            // Its condition sets the velocity in the next step.
            None => convective,
            Some(Frame::Moving) => {
                if convective < 0.0 {
                    // What flows back has the velocity with which it is drawn in, not the one with which it left.
                    next += normal * (convective - next.dot(normal));
                }
                convective
            }
            Some(Frame::Fixed) => {
                next -= normal * next.dot(normal).min(0.0);
                0.5 * (v + next).dot(normal)
            }
        };
        set_real_vector(&mut arrays.previous_velocity, row, v);
        set_real_vector(&mut arrays.velocity, row, next);
        move_row(arrays, row, normal * (speed * time_step));
    }
}

fn move_row<R: Real, const D: usize>(arrays: &mut ParticleArrays<R, D>, row: usize, by: DVec3) {
    for axis in 0..D {
        arrays.position[axis][row] += by[axis];
    }
}
