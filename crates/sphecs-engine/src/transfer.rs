//! Transfer of the particle state between the components of the world and the sorted arrays.
//!
//! The arrays persist from step to step, so neither direction runs inside a step: [`gather`] only
//! after a caller changed components, [`scatter`] only before components are read. Changes of role
//! concern single entities and are made in both copies at once (`systems/transitions/`).

use bevy_ecs::entity::Entity;
use bevy_ecs::query::{Has, With, Without};
use bevy_ecs::world::World;
use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::components::{
    Fluid, Inflow, Outflow, ParticleId, Position, Reservoir, SpsStress, Thermodynamics, Velocity, Wall,
    WallSurface,
};
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::rows::{ParticleRow, real_vector, vector};
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// Fills the arrays from the components of every particle that is not in the reservoir.
///
/// A particle whose velocity, and under `EdacTvf` pressure, the caller left unchanged keeps its
/// previous velocity and pressure and its drift. A changed or new particle takes a corrective step
/// next: the integrator would start from the previous velocity and lose the change.
pub(crate) fn gather<R: PairReal<D>, const D: usize>(world: &mut World, arrays: &mut ParticleArrays<R, D>) {
    let history = History::take(arrays);
    arrays.clear();
    let mut state = world.query_filtered::<(
        (&ParticleId, &Position, &Velocity, &Thermodynamics),
        (Has<Fluid>, Option<&Wall>, Option<&WallSurface>, Option<&Inflow>, Option<&Outflow>),
    ), Without<Reservoir>>();
    // Reading the components takes longer than listing the particles and filling the columns.
    let particles: Vec<Entity> = world.query_filtered::<Entity, Listed>().iter(world).collect();
    arrays.reserve(particles.len());
    state.update_archetypes(world);
    let row = |&entity: &Entity| {
        let found = state.get_manual(world, entity);
        let ((id, position, velocity, thermodynamics), roles) = found.expect("a particle just listed");
        let (_, wall, surface, inflow, outflow) = roles;
        let (zone, patch) = match (wall, inflow, outflow) {
            (Some(wall), _, _) => (Zone::Wall, wall.part),
            (_, Some(inflow), _) => (Zone::Inflow, inflow.inlet),
            (_, _, Some(outflow)) => (Zone::Outflow, outflow.outlet),
            _ => (Zone::Fluid, 0),
        };
        let surface = surface.copied().unwrap_or_default();
        let past = history.of(id.0, velocity.0, thermodynamics.pressure).unwrap_or(Past {
            velocity: velocity.0,
            pressure: thermodynamics.pressure,
            drift: DVec3::ZERO,
            needs_restart: true,
        });
        ParticleRow {
            id: id.0,
            zone,
            patch,
            needs_restart: past.needs_restart,
            position: position.0,
            velocity: velocity.0,
            previous_velocity: past.velocity,
            density: thermodynamics.density,
            pressure: thermodynamics.pressure,
            previous_pressure: past.pressure,
            drift: past.drift,
            wall_distance: surface.distance,
            wall_normal: surface.normal,
            wall_thickness: surface.thickness,
        }
    };
    let mut rows = Vec::with_capacity(BATCH.min(particles.len()));
    for batch in particles.chunks(BATCH) {
        batch.par_iter().with_min_len(CHUNK).map(row).collect_into_vec(&mut rows);
        arrays.extend(&rows);
    }
}

/// Particles with a place in the arrays.
type Listed = (With<ParticleId>, With<Position>, With<Velocity>, With<Thermodynamics>, Without<Reservoir>);

/// Particles whose components are read at once, before the columns are filled: their rows take
/// less than 20 MB.
const BATCH: usize = 65_536;

