//! Inflow particles of emitters: their places follow from the volume that each column emitted and
//! from the pose of its wall.
//!
//! ```text
//! Q ← Q + A ½ (v(t) + v(t + Δt)) Δt      volume that a column emitted
//! q = (n + ½) V0 − Q                     volume between the surface and its particle n
//! x = R (X − s(q) N) + o                 s < 0 in front of the surface: the particle enters
//! ```
//!
//! X and N are foot and normal of the column in the coordinates of its wall. So a column of a
//! reference density emits m N with |m N − ρ0 Q| ≤ m/2 at all times, for any course of v. Where the
//! density follows from the pressure, q is multiplied by ρ0/ρ, see
//! [`inflow_columns`](super::inflow_columns).

use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;

use super::emitter_states::{Crossed, EmitterStates};
use super::inflow_columns::InflowColumns;
use super::movers::PresentPoses;
use super::opening_regions::OpeningRegions;
use super::patch_rows::PatchRows;
use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use crate::systems::forces::body_force;
use sphecs_core::boundary::inlet::InletPressure;
use sphecs_core::boundary::inlet::emitter_column::EmitterColumn;
use sphecs_core::boundary::inlet::inflow_zone::{InflowBuffers, InflowMotion, InflowParticle, InflowZone};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::set_real_vector;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::pose::Pose;
use sphecs_scene::model::{Emitter, Scene};
use sphecs_scene::movers::{Wall, WallPoses};

/// Step of the differences in time of a prescribed speed, over Δ/c0.
const TIME_DIFFERENCE: f64 = 1e-4;

/// An emitter with its particles at one time.
struct PresentEmitter<'a> {
    scene: &'a Scene,
    emitter: &'a Emitter,
    pose: Option<&'a Pose>,
    states: &'a EmitterStates,
    time: f64,
}

impl PresentEmitter<'_> {
    fn column(&self, id: u32) -> &EmitterColumn {
        &self.emitter.columns[self.states.place(id).column as usize]
    }

    /// Returns foot and normal of the column of a particle.
    fn surface(&self, id: u32) -> (DVec3, DVec3) {
        let column = self.column(id);
        match self.pose {
            Some(pose) => (pose.place(column.foot), pose.direction(column.normal)),
            None => (column.foot, column.normal),
        }
    }
}

impl InflowMotion for PresentEmitter<'_> {
    fn velocity(&self, particle: InflowParticle) -> DVec3 {
        let (foot, normal) = self.surface(particle.id);
        let depth = (foot - self.scene.nearest_image(particle.position, foot)).dot(normal);
        self.emitter.velocity_in(self.column(particle.id), depth, self.pose, self.time)
    }

    fn foot(&self, particle: InflowParticle) -> DVec3 {
        let (foot, _) = self.surface(particle.id);
        self.scene.nearest_image(foot, particle.position)
    }

    fn mirrored(&self, particle: InflowParticle) -> DVec3 {
        2.0 * self.foot(particle) - particle.position
    }

    fn centre(&self) -> DVec3 {
        let (centre, _) = self.emitter.ball();
        self.pose.map_or(centre, |pose| pose.place(centre))
    }

    fn body_force(&self, point: DVec3) -> DVec3 {
        body_force(&self.scene.body_force, point, self.time)
    }

    /// The acceleration is that of the wall, that of Coriolis, and along the normal those of the
    /// prescribed speed v: dv/dt − T v², since v A is constant along a column.
    fn pressure_force(&self, particle: InflowParticle) -> DVec3 {
        let (foot, normal) = self.surface(particle.id);
        let column = self.column(particle.id);
        let moment = TIME_DIFFERENCE * self.scene.spacing / self.scene.fluid.sound_speed;
        let speed = |time: f64| self.emitter.speed(column, time);
        let (before, after) = ((self.time - moment).max(0.0), self.time + moment);
        let here = speed(self.time);
        let rate = (speed(after) - speed(before)) / (after - before);
        let along = rate - column.curvature_sum * here * here;
        let carried = self
            .pose
            .map_or(DVec3::ZERO, |pose| pose.acceleration_at(foot) + 2.0 * here * pose.spin.cross(normal));
        self.body_force(particle.position) - carried - along * normal
    }
}

