//! Particles of a saved state: the arrays and the values that only components or
//! [`ParticleDetails`] have.
//!
//! ```text
//! arrays.*      rows in their order, or by number after a caller changed components:
//!               zone, patch, flags,
//!               positions, velocities at both time levels, density, pressure, walls
//! particle.*    by number, free numbers included: tag, passages,
//!               whether it returned through an inlet
//! wall.*        distance and normal of the wall particles, in double precision
//! stored.*      the reservoir in the order in which it is emptied, from its end
//! grid.*        the box of the cell grid, which follows from the initial particles
//! ```
//!
//! All else follows from these columns. The other components repeat the row, the sub-particle
//! stress is computed before it is read, and the entities are new.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::world::World;
use glam::DVec3;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use crate::arrays::Arrays;
use crate::components::{
    ParticleBundle, ParticleId, Position, Thermodynamics, Tracer, Velocity, WallSurface,
};
use crate::resources::entity_index::{EntityIndex, FreeParticles};
use crate::resources::grid::Grid;
use crate::resources::inflow_particles::InflowParticles;
use crate::resources::ledger::{InflowCapacity, Ledger};
use crate::resources::pair::Pair;
use crate::resources::particle_details::ParticleDetails;
use crate::resources::scene::ActiveScene;
use crate::resources::state_location::{self, StateLocation};
use crate::spawn::{SavedParticle, spawn_saved};
use crate::systems::boundaries::opening_regions::OpeningRegions;
use crate::systems::boundaries::outlet_records::share_outlets;
use crate::systems::boundaries::outlets::Outlets;
use crate::systems::transitions::reservoir::FreeNumbers;
use sphecs_core::math::column::{ColumnMismatch, Columns};
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::saved::{self, Order};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Saves the particles of a world.
pub(crate) fn save<R: PairReal<D>, const D: usize>(world: &mut World, to: &mut Columns) {
    let order = match *world.resource::<StateLocation>() {
        StateLocation::Components => {
            // The next step starts from the components. Their order in the world depends on every
            // change of zone since the start and is not part of the state.
            state_location::gather::<R, D>(world);
            Order::ByNumber
        }
        StateLocation::Arrays | StateLocation::Both => Order::AsTheyStand,
    };
    save_grid::<D>(world, to);
    saved::save(world.resource::<Arrays<R, D>>(), order, to);
    save_rest(world, to);
}

/// Saves the particles of all ranks, in the order in which one rank alone would have them; all
/// ranks call it together, and rank 0 gets the state.
pub(crate) fn save_all<R: PairReal<D>, const D: usize>(world: &mut World, to: &mut Columns) {
    let ranks = world.resource::<Pair>().0.ranks.clone();
    let scene = world.resource::<ActiveScene>().0.clone();
    world.resource_scope(|world, mut outlets: Mut<Outlets<R, D>>| {
        share_outlets(&scene, &mut outlets, world.resource::<OpeningRegions>(), &ranks);
    });
    let all = ranks.all_rows(&world.resource::<Grid<D>>().0, &world.resource::<Arrays<R, D>>().0);
    if let Some(all) = all {
        save_grid::<D>(world, to);
        saved::save_owned(all, to);
        save_rest(world, to);
    }
}

/// Saves the box of the cell grid.
pub(super) fn save_grid<const D: usize>(world: &World, to: &mut Columns) {
    let grid = &world.resource::<Grid<D>>().0;
    to.put("grid.lower", grid.lower().to_vec());
    to.put("grid.upper", grid.upper().to_vec());
}

/// Saves what the arrays do not have.
fn save_rest(world: &mut World, to: &mut Columns) {
    let mut returned = vec![0_u8; world.resource::<EntityIndex>().len()];
    for id in world.resource::<InflowParticles>().returned() {
        returned[id as usize] = 1;
    }
    to.put("particle.returned", returned);
    to.put("stored.id", world.resource::<FreeParticles>().0.clone());
    match world.get_resource::<ParticleDetails>() {
        Some(details) => details.save(to),
        None => ParticleDetails::of_components(world).save(to),
    }
}

/// Restores the grid of a state over its saved box.
///
/// # Errors
/// [`ColumnMismatch`] if the state has no box or an empty one.
pub(crate) fn restore_grid<const D: usize>(
    scene: &Scene,
    pair: &Pair,
    from: &mut Columns,
) -> Result<CellGrid<D>, ColumnMismatch> {
    let [lower, upper] =
        [from.take_exactly::<f64>("grid.lower", D)?, from.take_exactly::<f64>("grid.upper", D)?];
    // More cells than a `u32` can count are never saved.
    let cells: f64 = (0..D)
        .map(|axis| ((upper[axis] - lower[axis]) / pair.0.discretisation.cell_size()).max(1.0))
        .product();
    let is_valid = (0..D).all(|axis| lower[axis] < upper[axis] && (upper[axis] - lower[axis]).is_finite());
    if !is_valid || cells > f64::from(u32::MAX) {
        return Err(ColumnMismatch(format!("the grid from {lower:?} to {upper:?} m is empty or not finite")));
    }
    let axes = |corner: Vec<f64>| std::array::from_fn(|axis| corner[axis]);
    let periodic = std::array::from_fn(|axis| scene.periodic[axis].is_some());
    Ok(CellGrid::new(
        axes(lower),
        axes(upper),
        periodic,
        pair.0.discretisation.support,
        pair.0.discretisation.cell_size(),
    ))
}

