//! Carries the state between its two homes: the components of the world and the sorted arrays.
//!
//! The arrays persist from step to step, so neither direction runs inside a step: [`gather`] only when a caller
//! changed components, [`scatter`] only before somebody reads them. Role changes touch single entities and are
//! made in both homes at once (`systems/transitions.rs`).

use bevy_ecs::query::{Has, With, Without};
use bevy_ecs::world::World;
use glam::DVec3;

use super::arrays::ParticleArrays;
use super::components::{
    Acceleration, Density, Fluid, Fresh, Inflow, Outflow, ParticleId, Position, Pressure, PreviousVelocity,
    Reservoir, SpsStress, Velocity, Wall, WallSurface,
};
use super::rows::{Row, real_vector, vector};
use super::zone::Zone;
use crate::math::real::Real;

/// Fills the arrays from the components of every particle that is not in the reservoir.
///
/// A particle whose velocity alone the caller changed takes a plain step next: the leapfrog would start from its
/// velocity one step earlier and lose the change.
pub fn gather<R: Real, const D: usize>(world: &mut World, arrays: &mut ParticleArrays<R, D>) {
    let left = Velocities::take(arrays);
    arrays.clear();
    let mut state = world.query_filtered::<(
        (&ParticleId, &Position, &Velocity, &PreviousVelocity, &Acceleration),
        (&Density, &Pressure, &Fresh),
        (Has<Fluid>, Option<&Wall>, Option<&WallSurface>, Option<&Inflow>, Option<&Outflow>),
    ), Without<Reservoir>>();
    for (kinematics, thermodynamics, roles) in state.iter(world) {
        let (id, position, velocity, previous, acceleration) = kinematics;
        let (density, pressure, fresh) = thermodynamics;
        let (_, wall, surface, inflow, outflow) = roles;
        let (zone, patch) = match (wall, inflow, outflow) {
            (Some(wall), _, _) => (Zone::Wall, wall.part),
            (_, Some(inflow), _) => (Zone::Inflow, inflow.inlet),
            (_, _, Some(outflow)) => (Zone::Outflow, outflow.outlet),
            _ => (Zone::Fluid, 0),
        };
        let surface = surface.copied().unwrap_or_default();
        arrays.push(&Row {
            id: id.0,
            zone,
            patch,
            fresh: fresh.0 || left.only_the_present_one_differs(id.0, velocity.0, previous.0),
            position: position.0,
            velocity: velocity.0,
            velocity_before: previous.0,
            acceleration: acceleration.0,
            density: density.0,
            pressure: pressure.0,
            wall_distance: surface.distance,
            wall_normal: surface.normal,
        });
    }
}

/// The velocities that the arrays held when the caller took the components.
struct Velocities<R, const D: usize> {
    row_of: Vec<u32>,
    present: [Vec<R>; D],
    before: [Vec<R>; D],
}

impl<R: Real, const D: usize> Velocities<R, D> {
    fn take(arrays: &mut ParticleArrays<R, D>) -> Self {
        Self {
            row_of: rows_by_number(&arrays.id),
            present: std::mem::replace(&mut arrays.velocity, std::array::from_fn(|_| Vec::new())),
            before: std::mem::replace(&mut arrays.velocity_before, std::array::from_fn(|_| Vec::new())),
        }
    }

    fn only_the_present_one_differs(&self, id: u32, present: DVec3, before: DVec3) -> bool {
        let Some(&row) = self.row_of.get(id as usize).filter(|&&row| row != u32::MAX) else { return false };
        let same = |columns: &[Vec<R>; D], vector: DVec3| {
            (0..D).all(|axis| columns[axis][row as usize] == R::from_f64(vector[axis]))
        };
        !same(&self.present, present) && same(&self.before, before)
    }
}

