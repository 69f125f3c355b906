//! Velocity, pressure and motion of inflow particles.

use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use super::inflow_columns::{InflowColumn, InflowColumns};
use super::opening_regions::OpeningRegions;
use super::patch_rows::PatchRows;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use crate::systems::forces::body_force;
use sphecs_core::boundary::inlet::inflow_zone::{InflowBuffers, InflowMotion, InflowParticle, InflowZone};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::{Inlet, Scene};

/// Smallest number of inflow particles per thread: a profile may be an expression.
const CHUNK: usize = 32;

/// Step of the differences in time of a prescribed velocity, over Δ/c0: short against any ramp.
const TIME_DIFFERENCE: f64 = 1e-4;

/// Step of the differences in space of a prescribed velocity, over Δ: short against any profile
/// that the particles resolve.
const SPACE_DIFFERENCE: f64 = 0.25;

/// Motion that a scene prescribes at one of its inlets at a time (s).
struct SceneMotion<'a> {
    scene: &'a Scene,
    inlet: &'a Inlet,
    time: f64,
}

impl InflowMotion for SceneMotion<'_> {
    fn velocity(&self, particle: InflowParticle) -> DVec3 {
        self.inlet.velocity_at(self.scene.fluid.viscosity, particle.position, self.time)
    }

    fn foot(&self, particle: InflowParticle) -> DVec3 {
        let patch = &self.inlet.patch;
        particle.position - patch.towards * patch.along(particle.position)
    }

    fn mirrored(&self, particle: InflowParticle) -> DVec3 {
        self.inlet.patch.mirrored(particle.position)
    }

    fn centre(&self) -> DVec3 {
        self.inlet.patch.at
    }

    fn body_force(&self, point: DVec3) -> DVec3 {
        body_force(&self.scene.body_force, point, self.time)
    }

    fn pressure_force(&self, particle: InflowParticle) -> DVec3 {
        let (scene, point) = (self.scene, particle.position);
        let moment = TIME_DIFFERENCE * scene.spacing / scene.fluid.sound_speed;
        let step = SPACE_DIFFERENCE * scene.spacing;
        let viscosity = if scene.scheme.is_viscous() { scene.fluid.viscosity } else { 0.0 };
        let inertia = self.inlet.inertia(viscosity, point, self.time, step, moment);
        self.body_force(point) - inertia
    }
}

/// Sets velocity, pressure and density of inflow particles at the present time.
pub fn apply_inlets<R: PairReal<D>, const D: usize>(
    scene: Res<ActiveScene>,
    clock: Res<Clock>,
    (pair, grid): (Res<Pair>, Res<Grid<D>>),
    (openings, rows, mut columns): (Res<OpeningRegions>, Res<PatchRows>, ResMut<InflowColumns>),
    mut buffers: Local<InflowBuffers<D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    for (index, (inlet, rows)) in scene.inlets.iter().zip(&rows.inflow).enumerate() {
        if !openings.has_source(index) {
            continue;
        }
        let pair = pair.0.of_region(openings.of_source(index));
        let mut zone = InflowZone {
            rows,
            motion: &SceneMotion { scene, inlet, time: clock.time },
            spacing: scene.spacing,
            density: scene.fluid.density,
            sound_speed: scene.fluid.sound_speed,
            time_step: clock.time_step,
            is_first_step: clock.step == 0,
            pair: &pair,
            grid: &grid.0,
            arrays: &mut arrays,
            sums: &mut sums.0,
            buffers: &mut buffers,
        };
        inlet.pressure.apply(&mut zone);
        if scene.scheme.wcsph().is_some() {
            let column = columns.column(index);
            column.follow(scene.fluid.density, rows, &arrays);
            if clock.step == 0 {
                column.compress(&inlet.patch, rows, &mut arrays);
            }
        }
    }
}

/// Moves the particles of an inlet with the prescribed velocity by a step from `time` (s), and with
/// the compression of their column. `velocities` is a buffer that is kept from step to step.
pub fn move_inflow<R: PairReal<D>, const D: usize>(
    (inlet, viscosity): (&Inlet, f64),
    column: &mut InflowColumn,
    rows: &[u32],
    (time, time_step): (f64, f64),
    velocities: &mut Vec<DVec3>,
    arrays: &mut ParticleArrays<R, D>,
) {
    column.compress(&inlet.patch, rows, arrays);
    let before = &*arrays;
    let next = rows
        .par_iter()
        .with_min_len(CHUNK)
        .map(|&row| inlet.velocity_at(viscosity, before.position_of(row as usize), time + time_step));
    next.collect_into_vec(velocities);
    for (&row, &next) in rows.iter().zip(&*velocities) {
        let row = row as usize;
        let v = arrays.velocity_of(row);
        set_real_vector(&mut arrays.previous_velocity, row, v);
        set_real_vector(&mut arrays.velocity, row, next);
        // The mean of both ends carries the prescribed flux through a ramp to second order.
        let way = column.moved(&inlet.patch, (v + next) * 0.5) * time_step;
        for axis in 0..D {
            arrays.position[axis][row] += way[axis];
        }
    }
}