/// Fills the arrays of a world without particles, and gives the particles components, or none.
///
/// # Errors
/// [`ColumnMismatch`] if the columns do not fit the scene.
pub(crate) fn restore<R: PairReal<D>, const D: usize>(
    world: &mut World,
    has_components: bool,
    from: &mut Columns,
) -> Result<(), ColumnMismatch> {
    let scene = world.resource::<ActiveScene>().0.clone();
    let arrays = restore_arrays::<R, D>(world, from)?;
    let stored = from.take::<u32>("stored.id")?;
    let details = ParticleDetails::restore(stored.len(), from)?;
    let numbers = details.numbers();
    let returned = from.take_exactly::<u8>("particle.returned", numbers)?;
    let places = places(&scene, (&arrays, &stored), numbers)?;
    check_walls(&arrays, &places, details.walls())?;
    if has_components {
        spawn_saved(world, &scene, &saved_particles(&arrays, &places, (&details, &stored)));
        world.insert_resource(StateLocation::Both);
    } else {
        world.insert_resource(EntityIndex::without_entities(numbers as u32));
        world.insert_resource(details);
        world.insert_resource(StateLocation::Arrays);
    }
    world.insert_resource(inflow_particles(&scene, &arrays, |id| returned[id as usize] != 0));
    world.insert_resource(FreeParticles(stored));
    world.insert_resource(Arrays(arrays));
    Ok(())
}

/// Takes the arrays of a state.
///
/// # Errors
/// [`ColumnMismatch`] if they do not fit the scheme of the scene.
pub(super) fn restore_arrays<R: PairReal<D>, const D: usize>(
    world: &World,
    from: &mut Columns,
) -> Result<ParticleArrays<R, D>, ColumnMismatch> {
    let arrays = saved::restore::<R, D>(from)?;
    if arrays.evolves_pressure != world.resource::<Arrays<R, D>>().evolves_pressure {
        return Err(ColumnMismatch(
            "the columns of the pressure belong to another scheme than the scene has".to_owned(),
        ));
    }
    if arrays.drifts != world.resource::<Arrays<R, D>>().drifts {
        return Err(ColumnMismatch(
            "the columns of the drift belong to another scheme or other probes than the scene has".to_owned(),
        ));
    }
    Ok(arrays)
}

/// Returns the particles of the inflow zones in the arrays.
fn inflow_particles<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    has_returned: impl Fn(u32) -> bool,
) -> InflowParticles {
    let mut inflow = InflowParticles::none(scene.source_count());
    for row in (0..arrays.len()).filter(|&row| arrays.zone[row] == Zone::Inflow) {
        if has_returned(arrays.id[row]) {
            inflow.add_returned(arrays.id[row]);
        } else {
            inflow.inject(arrays.patch[row]);
        }
    }
    inflow
}

/// Place of a particle in a state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Place {
    /// The number is free.
    None,
    /// Row of the arrays.
    Row(u32),
    /// Reservoir.
    Stored,
}

/// Returns the places of all particles by their numbers.
fn places<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    (arrays, stored): (&ParticleArrays<R, D>, &[u32]),
    numbers: usize,
) -> Result<Vec<Place>, ColumnMismatch> {
    let mut places = vec![Place::None; numbers];
    let rows = (0..).zip(&arrays.id).map(|(row, &id)| (id, Place::Row(row)));
    for (id, place) in rows.chain(stored.iter().map(|&id| (id, Place::Stored))) {
        let found = places
            .get_mut(id as usize)
            .ok_or_else(|| ColumnMismatch(format!("there is a particle {id}, but only {numbers} numbers")))?;
        if std::mem::replace(found, place) != Place::None {
            return Err(ColumnMismatch(format!("particle {id} exists twice")));
        }
    }
    for (&zone, &patch) in arrays.zone.iter().zip(&arrays.patch) {
        check_patch(scene, zone, patch)?;
    }
    // Every number must be in use, unless the scene deletes particles.
    if scene.reservoir.recycle && places.contains(&Place::None) {
        let found = arrays.len() + stored.len();
        return Err(ColumnMismatch(format!("there are {found} particles for {numbers} numbers")));
    }
    Ok(places)
}