/// Writes the state of every row to the components of its particle.
pub fn scatter<R: Real, const D: usize>(world: &mut World, arrays: &ParticleArrays<R, D>) {
    let row_of = rows_by_number(&arrays.id);
    let mut state = world.query_filtered::<(
        &ParticleId,
        &mut Position,
        &mut Velocity,
        &mut PreviousVelocity,
        &mut Acceleration,
        &mut Density,
        &mut Pressure,
        &mut Fresh,
    ), Without<Reservoir>>();
    for (
        id,
        mut position,
        mut velocity,
        mut previous,
        mut acceleration,
        mut density,
        mut pressure,
        mut fresh,
    ) in state.iter_mut(world)
    {
        let Some(&row) = row_of.get(id.0 as usize) else {
            continue;
        };
        if row == u32::MAX {
            continue;
        }
        let row = row as usize;
        position.0 = vector(&arrays.position, row);
        velocity.0 = real_vector(&arrays.velocity, row);
        previous.0 = real_vector(&arrays.velocity_before, row);
        acceleration.0 = real_vector(&arrays.acceleration, row);
        density.0 = arrays.density[row].to_f64();
        pressure.0 = arrays.pressure[row].to_f64();
        fresh.0 = arrays.fresh[row];
    }
}

/// Writes the sub-particle stress, columns by component, to the particles that carry it; nothing where there are no columns.
pub fn scatter_stress<R: Real>(world: &mut World, id: &[u32], stress: &[Vec<R>]) {
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

/// The row of each particle number; `u32::MAX` where there is none.
fn rows_by_number(id: &[u32]) -> Vec<u32> {
    let slots = id.iter().max().map_or(0, |&largest| largest as usize + 1);
    let mut row_of = vec![u32::MAX; slots];
    for (row, &id) in id.iter().enumerate() {
        row_of[id as usize] = row as u32;
    }
    row_of
}

/// Number of particles by zone, counted in the components.
pub fn count_roles(world: &mut World) -> [u64; 5] {
    fn count<C: bevy_ecs::component::Component>(world: &mut World) -> u64 {
        world.query_filtered::<(), (With<ParticleId>, With<C>)>().iter(world).count() as u64
    }
    [
        count::<Fluid>(world),
        count::<Wall>(world),
        count::<Inflow>(world),
        count::<Outflow>(world),
        count::<Reservoir>(world),
    ]
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::components::{ParticleBundle, Passage, Tag};
    use super::*;

    fn bundle(id: u32, x: f64) -> ParticleBundle {
        ParticleBundle {
            id: ParticleId(id),
            position: Position(DVec3::new(x, 2.0 * x, 0.0)),
            velocity: Velocity(DVec3::new(-x, 0.5, 0.0)),
            previous_velocity: PreviousVelocity(DVec3::new(0.1, x, 0.0)),
            acceleration: Acceleration(DVec3::new(9.0, x, 0.0)),
            density: Density(1000.0 + x),
            pressure: Pressure(10.0 * x),
            tag: Tag(0.0),
            passage: Passage(0),
            fresh: Fresh(id == 2),
        }
    }

    #[test]
    fn state_survives_the_way_to_the_arrays_and_back() {
        let mut world = World::new();
        world.spawn((bundle(0, 1.0), Fluid));
        world.spawn((bundle(1, 2.0), Wall { part: 3 }, WallSurface::default()));
        world.spawn((bundle(2, 3.0), Outflow { outlet: 1 }));
        world.spawn((bundle(3, 4.0), Reservoir));
        let mut arrays = ParticleArrays::<f64, 2>::default();
        gather(&mut world, &mut arrays);
        assert_eq!(arrays.len(), 3, "the reservoir stays outside");
        let before: Vec<Row> = (0..3).map(|row| arrays.row(row)).collect();
        let mut positions = world.query::<&mut Position>();
        for mut position in positions.iter_mut(&mut world) {
            position.0 = DVec3::ZERO;
        }
        scatter(&mut world, &arrays);
        gather(&mut world, &mut arrays);
        assert_eq!(before, (0..3).map(|row| arrays.row(row)).collect::<Vec<_>>());
        assert_eq!(count_roles(&mut world), [1, 1, 0, 1, 1]);
    }
}