/// Returns the pose of the wall of an emitter.
fn pose_of<'a>(poses: &'a WallPoses, emitter: &Emitter) -> Option<&'a Pose> {
    match emitter.wall {
        Wall::Casing => poses.casing.as_ref(),
        Wall::Mover(index) => poses.movers.get(index),
    }
}

/// Sets velocity, pressure and density of the inflow particles of emitters at the present time.
pub(crate) fn apply_emitters<R: PairReal<D>, const D: usize>(
    (scene, poses, clock): (Res<ActiveScene>, Res<PresentPoses>, Res<Clock>),
    (pair, grid): (Res<Pair>, Res<Grid<D>>),
    (openings, rows, mut columns): (Res<OpeningRegions>, Res<PatchRows>, ResMut<InflowColumns>),
    mut states: ResMut<EmitterStates>,
    mut buffers: Local<InflowBuffers<D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    states.find_places();
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let source = scene.inlets.len() + index;
        if !openings.has_source(source) {
            continue;
        }
        let rows = &rows.inflow[source];
        let pair = pair.0.of_region(openings.of_source(source));
        let pose = pose_of(&poses.0, emitter);
        let motion = PresentEmitter { scene, emitter, pose, states: &states, time: clock.time };
        let mut zone = InflowZone {
            rows,
            motion: &motion,
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
        InletPressure::default().apply(&mut zone);
        if scene.scheme.wcsph().is_some() {
            columns.column(source).follow(scene.fluid.density, rows, &arrays);
        }
    }
}

/// Moves the inflow particles of emitters over a step from `time` (s) to the places that belong to
/// the poses of its end.
pub(crate) fn move_emitters<R: PairReal<D>, const D: usize>(
    (scene, poses): (&Scene, &WallPoses),
    states: &mut EmitterStates,
    columns: &mut InflowColumns,
    rows: &PatchRows,
    (time, time_step): (f64, f64),
    arrays: &mut ParticleArrays<R, D>,
) {
    states.find_places();
    states.emit(scene, time, time_step);
    let volume = scene.discretisation.cell_volume();
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let source = scene.inlets.len() + index;
        let stretch = columns.column(source).update();
        let pose = pose_of(poses, emitter);
        for &row in &rows.inflow[source] {
            let row = row as usize;
            let place = states.place(arrays.id[row]);
            let column = &emitter.columns[place.column as usize];
            let depth = column.depth(stretch * states.between(index, place, volume));
            let point = column.point(depth);
            let position = scene.wrapped(pose.map_or(point, |pose| pose.place(point)));
            let velocity = emitter.velocity_in(column, depth, pose, time + time_step);
            let before = arrays.velocity_of(row);
            for axis in 0..D {
                arrays.position[axis][row] = position[axis];
            }
            set_real_vector(&mut arrays.previous_velocity, row, before);
            set_real_vector(&mut arrays.velocity, row, velocity);
        }
    }
}

/// Returns position and velocity of a particle at a depth (m) of a column that was crossed.
pub(crate) fn place_in_column(
    (scene, poses): (&Scene, &WallPoses),
    crossed: Crossed,
    depth: f64,
    time: f64,
) -> (DVec3, DVec3) {
    let emitter = &scene.emitters[crossed.emitter];
    let (column, pose) = (&emitter.columns[crossed.column], pose_of(poses, emitter));
    let point = column.point(depth);
    let position = scene.wrapped(pose.map_or(point, |pose| pose.place(point)));
    (position, emitter.velocity_in(column, depth, pose, time))
}

/// Sets the density of the particles at the ends of the columns, where the support is truncated, to
/// that of reference.
pub(crate) fn set_end_densities<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    states: &mut EmitterStates,
    rows: &PatchRows,
    arrays: &mut ParticleArrays<R, D>,
) {
    states.find_places();
    let volume = scene.discretisation.cell_volume();
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let full_support_until = emitter.depth - scene.discretisation.support;
        for &row in &rows.inflow[scene.inlets.len() + index] {
            let row = row as usize;
            let place = states.place(arrays.id[row]);
            let column = &emitter.columns[place.column as usize];
            if column.depth(states.between(index, place, volume)) > full_support_until {
                arrays.density[row] = R::from_f64(scene.fluid.density);
            }
        }
    }
}
