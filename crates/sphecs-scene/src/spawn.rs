//! The particles of a scene at t = 0.

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelExtend, ParallelIterator};
use rayon::slice::ParallelSliceMut;

use super::expression::Expression;
use super::fill::{Place, places};
use super::model::{ParticleSeed, Scene};
use super::movers::{Wall, WallPoses};
use super::thin_walls::find_thicknesses;
use super::wall_particles;
use sphecs_core::particles::zone::Zone;

/// Returns all particles at t = 0: fluid, wall, inflow, outflow, reservoir, each zone in the order
/// of its lattice. The list is reproducible bit by bit.
pub fn seeds(scene: &Scene) -> Vec<ParticleSeed> {
    let mut places = places(scene);
    // The order of the lattice stays within a zone; walls that move come last among the walls.
    let wall = |place: &Place| if place.zone == Zone::Wall { place.patch } else { 0 };
    places.par_sort_by_key(|place| (place.zone, wall(place)));
    let poses = scene.wall_poses(0.0);
    let mut seeds = Vec::with_capacity(places.len() + scene.reservoir.initial);
    seeds.par_extend(places.into_par_iter().map(|place| seed(scene, &poses, place)));
    set_emitter_velocities(scene, &mut seeds);
    if scene.walls.one_sided {
        find_thicknesses(scene, &mut seeds);
    }
    let parked = scene.inlets.first().map_or(DVec3::ZERO, |inlet| inlet.patch.at);
    let reservoir = ParticleSeed {
        position: parked,
        zone: Zone::Reservoir,
        patch: 0,
        velocity: DVec3::ZERO,
        pressure: 0.0,
        tag: 0.0,
        wall_distance: 0.0,
        wall_normal: DVec3::ZERO,
        wall_thickness: 0.0,
    };
    seeds.extend(std::iter::repeat_n(reservoir, scene.reservoir.initial));
    seeds
}

fn seed(scene: &Scene, poses: &WallPoses, place: Place) -> ParticleSeed {
    let position = place.position;
    let at = |expression: &Expression| expression.value(position.x, position.y, position.z, 0.0);
    let mut seed = ParticleSeed {
        position,
        zone: place.zone,
        patch: place.patch,
        velocity: DVec3::from(scene.initial.velocity.each_ref().map(at)),
        pressure: at(&scene.initial.pressure),
        tag: at(&scene.initial.tag),
        wall_distance: 0.0,
        wall_normal: DVec3::ZERO,
        wall_thickness: 0.0,
    };
    match place.zone {
        Zone::Wall => {
            let surface = wall_particles::surface(scene, Wall::numbered(place.patch), position);
            let part = &scene.walls.parts[usize::from(surface.part)];
            let foot = position + surface.normal * surface.distance;
            seed.patch = surface.part;
            seed.velocity = match scene.pose_of_part(poses, surface.part) {
                Some(pose) => pose.velocity_at(foot),
                None => part.velocity_at(foot, 0.0),
            };
            seed.wall_distance = surface.distance;
            seed.wall_normal = surface.normal;
        }
        Zone::Inflow => {
            if let Some(inlet) = scene.inlets.get(usize::from(place.patch)) {
                seed.velocity = inlet.velocity_at(scene.fluid.viscosity, position, 0.0);
            }
        }
        Zone::Fluid | Zone::Outflow | Zone::Reservoir => {}
    }
    seed
}

/// Sets the velocities of the inflow particles of the emitters, which are in the order of
/// [`Emitter::particles`](super::emitters::Emitter::particles).
fn set_emitter_velocities(scene: &Scene, seeds: &mut [ParticleSeed]) {
    let is_of_emitter =
        |seed: &&mut ParticleSeed| seed.zone == Zone::Inflow && scene.emitter(seed.patch).is_some();
    let particles = scene
        .emitters
        .iter()
        .flat_map(|emitter| emitter.particles(scene).map(move |particle| (emitter, particle)));
    for (seed, (emitter, particle)) in seeds.iter_mut().filter(is_of_emitter).zip(particles) {
        let (column, pose) = (&emitter.columns[particle.column], scene.start_pose(emitter.wall));
        seed.velocity = emitter.velocity_in(column, particle.depth, pose, 0.0);
    }
}