/// Columns of the arrays that only the integrator needs, saved before the arrays are filled from
/// the components.
struct History<R, const D: usize> {
    row_of: Vec<u32>,
    needs_restart: Vec<bool>,
    present: [Vec<R>; D],
    before: [Vec<R>; D],
    /// Current pressure, Pa; empty if the pressure follows from the density.
    pressure: Vec<R>,
    previous_pressure: Vec<R>,
    /// Drift, m/s; empty if it is not stored.
    drift: [Vec<R>; D],
}

/// Values of a particle that only the integrator needs.
struct Past {
    velocity: DVec3,
    pressure: f64,
    drift: DVec3,
    needs_restart: bool,
}

impl<R: PairReal<D>, const D: usize> History<R, D> {
    fn take(arrays: &mut ParticleArrays<R, D>) -> Self {
        let columns = |columns: &mut [Vec<R>; D]| columns.each_mut().map(std::mem::take);
        Self {
            row_of: rows_by_number(&arrays.id),
            needs_restart: std::mem::take(&mut arrays.needs_restart),
            present: columns(&mut arrays.velocity),
            before: columns(&mut arrays.previous_velocity),
            pressure: if arrays.evolves_pressure { std::mem::take(&mut arrays.pressure) } else { Vec::new() },
            previous_pressure: std::mem::take(&mut arrays.previous_pressure),
            drift: columns(&mut arrays.drift),
        }
    }

    /// Returns the previous values of a particle if its velocity (m/s) and, under `EdacTvf`, its
    /// pressure (Pa) are unchanged.
    fn of(&self, id: u32, velocity: DVec3, pressure: f64) -> Option<Past> {
        let row = *self.row_of.get(id as usize).filter(|&&row| row != u32::MAX)? as usize;
        let evolves = !self.pressure.is_empty();
        let is_unchanged = (0..D).all(|axis| self.present[axis][row] == R::from_f64(velocity[axis]))
            && (!evolves || self.pressure[row] == R::from_f64(pressure));
        is_unchanged.then(|| Past {
            velocity: real_vector(&self.before, row),
            pressure: if evolves { self.previous_pressure[row].to_f64() } else { pressure },
            drift: if self.drift[0].is_empty() { DVec3::ZERO } else { real_vector(&self.drift, row) },
            needs_restart: self.needs_restart[row],
        })
    }
}

/// Particles per task of a thread.
const CHUNK: usize = 4096;

/// Writes the state of every row to the components of its particle.
pub(crate) fn scatter<R: PairReal<D>, const D: usize>(world: &mut World, arrays: &ParticleArrays<R, D>) {
    let row_of = rows_by_number(&arrays.id);
    let mut state = world.query_filtered::<(
        &ParticleId,
        &mut Position,
        &mut Velocity,
        &mut Thermodynamics,
    ), Without<Reservoir>>();
    // One slice per table, that is, per set of components. All components of particles are stored
    // in tables.
    let Ok(tables) = state.contiguous_iter_mut(world) else {
        unreachable!("all components of particles are stored in tables")
    };
    for (ids, mut positions, mut velocities, mut states) in tables {
        let columns = (ids, &mut *positions, &mut *velocities, &mut *states);
        columns.into_par_iter().with_min_len(CHUNK).for_each(|(id, position, velocity, state)| {
            let Some(&row) = row_of.get(id.0 as usize).filter(|&&row| row != u32::MAX) else { return };
            let row = row as usize;
            position.0 = vector(&arrays.position, row);
            velocity.0 = real_vector(&arrays.velocity, row);
            *state = Thermodynamics {
                density: arrays.density[row].to_f64(),
                pressure: arrays.pressure[row].to_f64(),
            };
        });
    }
}

