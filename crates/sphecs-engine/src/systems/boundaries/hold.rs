//! Impermeable walls: no particle of the fluid or of an outflow zone stays behind one.
//!
//! Pressure keeps the particles off a flat wall. At the tip of a sharp corner the nearest wall particle stands 0.7 Δ
//! inside, and a particle that rounds the corner cuts it: with six rows in a throat by up to 0.1 Δ. The surface does not
//! give way: such a particle is set back onto it along the normal and loses the velocity that it has into the wall,
//! at both time levels. [`HeldAtWalls`] counts how often, which the monitor shows: where it grows all the time, the
//! spacing is too coarse for the corner.

use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};

use bevy_ecs::resource::Resource;
use bevy_ecs::system::{Res, ResMut};
use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::arrays::Arrays;
use crate::resources::grid::Grid;
use crate::resources::scene::ActiveScene;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;

/// How often a fluid particle was set back onto a wall since the start.
#[derive(Resource, Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct HeldAtWalls(pub u64);

/// Only a particle that was as near as this to a wall before the step, over Δ, can be behind it: a step's way and shift
/// are shorter.
const NEAR: f64 = 0.5;

/// Step of the differences that give the normal, over Δ.
const STEP: f64 = 1e-3;

/// Depth in front of the surface at which a particle is put, over Δ: on the right side of it in spite of rounding.
const IN_FRONT: f64 = 1e-6;

/// Sets fluid particles that are behind a wall back onto its surface.
pub fn hold_at_walls<R: Real, const D: usize>(
    scene: Res<ActiveScene>,
    grid: Res<Grid<D>>,
    mut held: ResMut<HeldAtWalls>,
    mut arrays: ResMut<Arrays<R, D>>,
) {
    let scene = &*scene.0;
    // Drawn out beyond the far ends of the zones, which are no walls.
    let walls = &scene.layout.confines;
    let near = R::from_f64(NEAR * scene.spacing);
    let ParticleArrays { zone, position, velocity, velocity_before, wall_distance, .. } = &mut **arrays;
    let (zone, wall_distance) = (&*zone, &*wall_distance);
    let count = AtomicU64::new(0);
    let columns = (
        position.each_mut().map(Vec::as_mut_slice),
        velocity.each_mut().map(Vec::as_mut_slice),
        velocity_before.each_mut().map(Vec::as_mut_slice),
    );
    let work = |rows: Range<usize>, (position, mut now, mut before): Columns<R, D>| {
        // Most parts are far from all walls: a glance that has no branches finds it.
        if wall_distance[rows.clone()].iter().fold(true, |clear, &distance| clear & (distance >= near)) {
            return;
        }
        for (at, row) in rows.enumerate() {
            if !matches!(zone[row], Zone::Fluid | Zone::Outflow) || wall_distance[row] >= near {
                continue;
            }
            // A particle that has just crossed a periodic face is not outside: the next sort puts it in again.
            let inside = grid.0.wrap(std::array::from_fn(|axis| position[axis][at]));
            let mut point = DVec3::ZERO;
            for axis in 0..D {
                point[axis] = inside[axis];
            }
            if walls.signed_distance(point) <= 0.0 {
                continue;
            }
            let step = STEP * scene.spacing;
            let outwards = walls.gradient(point, step, D);
            let surface = walls.nearest_surface(point, step, D);
            let back = surface - outwards * (IN_FRONT * scene.spacing) - point;
            for axis in 0..D {
                position[axis][at] += back[axis];
            }
            for velocity in [&mut now, &mut before] {
                let into: f64 = (0..D).map(|axis| velocity[axis][at].to_f64() * outwards[axis]).sum();
                for axis in 0..D {
                    velocity[axis][at] -= R::from_f64(into.max(0.0) * outwards[axis]);
                }
            }
            if zone[row] == Zone::Fluid {
                count.fetch_add(1, Ordering::Relaxed);
            }
        }
    };
    for_each_part(0..zone.len(), columns, &work);
    held.0 += count.into_inner();
}

/// Positions and velocities, present and before, of a part's rows.
type Columns<'a, R, const D: usize> = ([&'a mut [f64]; D], [&'a mut [R]; D], [&'a mut [R]; D]);
