//! Particles of a saved state: the arrays and the values that exist only in the components.
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
use crate::resources::scene::ActiveScene;
use crate::resources::state_location::{self, StateLocation};
use crate::spawn::{SavedParticle, spawn_saved};
use crate::systems::transitions::reservoir::FreeNumbers;
use crate::transfer::count_roles;
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
    save_components(world, to);
    save_stored(world, to);
}

/// Saves the box of the cell grid.
pub(super) fn save_grid<const D: usize>(world: &World, to: &mut Columns) {
    let grid = &world.resource::<Grid<D>>().0;
    to.put("grid.lower", grid.lower().to_vec());
    to.put("grid.upper", grid.upper().to_vec());
}

fn save_components(world: &mut World, to: &mut Columns) {
    let count = world.resource::<EntityIndex>().len();
    let mut tag = vec![0.0_f32; count];
    let mut passages = vec![0_u32; count];
    let mut returned = vec![0_u8; count];
    let mut walls: Vec<(u32, WallSurface)> = Vec::new();
    for id in world.resource::<InflowParticles>().returned() {
        returned[id as usize] = 1;
    }
    let mut particles = world.query::<(&ParticleId, &Tracer, Option<&WallSurface>)>();
    for (id, tracer, surface) in particles.iter(world) {
        let slot = id.0 as usize;
        tag[slot] = tracer.tag;
        passages[slot] = tracer.passages;
        walls.extend(surface.map(|surface| (id.0, *surface)));
    }
    walls.sort_unstable_by_key(|(id, _)| *id);
    to.put("particle.tag", tag);
    to.put("particle.passages", passages);
    to.put("particle.returned", returned);
    to.put("wall.id", walls.iter().map(|(id, _)| *id).collect::<Vec<u32>>());
    to.put("wall.distance", walls.iter().map(|(_, surface)| surface.distance).collect::<Vec<f64>>());
    to.put("wall.thickness", walls.iter().map(|(_, surface)| surface.thickness).collect::<Vec<f64>>());
    put_vectors("wall.normal", walls.iter().map(|(_, surface)| surface.normal), to);
}

fn save_stored(world: &World, to: &mut Columns) {
    let stored = &world.resource::<FreeParticles>().0;
    let index = world.resource::<EntityIndex>();
    let state: Vec<(DVec3, DVec3, Thermodynamics)> = stored
        .iter()
        .map(|&id| {
            let entity = world.entity(index.get(id).expect("a stored particle has an entity"));
            let state = entity.components::<(&Position, &Velocity, &Thermodynamics)>();
            (state.0.0, state.1.0, *state.2)
        })
        .collect();
    to.put("stored.id", stored.clone());
    put_vectors("stored.position", state.iter().map(|(position, ..)| *position), to);
    put_vectors("stored.velocity", state.iter().map(|(_, velocity, _)| *velocity), to);
    to.put("stored.density", state.iter().map(|(.., state)| state.density).collect::<Vec<f64>>());
    to.put("stored.pressure", state.iter().map(|(.., state)| state.pressure).collect::<Vec<f64>>());
}

fn put_vectors(name: &str, vectors: impl Iterator<Item = DVec3> + Clone, to: &mut Columns) {
    for axis in 0..3 {
        to.put(format!("{name}.{axis}"), vectors.clone().map(|vector| vector[axis]).collect::<Vec<f64>>());
    }
}

