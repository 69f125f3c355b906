//! Force and torque of the fluid on the bodies of a scene, summed in every step after the rates.
//!
//! - `covered_walls`: particles of walls at rest behind a body that moves
//! - `surface_shear`: shear on a rotating or deforming surface that the pair sums omit

mod covered_walls;
mod surface_shear;

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use bevy_ecs::world::{FromWorld, World};
use glam::DVec3;

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::pair_sums::{StepsSinceCorrection, Sums};
use crate::resources::scene::ActiveScene;
use crate::systems::boundaries::emitter_states::EmitterStates;
use crate::systems::boundaries::movers::PresentPoses;
use crate::systems::boundaries::wall_contacts::WallContacts;
use covered_walls::CoveredWalls;
use sphecs_core::pass::body::{Body, BodySum, ExactBodySum};
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::Ranks;
use sphecs_core::pass::settings::{PairSettings, PressureLaw};
use sphecs_core::pass::wall_friction::add_friction_on;
use sphecs_core::physics::edac::Edac;
use sphecs_scene::model::{Body as SceneBody, Scene};
use sphecs_scene::movers::WallPoses;
use surface_shear::SurfaceShear;

/// Forces on all bodies at the beginning of a step.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct BodyForcesRow {
    /// Time, s.
    pub time: f64,
    /// Number of steps done before.
    pub step: u64,
    /// Force and torque of each body, in the order of the scene.
    pub forces: Vec<BodySum>,
    /// Motion of each body; None if it is at rest.
    pub motions: Vec<Option<BodyMotion>>,
}

/// Motion of a body at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct BodyMotion {
    /// Position of the point that torques are about, m.
    pub position: DVec3,
    /// Velocity of that point, m/s.
    pub velocity: DVec3,
    /// Angular velocity, rad/s.
    pub spin: DVec3,
}

impl BodyMotion {
    /// Returns the power of the fluid on the body, W (W/m in 2D): F·v + T·ω.
    pub fn power(&self, sum: &BodySum) -> f64 {
        let force = sum.pressure_force + sum.viscous_force;
        let torque = sum.pressure_torque + sum.viscous_torque;
        force.dot(self.velocity) + torque.dot(self.spin)
    }
}

/// Bodies of the scene, with the settings of the sums over them.
#[derive(Resource)]
pub struct Bodies {
    /// Forces at the beginning of the last step.
    pub row: BodyForcesRow,
    bodies: Vec<Body>,
    /// Surface shear of each body.
    shear: Vec<SurfaceShear>,
    covered: CoveredWalls,
    pair: PairSettings,
    edac: Edac,
    /// Sums over the particles of this rank.
    found: Vec<ExactBodySum>,
}

impl Bodies {
    /// Shares the sums with other ranks.
    pub(crate) fn connect(&mut self, ranks: Ranks) {
        self.pair.ranks = ranks;
    }
}

impl FromWorld for Bodies {
    fn from_world(world: &mut World) -> Self {
        let scene = &world.resource::<ActiveScene>().0;
        let pair = &world.resource::<Pair>().0;
        let edac = match pair.pressure {
            PressureLaw::Evolved(edac) => edac,
            PressureLaw::Tait => Edac::default(),
        };
        Self {
            row: BodyForcesRow::default(),
            bodies: scene.bodies.iter().map(|body| new_body(scene, body)).collect(),
            shear: scene.bodies.iter().map(|body| SurfaceShear::new(scene, body.part, body.about)).collect(),
            covered: CoveredWalls::default(),
            // `pass/body.rs` gives the reason for switching these two off.
            pair: PairSettings { tensile_control: false, ..pair.clone() },
            edac: Edac { average_pressure: false, ..edac },
            found: Vec::new(),
        }
    }
}

/// Returns the body of the sums.
fn new_body(scene: &Scene, body: &SceneBody) -> Body {
    let sums = Body::new(body.part, body.about);
    if scene.part_moves(body.part) { sums.moving() } else { sums }
}

