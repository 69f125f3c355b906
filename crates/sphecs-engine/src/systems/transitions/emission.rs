//! Particles that cross the surfaces of emitters.
//!
//! A particle in front of its surface joins the fluid where it is, and a stored one is placed at
//! the end of its column. Fluid does not enter an emitter: it is held at the surface as at a wall.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::world::World;

use super::crossing::{Change, Crossing, set_zone};
use super::injection::{Injection, place};
use super::record;
use crate::resources::clock::Clock;
use crate::systems::boundaries::emitter_states::{Crossed, EmitterStates};
use crate::systems::boundaries::emitters::place_in_column;
use crate::systems::boundaries::inflow_columns::InflowColumns;
use crate::systems::boundaries::movers::PresentPoses;
use crate::systems::boundaries::patch_rows::PatchRows;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Lets the particles in front of their surfaces join the fluid, and fills the ends of the columns.
pub(super) fn emit<R: PairReal<D>, const D: usize>(
    world: &mut World,
    scene: &Scene,
    arrays: &mut ParticleArrays<R, D>,
) {
    if scene.emitters.is_empty() {
        return;
    }
    world.resource_scope(|world, mut states: Mut<EmitterStates>| {
        let crossed = states.crossed(scene);
        for &crossed in &crossed {
            let patch = (scene.inlets.len() + crossed.emitter) as u16;
            // Of several ranks, those that are not near the emitter have no row.
            if let Some(row) = row_of(world, arrays, crossed, patch) {
                set_zone(arrays, &Change { row, zone: Zone::Fluid, patch });
            }
            let zones = Crossing { from: Zone::Inflow, zone: Zone::Fluid, ..Crossing::default() };
            record(world, scene, &Crossing { id: crossed.id, opening: patch, patch, ..zones });
            let stretch = world.resource::<InflowColumns>().stretch(usize::from(patch));
            let depth = states.advance(scene, crossed, stretch);
            let (poses, time) = (&world.resource::<PresentPoses>().0, world.resource::<Clock>().time);
            let (position, velocity) = place_in_column((scene, poses), crossed, depth, time);
            let injection = Injection {
                place: position,
                zone: Zone::Inflow,
                patch,
                velocity,
                pressure: 0.0,
                returned: false,
            };
            if let Some(id) = place(world, scene, arrays, &injection) {
                states.append(crossed, id);
            }
        }
    });
}

/// Returns the row of a particle of an emitter. Few cross in a step.
fn row_of<R: PairReal<D>, const D: usize>(
    world: &World,
    arrays: &ParticleArrays<R, D>,
    crossed: Crossed,
    patch: u16,
) -> Option<usize> {
    let rows = &world.resource::<PatchRows>().inflow[usize::from(patch)];
    rows.iter().map(|&row| row as usize).find(|&row| arrays.id[row] == crossed.id)
}
