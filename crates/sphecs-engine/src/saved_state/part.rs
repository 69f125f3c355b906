//! Part of a state: what a rank needs of the particles that it holds.
//!
//! ```text
//! grid.*        the box of the cell grid, as in a whole state
//! arrays.*      rows of the particles that the rank holds
//! part.*        numbers given out, of stored particles and of those that returned to an inlet
//! ```
//!
//! The rank has no components: only rank 0 reads them.

use bevy_ecs::world::World;

use super::particles::{restore_arrays, save_grid};
use crate::arrays::Arrays;
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::scene::ActiveScene;
use crate::resources::state_location::StateLocation;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::particles::saved;
use sphecs_core::pass::pair_real::PairReal;

/// Saves rows of the arrays, which must be current, for a rank that holds them.
pub(crate) fn save<R: PairReal<D>, const D: usize>(world: &World, rows: Vec<u32>, to: &mut Columns) {
    save_grid::<D>(world, to);
    saved::save_rows(world.resource::<Arrays<R, D>>(), rows, to);
    to.put("part.numbers", vec![world.resource::<EntityIndex>().len() as u32]);
    to.put("part.stored", world.resource::<FreeParticles>().0.clone());
    let inflow = world.resource::<InflowParticles>();
    to.put("part.returned", inflow.returned().collect::<Vec<u32>>());
    let sources = world.resource::<ActiveScene>().0.source_count() as u16;
    to.put("part.inflow", (0..sources).map(|source| inflow.others(source) as u32).collect::<Vec<u32>>());
}

/// Fills the arrays of a world without particles.
///
/// # Errors
/// [`ColumnMismatch`] if the columns do not fit the scene.
pub(crate) fn restore<R: PairReal<D>, const D: usize>(
    world: &mut World,
    from: &mut Columns,
) -> Result<(), ColumnMismatch> {
    let arrays = restore_arrays::<R, D>(world, from)?;
    let numbers = from.take_exactly::<u32>("part.numbers", 1)?[0];
    let stored = from.take("part.stored")?;
    let returned = from.take::<u32>("part.returned")?;
    let others = from.take_exactly("part.inflow", world.resource::<ActiveScene>().0.source_count())?;
    world.insert_resource(InflowParticles::new(returned, others));
    world.insert_resource(EntityIndex::without_entities(numbers));
    world.insert_resource(FreeParticles(stored));
    world.insert_resource(Arrays(arrays));
    world.insert_resource(StateLocation::Arrays);
    Ok(())
}
