//! The particles of a state: the arrays, and what the components have beside them.
//!
//! ```text
//! arrays.*      rows in their order, by number where a caller took the components: zone, patch, flags, positions, velocities at both
//!               time levels, density, pressure, walls
//! particle.*    by number, given or free: tag, passages, whether it came back through an inlet
//! wall.*        surfaces behind which wall particles stand, in the precision of the scene
//! stored.*      the reservoir in the order in which it is emptied
//! grid.*        the box of the cell grid, which comes from the start of the run
//! ```
//!
//! Everything else that a particle has follows from these: the components of one that is somewhere are its row, the stress is found
//! anew before anybody reads it, and an entity is a seat.

use bevy_ecs::entity::Entity;
use bevy_ecs::query::Has;
use bevy_ecs::world::World;
use glam::DVec3;

use crate::arrays::Arrays;
use crate::components::{
    ParticleBundle, ParticleId, Position, Returned, Thermodynamics, Tracer, Velocity, WallSurface,
};
use crate::systems::home::{self, FreshHome};
use crate::systems::ledger::Ledger;
use crate::systems::neighbours::Grid;
use crate::systems::pair::Pair;
use crate::systems::setup::{InflowCapacity, SavedParticle, SceneInUse, Seats, Stored, spawn_saved};
use crate::systems::transitions::stock::FreeNumbers;
use crate::transfer::count_roles;
use sphecs_core::math::column::{Columns, Misfit};
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::saved::{self, Order};
use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::Scene;

/// Puts the particles of a world.
pub fn save<R: Real, const D: usize>(world: &mut World, to: &mut Columns) {
    let order = match *world.resource::<FreshHome>() {
        FreshHome::Components => {
            // What a caller left in the components is what the next step would start from. The world hands them out in an order that
            // comes from how it was made and from every change of zone since: no part of the state.
            home::gather::<R, D>(world);
            Order::ByNumber
        }
        FreshHome::Arrays | FreshHome::Both => Order::AsTheyStand,
    };
    let grid = &world.resource::<Grid<D>>().0;
    to.put("grid.lower", grid.lower().to_vec());
    to.put("grid.upper", grid.upper().to_vec());
    saved::save(world.resource::<Arrays<R, D>>(), order, to);
    save_components(world, to);
    save_stored(world, to);
}

fn save_components(world: &mut World, to: &mut Columns) {
    let count = world.resource::<Seats>().0.len();
    let mut tag = vec![0.0_f32; count];
    let mut passages = vec![0_u32; count];
    let mut returned = vec![0_u8; count];
    let mut walls: Vec<(u32, WallSurface)> = Vec::new();
    let mut particles = world.query::<(&ParticleId, &Tracer, Has<Returned>, Option<&WallSurface>)>();
    for (id, tracer, came_back, surface) in particles.iter(world) {
        let slot = id.0 as usize;
        tag[slot] = tracer.tag;
        passages[slot] = tracer.passages;
        returned[slot] = u8::from(came_back);
        walls.extend(surface.map(|surface| (id.0, *surface)));
    }
    walls.sort_unstable_by_key(|(id, _)| *id);
    to.put("particle.tag", tag);
    to.put("particle.passages", passages);
    to.put("particle.returned", returned);
    to.put("wall.id", walls.iter().map(|(id, _)| *id).collect::<Vec<u32>>());
    to.put("wall.distance", walls.iter().map(|(_, surface)| surface.distance).collect::<Vec<f64>>());
    put_vectors("wall.normal", walls.iter().map(|(_, surface)| surface.normal), to);
}