/// Checks that the wall particles are those with a wall surface.
fn check_walls<R: PairReal<D>, const D: usize>(
    arrays: &ParticleArrays<R, D>,
    places: &[Place],
    walls: &[(u32, WallSurface)],
) -> Result<(), ColumnMismatch> {
    let count = arrays.zone.iter().filter(|zone| **zone == Zone::Wall).count();
    if count != walls.len() {
        return Err(ColumnMismatch(format!(
            "there are {count} wall particles, but {} wall surfaces",
            walls.len()
        )));
    }
    let is_wall = |id: u32| match places.get(id as usize) {
        Some(Place::Row(row)) => arrays.zone[*row as usize] == Zone::Wall,
        _ => false,
    };
    match walls.iter().find(|(id, _)| !is_wall(*id)) {
        Some((id, _)) => {
            Err(ColumnMismatch(format!("particle {id} has a wall surface but is not a wall particle")))
        }
        None => Ok(()),
    }
}

/// Returns the particles by their numbers.
fn saved_particles<R: PairReal<D>, const D: usize>(
    arrays: &ParticleArrays<R, D>,
    places: &[Place],
    (details, stored): (&ParticleDetails, &[u32]),
) -> Vec<Option<SavedParticle>> {
    // In the order of the numbers, each thread writes one place of the memory.
    let particle = |place: &Place| {
        let Place::Row(row) = place else { return None };
        let state = arrays.row(*row as usize);
        let thermodynamics = Thermodynamics { density: state.density, pressure: state.pressure };
        let particle = saved_particle(state.id, state.zone, state.position, state.velocity, thermodynamics);
        Some(SavedParticle { patch: state.patch, ..particle })
    };
    let mut particles: Vec<Option<SavedParticle>> = places.par_iter().map(particle).collect();
    for (&id, stored) in stored.iter().zip(details.stored()) {
        let particle = saved_particle(id, Zone::Reservoir, stored.position, stored.velocity, stored.state);
        particles[id as usize] = Some(particle);
    }
    particles.par_iter_mut().enumerate().for_each(|(id, particle)| {
        if let Some(particle) = particle {
            particle.bundle.tracer = details.tracer(id as u32);
        }
    });
    for &(id, surface) in details.walls() {
        if let Some(particle) = &mut particles[id as usize] {
            particle.surface = surface;
        }
    }
    particles
}

fn saved_particle(
    id: u32,
    zone: Zone,
    position: DVec3,
    velocity: DVec3,
    thermodynamics: Thermodynamics,
) -> SavedParticle {
    SavedParticle {
        bundle: ParticleBundle {
            id: ParticleId(id),
            position: Position(position),
            velocity: Velocity(velocity),
            thermodynamics,
            tracer: Tracer::default(),
        },
        zone,
        patch: 0,
        surface: WallSurface::default(),
    }
}

fn check_patch(scene: &Scene, zone: Zone, patch: u16) -> Result<(), ColumnMismatch> {
    let patches = match zone {
        Zone::Inflow => scene.source_count(),
        Zone::Outflow => scene.outlets.len(),
        Zone::Wall => scene.walls.parts.len(),
        Zone::Fluid | Zone::Reservoir => 1,
    };
    if usize::from(patch) < patches {
        return Ok(());
    }
    Err(ColumnMismatch(format!(
        "a particle belongs to {} `{patch}`, but the scene has {patches}",
        zone.name()
    )))
}

/// Checks that the particle counts agree with the particles of the world.
///
/// # Errors
/// [`ColumnMismatch`] with both counts.
pub(crate) fn check_ledger<R: PairReal<D>, const D: usize>(world: &World) -> Result<(), ColumnMismatch> {
    let (arrays, stored) = (world.resource::<Arrays<R, D>>(), &world.resource::<FreeParticles>().0);
    let mut counted = [0; Zone::ALL.len()];
    arrays.zone.iter().for_each(|&zone| counted[zone as usize] += 1);
    counted[Zone::Reservoir as usize] += stored.len() as u64;
    let (ledger, scene) = (world.resource::<Ledger>(), &world.resource::<ActiveScene>().0);
    let through = [&ledger.entered, &ledger.entered_back, &ledger.left, &ledger.left_back].map(Vec::len);
    let (inlets, outlets) = (scene.source_count(), scene.outlets.len());
    let capacity = world.resource::<InflowCapacity>().0.len();
    if through != [inlets, inlets, outlets, outlets] || capacity != inlets {
        return Err(ColumnMismatch(format!(
            "the particle counts are not those of {inlets} inlets and emitters and {outlets} outlets"
        )));
    }
    let mut free: Vec<u32> = world.resource::<FreeNumbers>().0.iter().map(|free| free.id).collect();
    free.sort_unstable();
    let mut is_free = vec![true; world.resource::<EntityIndex>().len()];
    arrays.id.iter().chain(stored).for_each(|&id| is_free[id as usize] = false);
    if !free.iter().copied().eq((0..).zip(is_free).filter(|(_, is_free)| *is_free).map(|(id, _)| id)) {
        return Err(ColumnMismatch(format!("the free numbers {free:?} are not those without a particle")));
    }
    if ledger.by_zone == counted {
        return Ok(());
    }
    Err(ColumnMismatch(format!(
        "{:?} particles by zone are counted, but there are {counted:?}",
        ledger.by_zone
    )))
}
