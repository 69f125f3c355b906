//! State of single particles between two steps, as frames show it.

use bevy_ecs::world::World;
use glam::DVec3;

use crate::arrays::Arrays;
use crate::components::Tracer;
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::particle_details::ParticleDetails;
use sphecs_core::particles::rows::ParticleRow;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// State of a particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParticleState {
    /// Number.
    pub id: u32,
    /// Zone.
    pub zone: Zone,
    /// Index of the inlet, outlet or wall part; 0 for others.
    pub patch: u16,
    /// Position, m.
    pub position: DVec3,
    /// Velocity, m/s; of a wall, that of its surface.
    pub velocity: DVec3,
    /// Density, kg/m³.
    pub density: f64,
    /// Pressure, Pa.
    pub pressure: f64,
    /// Passive scalar and number of injections.
    pub tracer: Tracer,
}

/// Passes the state of each particle to `take`: of several ranks on rank 0, while all call it
/// together.
pub(crate) fn visit<R: PairReal<D>, const D: usize>(world: &mut World, take: &mut dyn FnMut(&ParticleState)) {
    let of_components =
        world.resource::<EntityIndex>().has_entities().then(|| ParticleDetails::of_components(world));
    // Ranks other than 0 have none.
    let none = ParticleDetails::default();
    let details = of_components.as_ref().or(world.get_resource::<ParticleDetails>()).unwrap_or(&none);
    let mut take_row = |row: &ParticleRow| {
        take(&ParticleState {
            id: row.id,
            zone: row.zone,
            patch: if row.zone == Zone::Fluid { 0 } else { row.patch },
            position: row.position,
            velocity: row.velocity,
            density: row.density,
            pressure: row.pressure,
            tracer: details.tracer(row.id),
        });
    };
    let (grid, arrays) = (&world.resource::<Grid<D>>().0, &world.resource::<Arrays<R, D>>().0);
    world.resource::<Pair>().0.ranks.for_each_row(grid, arrays, &mut take_row);
    for (&id, stored) in world.resource::<FreeParticles>().0.iter().zip(details.stored()) {
        take(&ParticleState {
            id,
            zone: Zone::Reservoir,
            patch: 0,
            position: stored.position,
            velocity: stored.velocity,
            density: stored.state.density,
            pressure: stored.state.pressure,
            tracer: details.tracer(id),
        });
    }
}