/// Sums the forces on all bodies by the terms of `Wcsph`.
pub(crate) fn sum_body_forces<R: PairReal<D>, const D: usize>(
    (scene, poses, clock): (Res<ActiveScene>, Res<PresentPoses>, Res<Clock>),
    emitters: Option<Res<EmitterStates>>,
    grid: Res<Grid<D>>,
    since_correction: Res<StepsSinceCorrection>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut bodies: ResMut<Bodies>,
) {
    let Bodies { row, bodies, covered, pair, found, .. } = &mut *bodies;
    (row.time, row.step) = (clock.time, clock.step);
    find_motions((&scene.0, &poses.0), bodies, &mut row.motions);
    found.clear();
    found.extend(bodies.iter_mut().map(|body| {
        covered.collect((&scene.0, &poses.0), body.part, (&arrays, &pair.ranks), &mut body.others);
        add_emitters(&scene.0, emitters.as_deref(), body);
        let mut exact =
            R::sum_body_force(pair, &grid.0, &arrays, since_correction.time_level(), &mut sums.0, body);
        add_friction_on(pair, &grid.0, &arrays, &sums.0, body, &mut exact);
        exact
    }));
}

/// Sums the forces on all bodies by the terms of `EdacTvf`.
pub(crate) fn sum_edac_body_forces<R: PairReal<D>, const D: usize>(
    (scene, poses, clock): (Res<ActiveScene>, Res<PresentPoses>, Res<Clock>),
    emitters: Option<Res<EmitterStates>>,
    grid: Res<Grid<D>>,
    arrays: Res<Arrays<R, D>>,
    mut sums: ResMut<Sums<R, D>>,
    mut bodies: ResMut<Bodies>,
) {
    let Bodies { row, bodies, covered, pair, edac, found, .. } = &mut *bodies;
    (row.time, row.step) = (clock.time, clock.step);
    find_motions((&scene.0, &poses.0), bodies, &mut row.motions);
    found.clear();
    found.extend(bodies.iter_mut().map(|body| {
        covered.collect((&scene.0, &poses.0), body.part, (&arrays, &pair.ranks), &mut body.others);
        add_emitters(&scene.0, emitters.as_deref(), body);
        let mut exact = R::sum_edac_body_force(pair, edac, &grid.0, &arrays, &mut sums.0, body);
        add_friction_on(pair, &grid.0, &arrays, &sums.0, body, &mut exact);
        exact
    }));
}

/// Joins the sums of all ranks, and adds what the pair sums do not contain.
///
/// It runs after the work at openings, which differs from rank to rank: here they wait for each
/// other.
pub(crate) fn finish_body_forces(
    (scene, poses): (Res<ActiveScene>, Res<PresentPoses>),
    contacts: Res<WallContacts>,
    mut bodies: ResMut<Bodies>,
) {
    let Bodies { row, bodies, shear, pair, found, .. } = &mut *bodies;
    ExactBodySum::join_all(found, &pair.ranks);
    let time = row.time;
    row.forces.clear();
    let found = found.iter().zip(bodies).zip(shear).enumerate();
    row.forces.extend(found.map(|(index, ((found, body), shear))| {
        let mut sum = found.value();
        add_shear((&scene.0, &poses.0), time, shear, body, &mut sum);
        contacts.add(index, &mut sum);
        sum
    }));
}

/// Adds the inflow particles of the emitters on a body to those that count for it.
fn add_emitters(scene: &Scene, emitters: Option<&EmitterStates>, body: &mut Body) {
    if let Some(emitters) = emitters {
        emitters.add_numbers(scene, body.part, &mut body.others);
        body.others.sort_unstable();
    }
}

/// Finds the motions of the bodies, and moves the points that torques are about with them.
fn find_motions(
    (scene, poses): (&Scene, &WallPoses),
    bodies: &mut [Body],
    motions: &mut Vec<Option<BodyMotion>>,
) {
    motions.clear();
    motions.extend(bodies.iter_mut().zip(&scene.bodies).map(|(body, of_scene)| {
        let pose = scene.pose_of_part(poses, body.part)?;
        let position = pose.place(of_scene.about);
        body.about = scene.wrapped(position);
        Some(BodyMotion { position, velocity: pose.velocity_at(position), spin: pose.spin })
    }));
}

/// Adds the shear on a rotating or deforming surface that the pair sums omit.
fn add_shear(
    (scene, poses): (&Scene, &WallPoses),
    time: f64,
    shear: &SurfaceShear,
    body: &Body,
    sum: &mut BodySum,
) {
    let surface = match scene.pose_of_part(poses, body.part) {
        Some(pose) => shear.in_pose(scene, pose, scene.image_at_wall(poses, body.part, body.about)),
        None => shear.at(scene, &scene.walls.parts[usize::from(body.part)], body.about, time),
    };
    sum.viscous_force += surface.viscous_force;
    sum.viscous_torque += surface.viscous_torque;
}
