//! Projection of particles behind a wall to its surface.
//!
//! It applies to particles of the fluid and of outflow zones. Pressure keeps the particles off a
//! flat wall. At the tip of a sharp corner the nearest wall particle is 0.7 Δ inside, and particles
//! cut the corner. With six particles across a throat they do so by up to 0.1 Δ. Such a particle is
//! moved back to the surface along the normal and loses its velocity into the wall, at both time
//! levels; at a wall that moves, its velocity relative to the wall. [`WallProjections`] counts
//! these events for the monitor, and what the particles lose acts on
//! [bodies](super::wall_contacts). Where the count grows all the time, the spacing is too coarse
//! for the corner.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Mutex, PoisonError};

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::arrays::Arrays;
use crate::resources::clock::Clock;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::scene::ActiveScene;
use crate::systems::boundaries::movers::PresentPoses;
use crate::systems::boundaries::wall_contacts::{WallContact, WallContacts};
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::pair_real::PairReal;

/// Number of times that a fluid particle was moved back to a wall since the start.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct WallProjections(pub u64);

/// Distance from a wall before the step, over Δ, beyond which a particle cannot be behind it: the
/// displacement and shift of a step are shorter.
const NEAR: f64 = 0.5;

/// Distance in a scene with meshes, where a query takes some µs. It is still longer than the
/// displacement and shift of a step; a particle in a sharp corner may be moved back a step later.
const NEAR_MESHES: f64 = 0.25;

/// Step of the differences for the normal, over Δ.
const STEP: f64 = 1e-3;

/// Distance in front of the surface to which a particle is moved, over Δ: in the fluid in spite of
/// rounding.
const IN_FRONT: f64 = 1e-6;

/// Moves fluid and outflow particles that are behind a wall back to its surface.
pub fn project_to_walls<R: PairReal<D>, const D: usize>(
    (scene, poses): (Res<ActiveScene>, Res<PresentPoses>),
    (grid, pair): (Res<Grid<D>>, Res<Pair>),
    mut contacts: ResMut<WallContacts>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let (scene, poses) = (&*scene.0, &poses.0);
    // Extended beyond the far ends of the zones, which are not walls.
    let confines = &scene.layout.casing.confines;
    let has_mesh = confines.has_mesh() || scene.movers.iter().any(|mover| mover.shape.has_mesh());
    let near = R::from_f64(if has_mesh { NEAR_MESHES } else { NEAR } * scene.spacing);
    let ParticleArrays { zone, position, velocity, previous_velocity, wall_distance, .. } = &mut **arrays;
    let (zone, wall_distance) = (&*zone, &*wall_distance);
    let own = pair.0.ranks.own_cells();
    let count = AtomicU64::new(0);
    // Contacts are few: a lock costs nothing.
    let found = Mutex::new(std::mem::take(&mut contacts.found));
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        velocity.each_mut().map(Vec::as_mut_slice),
        previous_velocity.each_mut().map(Vec::as_mut_slice),
    );
    let work = |rows: Range<usize>, (position, mut now, mut before): RowColumns<R, D>| {
        // Most parts are far from all walls; a loop without branches finds this fast.
        if wall_distance[rows.clone()].iter().fold(true, |clear, &distance| clear & (distance >= near)) {
            return;
        }
        for (at, row) in rows.enumerate() {
            if !matches!(zone[row], Zone::Fluid | Zone::Outflow) || wall_distance[row] >= near {
                continue;
            }
            // A particle that has just crossed a periodic face is not outside: the next sort wraps
            // it.
            let inside = grid.0.wrap(std::array::from_fn(|axis| position[axis][at]));
            let mut point = DVec3::ZERO;
            for axis in 0..D {
                point[axis] = inside[axis];
            }
            let (behind, wall) = scene.nearest_wall(confines, poses, point);
            if behind <= 0.0 {
                continue;
            }
            let surface = scene.nearest_surface((wall, confines), poses, point, STEP * scene.spacing);
            let outwards = surface.outwards;
            let back = surface.point - outwards * (IN_FRONT * scene.spacing) - point;
            for axis in 0..D {
                position[axis][at] += back[axis];
            }
            let of_wall = surface.velocity.dot(outwards);
            let mut lost = [0.0; 2];
            for (velocity, lost) in [&mut now, &mut before].into_iter().zip(&mut lost) {
                let into: f64 = (0..D).map(|axis| velocity[axis][at].to_f64() * outwards[axis]).sum();
                *lost = (into - of_wall).max(0.0);
                for axis in 0..D {
                    velocity[axis][at] -= R::from_f64(*lost * outwards[axis]);
                }
            }
            if zone[row] == Zone::Fluid && own.has_row(&grid.0, row) {
                count.fetch_add(1, Ordering::Relaxed);
                if !scene.bodies.is_empty() && lost[0] > 0.0 {
                    let contact = WallContact { wall, point, lost: lost[0] * outwards };
                    found.lock().unwrap_or_else(PoisonError::into_inner).push(contact);
                }
            }
        }
    };
    for_each_part(0..zone.len(), columns, &work);
    contacts.found = found.into_inner().unwrap_or_else(PoisonError::into_inner);
    contacts.moved = count.into_inner();
}

/// Counts the particles of all ranks that were moved back to a wall, and sums the forces of those
/// that touched a body.
///
/// It runs after the change of zones, where the ranks wait for each other in any case.
pub fn join_projections(
    (scene, poses, clock): (Res<ActiveScene>, Res<PresentPoses>, Res<Clock>),
    pair: Res<Pair>,
    (mut projections, mut contacts): (ResMut<WallProjections>, ResMut<WallContacts>),
) {
    let found = [contacts.moved, contacts.found.len() as u64];
    let [moved, contacts_of_all] = pair.0.ranks.joined(found, |a, b| [a[0] + b[0], a[1] + b[1]]);
    projections.0 += moved;
    if contacts_of_all > 0 {
        contacts.sum(&scene.0, &poses.0, clock.time_step, &pair.0.ranks);
    } else {
        contacts.clear();
    }
}

/// Positions and velocities, present and previous, of the rows of a part.
type RowColumns<'a, R, const D: usize> = ([&'a mut [f64]; D], [&'a mut [R]; D], [&'a mut [R]; D]);