/// Writes the sub-particle stress, one column per component, to the particles with [`SpsStress`].
///
/// Does nothing if there are no columns.
pub(crate) fn scatter_stress<R: Real>(world: &mut World, id: &[u32], stress: &[Vec<R>]) {
    // The columns are xx, yy, xy in 2D and xx, yy, zz, xy, yz, zx in 3D.
    let slots: &[usize] = if stress.len() == 3 { &[0, 1, 3] } else { &[0, 1, 2, 3, 4, 5] };
    if stress.iter().any(|column| column.len() != id.len()) || stress.len() != slots.len() {
        return;
    }
    let row_of = rows_by_number(id);
    let mut carriers = world.query_filtered::<(&ParticleId, &mut SpsStress), Without<Reservoir>>();
    for (id, mut carried) in carriers.iter_mut(world) {
        if let Some(&row) = row_of.get(id.0 as usize).filter(|&&row| row != u32::MAX) {
            for (&slot, column) in slots.iter().zip(stress) {
                carried.0[slot] = column[row as usize].to_f64();
            }
        }
    }
}

/// Returns the row of each particle number, `u32::MAX` for a number without a row.
pub(crate) fn rows_by_number(id: &[u32]) -> Vec<u32> {
    let slots = id.iter().max().map_or(0, |&largest| largest as usize + 1);
    let mut row_of = vec![u32::MAX; slots];
    for (row, &id) in id.iter().enumerate() {
        row_of[id as usize] = row as u32;
    }
    row_of
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::components::{ParticleBundle, Tracer};

    fn bundle(id: u32, x: f64) -> ParticleBundle {
        ParticleBundle {
            id: ParticleId(id),
            position: Position(DVec3::new(x, 2.0 * x, 0.0)),
            velocity: Velocity(DVec3::new(-x, 0.5, 0.0)),
            thermodynamics: Thermodynamics { density: 1000.0 + x, pressure: 10.0 * x },
            tracer: Tracer::default(),
        }
    }

    fn gathered(world: &mut World) -> ParticleArrays<f64, 2> {
        let mut arrays = ParticleArrays::default();
        gather(world, &mut arrays);
        arrays
    }

    fn rows(arrays: &ParticleArrays<f64, 2>) -> Vec<ParticleRow> {
        (0..arrays.len()).map(|row| arrays.row(row)).collect()
    }

    #[test]
    fn transfer_to_the_arrays_and_back_keeps_the_state() {
        let mut world = World::new();
        world.spawn((bundle(0, 1.0), Fluid));
        world.spawn((bundle(1, 2.0), Wall { part: 3 }, WallSurface::default()));
        world.spawn((bundle(2, 3.0), Outflow { outlet: 1 }));
        world.spawn((bundle(3, 4.0), Reservoir));
        let mut arrays = gathered(&mut world);
        assert_eq!(arrays.len(), 3, "the reservoir has no rows");
        for row in 0..3 {
            assert!(
                arrays.row(row).needs_restart
                    && arrays.row(row).previous_velocity == arrays.row(row).velocity
            );
            arrays.needs_restart[row] = false;
            arrays.previous_velocity[0][row] = 7.0;
        }
        let before = rows(&arrays);
        let mut positions = world.query::<&mut Position>();
        for mut position in positions.iter_mut(&mut world) {
            position.0 = DVec3::ZERO;
        }
        scatter(&mut world, &arrays);
        gather(&mut world, &mut arrays);
        assert_eq!(before, rows(&arrays));
    }

    #[test]
    fn only_a_particle_with_changed_velocity_takes_a_corrective_step() {
        let mut world = World::new();
        let entities = [0, 1].map(|id| world.spawn((bundle(id, 1.0), Fluid)).id());
        let mut arrays = gathered(&mut world);
        arrays.needs_restart.fill(false);
        arrays.previous_velocity[1].fill(0.25);
        world.entity_mut(entities[1]).insert(Velocity(DVec3::X));
        gather(&mut world, &mut arrays);
        let [kept, changed] = [arrays.row(0), arrays.row(1)];
        assert!(!kept.needs_restart && kept.previous_velocity == DVec3::new(0.0 - 1.0, 0.25, 0.0));
        assert!(changed.needs_restart && changed.previous_velocity == DVec3::X);
    }
}