fn save_stored(world: &World, to: &mut Columns) {
    let stored = &world.resource::<Stored>().0;
    let seats = &world.resource::<Seats>().0;
    let state: Vec<(DVec3, DVec3, Thermodynamics)> = stored
        .iter()
        .map(|&id| {
            let entity = world.entity(seats[id as usize]);
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

fn take_vectors(name: &str, count: usize, from: &mut Columns) -> Result<Vec<DVec3>, Misfit> {
    let mut vectors = vec![DVec3::ZERO; count];
    for axis in 0..3 {
        let values = from.take_exactly::<f64>(&format!("{name}.{axis}"), count)?;
        vectors.iter_mut().zip(values).for_each(|(vector, value)| vector[axis] = value);
    }
    Ok(vectors)
}

/// The grid of a state, over the box that it had.
///
/// # Errors
/// [`Misfit`] when the state has no box or an empty one.
pub fn restore_grid<const D: usize>(
    scene: &Scene,
    pair: &Pair,
    from: &mut Columns,
) -> Result<CellGrid<D>, Misfit> {
    let [lower, upper] =
        [from.take_exactly::<f64>("grid.lower", D)?, from.take_exactly::<f64>("grid.upper", D)?];
    // A box of more cells than rows can be counted in would never have been written.
    let cells: f64 = (0..D).map(|axis| ((upper[axis] - lower[axis]) / pair.0.cell_size()).max(1.0)).product();
    let sound = (0..D).all(|axis| lower[axis] < upper[axis] && (upper[axis] - lower[axis]).is_finite());
    if !sound || cells > f64::from(u32::MAX) {
        return Err(Misfit(format!("its grid from {lower:?} to {upper:?} m is none")));
    }
    let axes = |corner: Vec<f64>| std::array::from_fn(|axis| corner[axis]);
    let periodic = std::array::from_fn(|axis| scene.periodic[axis].is_some());
    Ok(CellGrid::new(axes(lower), axes(upper), periodic, pair.0.support(), pair.0.cell_size()))
}

/// Spawns the particles of a state in a world without any, and fills the arrays.
///
/// # Errors
/// [`Misfit`] when the columns are not those of the scene's particles.
pub fn restore<R: Real, const D: usize>(world: &mut World, from: &mut Columns) -> Result<(), Misfit> {
    let scene = world.resource::<SceneInUse>().0.clone();
    let arrays = saved::restore::<R, D>(from)?;
    if arrays.evolves_pressure != world.resource::<Arrays<R, D>>().evolves_pressure {
        return Err(Misfit("its pressure does not follow from the scheme of the scene".to_owned()));
    }
    if arrays.drifts != world.resource::<Arrays<R, D>>().drifts {
        return Err(Misfit("its drift does not follow from the scheme of the scene".to_owned()));
    }
    let stored = from.take::<u32>("stored.id")?;
    let tag = from.take::<f32>("particle.tag")?;
    let mut particles = vec![None; tag.len()];
    for row in 0..arrays.len() {
        let state = arrays.row(row);
        let thermodynamics = Thermodynamics { density: state.density, pressure: state.pressure };
        let particle = saved_particle(state.id, state.zone, state.position, state.velocity, thermodynamics);
        check_patch(&scene, state.zone, state.patch)?;
        seat(&mut particles, SavedParticle { patch: state.patch, ..particle })?;
    }
    restore_stored(&stored, &mut particles, from)?;
    // Every number once; only where particles are deleted nobody may have one.
    if scene.reservoir.recycle && particles.iter().any(Option::is_none) {
        let (found, slots) = (arrays.len() + stored.len(), particles.len());
        return Err(Misfit(format!("it has {found} particles for {slots} numbers")));
    }
    restore_components(&mut particles, tag, from)?;
    spawn_saved(world, &scene, &particles);
    world.insert_resource(Stored(stored));
    world.insert_resource(Arrays(arrays));
    world.insert_resource(FreshHome::Both);
    Ok(())
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
        returned: false,
        surface: WallSurface::default(),
    }
}

fn check_patch(scene: &Scene, zone: Zone, patch: u16) -> Result<(), Misfit> {
    let patches = match zone {
        Zone::Inflow => scene.inlets.len(),
        Zone::Outflow => scene.outlets.len(),
        Zone::Wall => scene.walls.parts.len(),
        Zone::Fluid | Zone::Reservoir => 1,
    };
    if usize::from(patch) < patches {
        return Ok(());
    }
    Err(Misfit(format!("it has a particle of {} `{patch}`, the scene has {patches}", zone.name())))
}

fn seat(particles: &mut [Option<SavedParticle>], particle: SavedParticle) -> Result<(), Misfit> {
    let id = particle.bundle.id.0;
    match particles.get_mut(id as usize) {
        Some(slot @ None) => *slot = Some(particle),
        Some(Some(_)) => return Err(Misfit(format!("it has particle {id} twice"))),
        None => return Err(Misfit(format!("it has a particle {id} among {}", particles.len()))),
    }
    Ok(())
}

fn restore_stored(
    stored: &[u32],
    particles: &mut [Option<SavedParticle>],
    from: &mut Columns,
) -> Result<(), Misfit> {
    let position = take_vectors("stored.position", stored.len(), from)?;
    let velocity = take_vectors("stored.velocity", stored.len(), from)?;
    let density = from.take_exactly::<f64>("stored.density", stored.len())?;
    let pressure = from.take_exactly::<f64>("stored.pressure", stored.len())?;
    for (at, &id) in stored.iter().enumerate() {
        let thermodynamics = Thermodynamics { density: density[at], pressure: pressure[at] };
        let particle = saved_particle(id, Zone::Reservoir, position[at], velocity[at], thermodynamics);
        seat(particles, particle)?;
    }
    Ok(())
}

fn restore_components(
    particles: &mut [Option<SavedParticle>],
    tag: Vec<f32>,
    from: &mut Columns,
) -> Result<(), Misfit> {
    let passages = from.take_exactly::<u32>("particle.passages", particles.len())?;
    let returned = from.take_exactly::<u8>("particle.returned", particles.len())?;
    for (slot, particle) in particles.iter_mut().enumerate() {
        let Some(particle) = particle else { continue };
        particle.bundle.tracer = Tracer { tag: tag[slot], passages: passages[slot] };
        particle.returned = returned[slot] != 0;
    }
    let walls = from.take::<u32>("wall.id")?;
    let distance = from.take_exactly::<f64>("wall.distance", walls.len())?;
    let normal = take_vectors("wall.normal", walls.len(), from)?;
    let count = particles.iter().flatten().filter(|particle| particle.zone == Zone::Wall).count();
    if count != walls.len() {
        return Err(Misfit(format!("it has {count} wall particles and {} wall surfaces", walls.len())));
    }
    for (at, id) in walls.into_iter().enumerate() {
        let wall = particles.get_mut(id as usize).and_then(Option::as_mut);
        let wall = wall.filter(|particle| particle.zone == Zone::Wall);
        let wall =
            wall.ok_or_else(|| Misfit(format!("it has a wall surface of particle {id}, which is no wall")))?;
        wall.surface = WallSurface { distance: distance[at], normal: normal[at] };
    }
    Ok(())
}

/// Checks that the ledger counts the particles that there are.
///
/// # Errors
/// [`Misfit`] with both counts.
pub fn check_ledger(world: &mut World) -> Result<(), Misfit> {
    let counted = count_roles(world);
    let (ledger, scene) = (world.resource::<Ledger>(), &world.resource::<SceneInUse>().0);
    let through = [&ledger.entered, &ledger.entered_back, &ledger.left, &ledger.left_back].map(Vec::len);
    let (inlets, outlets) = (scene.inlets.len(), scene.outlets.len());
    let capacity = world.resource::<InflowCapacity>().0.len();
    if through != [inlets, inlets, outlets, outlets] || capacity != inlets {
        return Err(Misfit(format!(
            "its ledger is of other openings than {inlets} inlets and {outlets} outlets"
        )));
    }
    let seats = &world.resource::<Seats>().0;
    let mut free: Vec<u32> = world.resource::<FreeNumbers>().0.iter().map(|free| free.id).collect();
    free.sort_unstable();
    let empty = (0..).zip(seats).filter(|(_, seat)| **seat == Entity::PLACEHOLDER).map(|(id, _)| id);
    if !free.iter().copied().eq(empty) {
        return Err(Misfit(format!("its free numbers {free:?} are not those that no particle has")));
    }
    if ledger.by_zone == counted {
        return Ok(());
    }
    Err(Misfit(format!("its ledger counts {:?} particles by zone, it has {counted:?}", ledger.by_zone)))
}