fn take_vectors(name: &str, count: usize, from: &mut Columns) -> Result<Vec<DVec3>, ColumnMismatch> {
    let mut vectors = vec![DVec3::ZERO; count];
    for axis in 0..3 {
        let values = from.take_exactly::<f64>(&format!("{name}.{axis}"), count)?;
        vectors.iter_mut().zip(values).for_each(|(vector, value)| vector[axis] = value);
    }
    Ok(vectors)
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

/// Spawns the particles of a state in a world without particles, and fills the arrays.
///
/// # Errors
/// [`ColumnMismatch`] if the columns do not fit the scene.
pub(crate) fn restore<R: PairReal<D>, const D: usize>(
    world: &mut World,
    from: &mut Columns,
) -> Result<(), ColumnMismatch> {
    let scene = world.resource::<ActiveScene>().0.clone();
    let arrays = restore_arrays::<R, D>(world, from)?;
    let stored = from.take::<u32>("stored.id")?;
    let tag = from.take::<f32>("particle.tag")?;
    let mut particles = moving(&scene, &arrays, tag.len())?;
    restore_stored(&stored, &mut particles, from)?;
    // Every number must be in use, unless the scene deletes particles.
    if scene.reservoir.recycle && particles.iter().any(Option::is_none) {
        let (found, slots) = (arrays.len() + stored.len(), particles.len());
        return Err(ColumnMismatch(format!("there are {found} particles for {slots} numbers")));
    }
    let returned = restore_components(&mut particles, tag, from)?;
    spawn_saved(world, &scene, &particles);
    world.insert_resource(inflow_particles(&scene, &arrays, |id| returned[id as usize] != 0));
    world.insert_resource(FreeParticles(stored));
    world.insert_resource(Arrays(arrays));
    world.insert_resource(StateLocation::Both);
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
pub(super) fn inflow_particles<R: PairReal<D>, const D: usize>(
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

/// Returns the particles of the arrays by their numbers.
fn moving<R: PairReal<D>, const D: usize>(
    scene: &Scene,
    arrays: &ParticleArrays<R, D>,
    count: usize,
) -> Result<Vec<Option<SavedParticle>>, ColumnMismatch> {
    const NONE: u32 = u32::MAX;
    let mut row_of = vec![NONE; count];
    for (row, &id) in (0..).zip(&arrays.id) {
        let slot = row_of.get_mut(id as usize).ok_or_else(|| beyond(id, count))?;
        if std::mem::replace(slot, row) != NONE {
            return Err(twice(id));
        }
    }
    for (&zone, &patch) in arrays.zone.iter().zip(&arrays.patch) {
        check_patch(scene, zone, patch)?;
    }
    // In the order of the numbers, each thread writes one place of the memory.
    let particle = |&row: &u32| {
        (row != NONE).then(|| {
            let state = arrays.row(row as usize);
            let thermodynamics = Thermodynamics { density: state.density, pressure: state.pressure };
            let particle =
                saved_particle(state.id, state.zone, state.position, state.velocity, thermodynamics);
            SavedParticle { patch: state.patch, ..particle }
        })
    };
    Ok(row_of.par_iter().map(particle).collect())
}

fn twice(id: u32) -> ColumnMismatch {
    ColumnMismatch(format!("particle {id} exists twice"))
}

fn beyond(id: u32, numbers: usize) -> ColumnMismatch {
    ColumnMismatch(format!("there is a particle {id}, but only {numbers} numbers"))
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

/// Inserts a particle at its number.
fn insert(particles: &mut [Option<SavedParticle>], particle: SavedParticle) -> Result<(), ColumnMismatch> {
    let id = particle.bundle.id.0;
    let count = particles.len();
    match particles.get_mut(id as usize) {
        Some(slot @ None) => *slot = Some(particle),
        Some(Some(_)) => return Err(twice(id)),
        None => return Err(beyond(id, count)),
    }
    Ok(())
}

fn restore_stored(
    stored: &[u32],
    particles: &mut [Option<SavedParticle>],
    from: &mut Columns,
) -> Result<(), ColumnMismatch> {
    let position = take_vectors("stored.position", stored.len(), from)?;
    let velocity = take_vectors("stored.velocity", stored.len(), from)?;
    let density = from.take_exactly::<f64>("stored.density", stored.len())?;
    let pressure = from.take_exactly::<f64>("stored.pressure", stored.len())?;
    for (at, &id) in stored.iter().enumerate() {
        let thermodynamics = Thermodynamics { density: density[at], pressure: pressure[at] };
        let particle = saved_particle(id, Zone::Reservoir, position[at], velocity[at], thermodynamics);
        insert(particles, particle)?;
    }
    Ok(())
}

/// Restores the values that only components have, and returns which particles returned from the
/// fluid.
fn restore_components(
    particles: &mut [Option<SavedParticle>],
    tag: Vec<f32>,
    from: &mut Columns,
) -> Result<Vec<u8>, ColumnMismatch> {
    let passages = from.take_exactly::<u32>("particle.passages", particles.len())?;
    let returned = from.take_exactly::<u8>("particle.returned", particles.len())?;
    particles.par_iter_mut().enumerate().for_each(|(slot, particle)| {
        let Some(particle) = particle else { return };
        particle.bundle.tracer = Tracer { tag: tag[slot], passages: passages[slot] };
    });
    let walls = from.take::<u32>("wall.id")?;
    let distance = from.take_exactly::<f64>("wall.distance", walls.len())?;
    let thickness = from.take_exactly::<f64>("wall.thickness", walls.len())?;
    let normal = take_vectors("wall.normal", walls.len(), from)?;
    let count = particles.iter().flatten().filter(|particle| particle.zone == Zone::Wall).count();
    if count != walls.len() {
        return Err(ColumnMismatch(format!(
            "there are {count} wall particles, but {} wall surfaces",
            walls.len()
        )));
    }
    for (at, id) in walls.into_iter().enumerate() {
        let wall = particles.get_mut(id as usize).and_then(Option::as_mut);
        let wall = wall.filter(|particle| particle.zone == Zone::Wall);
        let wall = wall.ok_or_else(|| {
            ColumnMismatch(format!("particle {id} has a wall surface but is not a wall particle"))
        })?;
        wall.surface = WallSurface { distance: distance[at], normal: normal[at], thickness: thickness[at] };
    }
    Ok(returned)
}

/// Checks that the particle counts agree with the particles of the world.
///
/// # Errors
/// [`ColumnMismatch`] with both counts.
pub(crate) fn check_ledger(world: &mut World) -> Result<(), ColumnMismatch> {
    let counted = count_roles(world);
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
    if !free.iter().copied().eq(world.resource::<EntityIndex>().free()) {
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
