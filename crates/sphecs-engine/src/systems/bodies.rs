//! Force and torque on the bodies of a scene, summed in every step beside the rates.

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use bevy_ecs::world::{FromWorld, World};

use super::clock::Clock;
use super::neighbours::Grid;
use super::pair::Pair;
use super::rates::{StepsSincePlain, Sums, level};
use super::setup::SceneInUse;
use super::surface_shear::SurfaceShear;
use crate::arrays::Arrays;
use sphecs_core::math::real::Real;
use sphecs_core::pass::body::{Body, BodySum};
use sphecs_core::pass::edac::body::sum_body_force as sum_evolved;
use sphecs_core::pass::rates::body::sum_body_force;
use sphecs_core::pass::settings::{PairSettings, PressureLaw};
use sphecs_core::pass::wall_friction::add_friction_on;
use sphecs_core::physics::edac::Edac;
use sphecs_scene::model::Scene;

/// The forces on all bodies at the beginning of a step, of which they are part.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyForcesRow {
    /// Time, s.
    pub time: f64,
    /// Steps done before.
    pub step: u64,
    /// Force and torque by body, in the order of the scene.
    pub forces: Vec<BodySum>,
}

/// The bodies with what their forces are summed by.
#[derive(Resource)]
pub struct Bodies {
    /// Of the last step.
    pub row: BodyForcesRow,
    bodies: Vec<Body>,
    /// Of each body.
    shear: Vec<SurfaceShear>,
    pair: PairSettings,
    edac: Edac,
}

impl FromWorld for Bodies {
    fn from_world(world: &mut World) -> Self {
        let scene = &world.resource::<SceneInUse>().0;
        let pair = &world.resource::<Pair>().0;
        let edac = match pair.pressure {
            PressureLaw::Evolved(edac) => edac,
            PressureLaw::Tait => Edac::default(),
        };
        Self {
            row: BodyForcesRow::default(),
            bodies: scene.bodies.iter().map(|body| Body::new(body.part, body.about)).collect(),
            shear: scene.bodies.iter().map(|body| SurfaceShear::new(scene, body.part, body.about)).collect(),
            // Why without these two: see `pass/body.rs`.
            pair: PairSettings { tensile_control: false, ..pair.clone() },
            edac: Edac { average_pressure: false, ..edac },
        }
    }
}

/// Sums the forces on all bodies by the terms of `Wcsph`.
pub fn sum_body_forces<R: Real, const D: usize>(
    (scene, clock): (Res<SceneInUse>, Res<Clock>),
    grid: Res<Grid<D>>,
    since_plain: Res<StepsSincePlain>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut bodies: ResMut<Bodies>,
) {
    let Bodies { row, bodies, shear, pair, .. } = &mut *bodies;
    (row.time, row.step) = (clock.time, clock.step);
    row.forces.clear();
    row.forces.extend(bodies.iter_mut().zip(shear).map(|(body, shear)| {
        let mut sum = sum_body_force(pair, &grid.0, &arrays, level(*since_plain), &mut sums.0, body);
        add_friction_on(pair, &grid.0, &arrays, &sums.0, body, &mut sum);
        add_shear(&scene.0, clock.time, shear, body, &mut sum);
        sum
    }));
}

/// Sums the forces on all bodies by the terms of `EdacTvf`.
pub fn sum_edac_body_forces<R: Real, const D: usize>(
    (scene, clock): (Res<SceneInUse>, Res<Clock>),
    grid: Res<Grid<D>>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut bodies: ResMut<Bodies>,
) {
    let Bodies { row, bodies, shear, pair, edac } = &mut *bodies;
    (row.time, row.step) = (clock.time, clock.step);
    row.forces.clear();
    row.forces.extend(bodies.iter_mut().zip(shear).map(|(body, shear)| {
        let mut sum = sum_evolved(pair, edac, &grid.0, &arrays, &mut sums.0, body);
        add_friction_on(pair, &grid.0, &arrays, &sums.0, body, &mut sum);
        add_shear(&scene.0, clock.time, shear, body, &mut sum);
        sum
    }));
}

/// Adds what the pairs leave out where a surface turns.
fn add_shear(scene: &Scene, time: f64, shear: &SurfaceShear, body: &Body, sum: &mut BodySum) {
    let wall = &scene.walls.parts[usize::from(body.part)];
    let of_surface = shear.at(scene, wall, body.about, time);
    sum.viscous_force += of_surface.viscous_force;
    sum.viscous_torque += of_surface.viscous_torque;
}
