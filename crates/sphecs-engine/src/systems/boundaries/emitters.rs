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

use std::collections::VecDeque;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Local, Res, ResMut};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::inflow_columns::InflowColumns;
use super::movers::PresentPoses;
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
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::physics::pose::Pose;
use sphecs_scene::model::{Emitter, ParticleSeed, Scene};
use sphecs_scene::movers::{Wall, WallPoses};

/// Step of the differences in time of a prescribed speed, over Δ/c0.
const TIME_DIFFERENCE: f64 = 1e-4;

/// Columns of the emitters of a scene.
#[derive(Resource, Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmitterStates {
    /// Columns of each emitter, in the order of the scene.
    emitters: Vec<Vec<ColumnState>>,
    /// Place of each particle of a column, by its number; found from the columns.
    #[serde(skip)]
    places: Vec<ColumnPlace>,
}

/// What a column emitted, and its particles.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnState {
    /// Emitted volume Q, m³ (m² in 2D).
    volume: f64,
    /// Part of it that is smaller than the rounding error, m³ (m² in 2D).
    rest: f64,
    /// Number of particles that it emitted.
    emitted: u32,
    /// Numbers of the particles in it, from the surface.
    particles: VecDeque<u32>,
}

/// Place of a particle in the columns of its emitter.
#[derive(Clone, Copy, Debug, Default)]
struct ColumnPlace {
    column: u32,
    /// Its number n among all that the column ever held.
    serial: u32,
}

impl ColumnState {
    /// Adds an emitted volume by a compensated sum.
    fn emit(&mut self, volume: f64) {
        let added = volume + self.rest;
        let sum = self.volume + added;
        self.rest = added - (sum - self.volume);
        self.volume = sum;
    }

    /// Returns the volume between the surface and a particle of the column, for the volume of a
    /// particle.
    fn between(&self, serial: u32, particle: f64) -> f64 {
        (f64::from(serial) + 0.5) * particle - self.volume - self.rest
    }
}

impl EmitterStates {
    /// Returns the columns of a scene whose seeds are given in the order of their numbers.
    pub(crate) fn new(scene: &Scene, seeds: &[ParticleSeed]) -> Self {
        let is_of_emitter =
            |seed: &ParticleSeed| seed.zone == Zone::Inflow && scene.emitter(seed.patch).is_some();
        let mut ids = (0..).zip(seeds).filter(|(_, seed)| is_of_emitter(seed)).map(|(id, _)| id);
        let emitters = scene.emitters.iter().map(|emitter| {
            let columns = emitter.columns.iter().map(|column| {
                let count = emitter.column_count(column, scene);
                ColumnState { particles: ids.by_ref().take(count).collect(), ..ColumnState::default() }
            });
            columns.collect()
        });
        Self { emitters: emitters.collect(), places: Vec::new() }
    }

    /// Returns the volume that each emitter emitted since the start, m³ (m² in 2D).
    pub fn emitted_volumes(&self) -> impl Iterator<Item = f64> {
        let volume =
            |columns: &Vec<ColumnState>| columns.iter().map(|column| column.volume + column.rest).sum();
        self.emitters.iter().map(volume)
    }

    /// Returns the largest difference of the emitted particles and the emitted volume of a column,
    /// in particles, for the volume of a particle.
    pub fn largest_difference(&self, particle: f64) -> f64 {
        let columns = self.emitters.iter().flatten();
        let difference = |column: &ColumnState| {
            (f64::from(column.emitted) - (column.volume + column.rest) / particle).abs()
        };
        columns.map(difference).fold(0.0, f64::max)
    }

    /// Adds the numbers of the particles of the emitters on a wall part: the fluid presses on them as
    /// on the wall around.
    pub(crate) fn add_numbers(&self, scene: &Scene, part: u16, numbers: &mut Vec<u32>) {
        for (emitter, columns) in scene.emitters.iter().zip(&self.emitters) {
            if emitter.part == part {
                numbers.extend(columns.iter().flat_map(|column| &column.particles));
            }
        }
    }

    /// Finds the places of the particles, unless they are known.
    fn find_places(&mut self) {
        if !self.places.is_empty() {
            return;
        }
        for columns in &self.emitters {
            for (index, column) in columns.iter().enumerate() {
                for (serial, &id) in (column.emitted..).zip(&column.particles) {
                    set_place(&mut self.places, id, ColumnPlace { column: index as u32, serial });
                }
            }
        }
    }

    /// Adds the volumes that the columns emit in a step from `time`, s.
    fn emit(&mut self, scene: &Scene, time: f64, time_step: f64) {
        for (emitter, columns) in scene.emitters.iter().zip(&mut self.emitters) {
            for (column, state) in emitter.columns.iter().zip(columns) {
                let speed = 0.5 * (emitter.speed(column, time) + emitter.speed(column, time + time_step));
                state.emit(column.area * speed * time_step);
            }
        }
    }

    /// Returns the columns that a particle crossed the surface of, in their order, with the number
    /// of the particle.
    pub(crate) fn crossed(&self, scene: &Scene) -> Vec<Crossed> {
        let volume = scene.discretisation.cell_volume();
        let mut crossed = Vec::new();
        for (emitter, columns) in self.emitters.iter().enumerate() {
            for (column, state) in columns.iter().enumerate() {
                for (serial, &id) in (state.emitted..).zip(&state.particles) {
                    if state.between(serial, volume) >= 0.0 {
                        break;
                    }
                    crossed.push(Crossed { emitter, column, id });
                }
            }
        }
        crossed
    }

    /// Takes the foremost particle out of a column, and returns the depth of the next at its end, m,
    /// for a stretch of the column.
    pub(crate) fn advance(&mut self, scene: &Scene, crossed: Crossed, stretch: f64) -> f64 {
        let volume = scene.discretisation.cell_volume();
        let state = &mut self.emitters[crossed.emitter][crossed.column];
        state.particles.pop_front();
        state.emitted += 1;
        let next = state.emitted + state.particles.len() as u32;
        let column = &scene.emitters[crossed.emitter].columns[crossed.column];
        column.depth(stretch * state.between(next, volume))
    }

    /// Adds a particle at the end of a column.
    pub(crate) fn append(&mut self, crossed: Crossed, id: u32) {
        let state = &mut self.emitters[crossed.emitter][crossed.column];
        let serial = state.emitted + state.particles.len() as u32;
        state.particles.push_back(id);
        set_place(&mut self.places, id, ColumnPlace { column: crossed.column as u32, serial });
    }
}

/// A particle that crossed the surface of its emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossed {
    /// Index of the emitter.
    pub emitter: usize,
    /// Index of its column.
    pub column: usize,
    /// Number of the particle.
    pub id: u32,
}

fn set_place(places: &mut Vec<ColumnPlace>, id: u32, place: ColumnPlace) {
    let index = id as usize;
    if places.len() <= index {
        places.resize(index + 1, ColumnPlace::default());
    }
    places[index] = place;
}

/// An emitter with its particles at one time.
struct PresentEmitter<'a> {
    scene: &'a Scene,
    emitter: &'a Emitter,
    pose: Option<&'a Pose>,
    places: &'a [ColumnPlace],
    time: f64,
}

impl PresentEmitter<'_> {
    fn column(&self, id: u32) -> &EmitterColumn {
        &self.emitter.columns[self.places[id as usize].column as usize]
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
    (rows, mut columns): (Res<PatchRows>, ResMut<InflowColumns>),
    mut states: ResMut<EmitterStates>,
    mut buffers: Local<InflowBuffers<D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    states.find_places();
    for (index, emitter) in scene.emitters.iter().enumerate() {
        let source = scene.inlets.len() + index;
        let rows = &rows.inflow[source];
        let pose = pose_of(&poses.0, emitter);
        let motion = PresentEmitter { scene, emitter, pose, places: &states.places, time: clock.time };
        let mut zone = InflowZone {
            rows,
            motion: &motion,
            spacing: scene.spacing,
            density: scene.fluid.density,
            sound_speed: scene.fluid.sound_speed,
            time_step: clock.time_step,
            is_first_step: clock.step == 0,
            pair: &pair.0,
            grid: &grid.0,
            arrays: &mut arrays,
            sums: &mut sums.0,
            buffers: &mut buffers,
        };
        InletPressure::Extrapolated.apply(&mut zone);
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
            let place = states.places[arrays.id[row] as usize];
            let column = &emitter.columns[place.column as usize];
            let between = states.emitters[index][place.column as usize].between(place.serial, volume);
            let depth = column.depth(stretch * between);
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
            let place = states.places[arrays.id[row] as usize];
            let column = &emitter.columns[place.column as usize];
            let state = &states.emitters[index][place.column as usize];
            if column.depth(state.between(place.serial, volume)) > full_support_until {
                arrays.density[row] = R::from_f64(scene.fluid.density);
            }
        }
    }
}
