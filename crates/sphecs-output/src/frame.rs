//! State of all particles at one time in the order of their numbers, for files, pictures and
//! export.

use std::ops::Range;

use bevy_ecs::entity::Entity;
use bevy_ecs::query::Has;
use bevy_ecs::world::World;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};
use rayon::slice::{ParallelSlice, ParallelSliceMut};

use sphecs_core::particles::zone::Zone;
use sphecs_engine::components::{
    Inflow, Outflow, ParticleId, Position, Reservoir, Thermodynamics, Tracer, Velocity, Wall,
};
use sphecs_engine::particle_state::ParticleState;
use sphecs_engine::resources::clock::Clock;
use sphecs_engine::resources::entity_index::EntityIndex;
use sphecs_engine::simulation::Simulation;
use sphecs_engine::systems::boundaries::movers::MoverParticles;

/// Value of `zone` for a slot without a particle: the reservoir may grow during a run, and
/// particles may be deleted.
pub const ABSENT: u8 = 255;

/// State at one time; slot i belongs to the particle with number i.
///
/// Positions are f64, all other columns f32. The last digit of f32, 6e-8 of the value, is far below
/// the error of the scheme. Positions, however, would lose the distances of neighbours in a long
/// domain. Reservoir particles and absent slots have NaN in all floating-point columns.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// Time, s.
    pub time: f64,
    /// Steps done.
    pub step: u64,
    /// Size of the last step, s.
    pub time_step: f64,
    /// Position x, y, z, m; z = 0 in 2D.
    pub position: [Vec<f64>; 3],
    /// Velocity u, v, w, m/s; w = 0 in 2D.
    pub velocity: [Vec<f32>; 3],
    /// Density, kg/m³.
    pub density: Vec<f32>,
    /// Pressure, Pa.
    pub pressure: Vec<f32>,
    /// Zone, a number of [`Zone`] or [`ABSENT`].
    pub zone: Vec<u8>,
    /// Index of the inlet, outlet or wall part; 0 for the others.
    pub patch: Vec<u16>,
    /// Number of injections from the reservoir, or of times that the particle number was reused.
    pub passage: Vec<u32>,
    /// Passive scalar.
    pub tag: Vec<f32>,
    /// Numbers of the wall particles that move.
    pub moving_walls: Range<u32>,
}

impl Frame {
    /// Returns a frame of `slots` absent particles.
    pub fn absent(slots: usize) -> Self {
        let mut frame = Self::default();
        frame.resize(slots);
        frame
    }

    /// Returns the number of slots.
    pub fn len(&self) -> usize {
        self.zone.len()
    }

    /// Returns true without slots.
    pub fn is_empty(&self) -> bool {
        self.zone.is_empty()
    }

    /// Changes the number of slots; new ones are absent.
    pub fn resize(&mut self, slots: usize) {
        for column in &mut self.position {
            column.resize(slots, f64::NAN);
        }
        for column in self.velocity.iter_mut().chain([&mut self.density, &mut self.pressure, &mut self.tag]) {
            column.resize(slots, f32::NAN);
        }
        self.zone.resize(slots, ABSENT);
        self.patch.resize(slots, 0);
        self.passage.resize(slots, 0);
    }

    /// Returns the slots of a zone.
    pub fn slots_of(&self, zone: Zone) -> impl Iterator<Item = usize> + '_ {
        (0..self.len()).filter(move |&slot| self.zone[slot] == zone as u8)
    }

    /// Returns the slots of the wall particles that do not move.
    pub fn fixed_walls(&self) -> impl Iterator<Item = usize> + '_ {
        self.slots_of(Zone::Wall).filter(|&slot| !self.moving_walls.contains(&(slot as u32)))
    }

    /// Returns the slots of the particles that flow or move: all but walls at rest, the reservoir
    /// and absent ones.
    pub fn present(&self) -> Vec<usize> {
        let is_present = |&slot: &usize| match Zone::from_number(self.zone[slot]) {
            Some(Zone::Wall) => self.moving_walls.contains(&(slot as u32)),
            zone => zone.is_some_and(Zone::flows),
        };
        (0..self.len()).filter(is_present).collect()
    }

    /// Returns the number of slots by zone, in the order of [`Zone::ALL`].
    pub fn counts(&self) -> [u64; 5] {
        let mut counts = [0; 5];
        for &zone in &self.zone {
            if let Some(count) = counts.get_mut(usize::from(zone)) {
                *count += 1;
            }
        }
        counts
    }

    /// Returns the lower and upper corner of the box around all particles with a position, m; None
    /// without any.
    pub fn bounds(&self) -> Option<[[f64; 3]; 2]> {
        let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
        for (axis, column) in self.position.iter().enumerate() {
            // `min` and `max` ignore NaN.
            corners[0][axis] = column.iter().copied().fold(f64::INFINITY, f64::min);
            corners[1][axis] = column.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        }
        corners.as_flattened().iter().all(|x| x.is_finite()).then_some(corners)
    }

    /// Returns the present state of a simulation.
    pub fn of(simulation: &mut Simulation) -> Self {
        if simulation.has_components() {
            return Self::from_world(simulation.world());
        }
        let mut frame = Self::begin(simulation.world());
        frame.resize(simulation.world().resource::<EntityIndex>().len());
        simulation.for_each_particle(&mut |particle| {
            if let Some(mut chunk) = frame.chunk_of(particle.id as usize) {
                chunk.put(0, particle);
            }
        });
        frame
    }

    /// Returns a frame of no particles at the time of a world.
    fn begin(world: &World) -> Self {
        let clock = world.resource::<Clock>();
        let mut frame =
            Frame { time: clock.time, step: clock.step, time_step: clock.time_step, ..Frame::default() };
        if let Some(moving) = world.get_resource::<MoverParticles>() {
            frame.moving_walls = moving.numbers();
        }
        frame
    }

    /// Returns the state of a world whose particles have components.
    fn from_world(world: &World) -> Self {
        let mut frame = Self::begin(world);
        let (particles, roles) = (world.try_query::<Particle>(), world.try_query::<Roles>());
        let (Some(mut particles), Some(mut roles)) = (particles, roles) else {
            unreachable!("a simulation registers the components of its particles")
        };
        let mut entities = Vec::new();
        for (entity, id, ..) in particles.iter(world) {
            let slot = id.0 as usize;
            if slot >= entities.len() {
                entities.resize(slot + 1, None);
            }
            entities[slot] = Some(entity);
        }
        let numbers = world.get_resource::<EntityIndex>().map_or(0, EntityIndex::len);
        entities.resize(numbers.max(entities.len()), None);
        frame.resize(entities.len());
        roles.update_archetypes(world);
        let (particles, roles) = (&particles, &roles);
        frame.chunks_mut().zip(entities.par_chunks(CHUNK)).for_each(|(mut chunk, entities)| {
            for (at, &entity) in entities.iter().enumerate() {
                let Some(entity) = entity else { continue };
                let (Ok(particle), Ok(role)) =
                    (particles.get_manual(world, entity), roles.get_manual(world, entity))
                else {
                    unreachable!("the particle has just been listed")
                };
                chunk.put(at, &state_of(particle, role));
            }
        });
        frame
    }

    /// Returns a slot.
    fn chunk_of(&mut self, slot: usize) -> Option<FrameChunk<'_>> {
        fn cut<T>(column: &mut [T], slot: usize) -> Option<&mut [T]> {
            column.get_mut(slot..=slot)
        }
        let [x, y, z] = &mut self.position;
        let [u, v, w] = &mut self.velocity;
        Some(FrameChunk {
            position: [cut(x, slot)?, cut(y, slot)?, cut(z, slot)?],
            velocity: [cut(u, slot)?, cut(v, slot)?, cut(w, slot)?],
            density: cut(&mut self.density, slot)?,
            pressure: cut(&mut self.pressure, slot)?,
            zone: cut(&mut self.zone, slot)?,
            patch: cut(&mut self.patch, slot)?,
            passage: cut(&mut self.passage, slot)?,
            tag: cut(&mut self.tag, slot)?,
        })
    }

    /// Returns all columns in chunks of slots.
    fn chunks_mut(&mut self) -> impl IndexedParallelIterator<Item = FrameChunk<'_>> {
        let [x, y, z] = &mut self.position;
        let [u, v, w] = &mut self.velocity;
        let vectors = (
            x.par_chunks_mut(CHUNK),
            y.par_chunks_mut(CHUNK),
            z.par_chunks_mut(CHUNK),
            u.par_chunks_mut(CHUNK),
            v.par_chunks_mut(CHUNK),
            w.par_chunks_mut(CHUNK),
        );
        let scalars = (
            self.density.par_chunks_mut(CHUNK),
            self.pressure.par_chunks_mut(CHUNK),
            self.zone.par_chunks_mut(CHUNK),
            self.patch.par_chunks_mut(CHUNK),
            self.passage.par_chunks_mut(CHUNK),
            self.tag.par_chunks_mut(CHUNK),
        );
        vectors.into_par_iter().zip(scalars).map(
            |((x, y, z, u, v, w), (density, pressure, zone, patch, passage, tag))| FrameChunk {
                position: [x, y, z],
                velocity: [u, v, w],
                density,
                pressure,
                zone,
                patch,
                passage,
                tag,
            },
        )
    }
}

/// Components of every particle.
type Particle = (
    Entity,
    &'static ParticleId,
    &'static Position,
    &'static Velocity,
    &'static Thermodynamics,
    &'static Tracer,
);

/// Components that state the role of a particle.
type Roles = (Option<&'static Wall>, Option<&'static Inflow>, Option<&'static Outflow>, Has<Reservoir>);

/// Slots that a thread fills at a time.
const CHUNK: usize = 8192;

/// Consecutive slots of a frame.
struct FrameChunk<'a> {
    position: [&'a mut [f64]; 3],
    velocity: [&'a mut [f32]; 3],
    density: &'a mut [f32],
    pressure: &'a mut [f32],
    zone: &'a mut [u8],
    patch: &'a mut [u16],
    passage: &'a mut [u32],
    tag: &'a mut [f32],
}

impl FrameChunk<'_> {
    /// Writes the state of a particle into the slot `at` of the chunk.
    fn put(&mut self, at: usize, particle: &ParticleState) {
        self.zone[at] = particle.zone as u8;
        self.patch[at] = particle.patch;
        self.passage[at] = particle.tracer.passages;
        if particle.zone == Zone::Reservoir {
            return;
        }
        for axis in 0..3 {
            self.position[axis][at] = particle.position[axis];
            self.velocity[axis][at] = particle.velocity[axis] as f32;
        }
        self.density[at] = particle.density as f32;
        self.pressure[at] = particle.pressure as f32;
        self.tag[at] = particle.tracer.tag;
    }
}

/// Returns the state that the components of a particle give.
fn state_of(
    (_, id, position, velocity, thermodynamics, tracer): (
        Entity,
        &ParticleId,
        &Position,
        &Velocity,
        &Thermodynamics,
        &Tracer,
    ),
    roles: (Option<&Wall>, Option<&Inflow>, Option<&Outflow>, bool),
) -> ParticleState {
    let (zone, patch) = match roles {
        (Some(wall), ..) => (Zone::Wall, wall.part),
        (_, Some(inflow), ..) => (Zone::Inflow, inflow.inlet),
        (_, _, Some(outflow), _) => (Zone::Outflow, outflow.outlet),
        (_, _, _, true) => (Zone::Reservoir, 0),
        _ => (Zone::Fluid, 0),
    };
    ParticleState {
        id: id.0,
        zone,
        patch,
        position: position.0,
        velocity: velocity.0,
        density: thermodynamics.density,
        pressure: thermodynamics.pressure,
        tracer: *tracer,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;
    use sphecs_engine::components::{Fluid, ParticleBundle};

    /// Returns a world that knows the components of particles, as that of a simulation does.
    fn world() -> World {
        let mut world = World::new();
        world.register_component::<Wall>();
        world.register_component::<Inflow>();
        world.register_component::<Outflow>();
        world.register_component::<Reservoir>();
        world
    }

    fn particle(id: u32) -> ParticleBundle {
        let number = f64::from(id);
        ParticleBundle {
            id: ParticleId(id),
            position: Position(DVec3::new(number, 0.5, 0.0)),
            velocity: Velocity(DVec3::new(0.1 * number, 0.0, 0.0)),
            thermodynamics: Thermodynamics { density: 1000.0 + number, pressure: -number },
            tracer: Tracer { tag: id as f32, passages: id },
        }
    }

    #[test]
    fn slots_follow_the_particle_numbers_in_any_order_of_the_tables() {
        let mut world = world();
        world.insert_resource(Clock { time: 0.5, step: 7, time_step: 1e-4 });
        world.spawn((particle(3), Wall { part: 2 }));
        world.spawn((particle(1), Inflow { inlet: 1 }));
        world.spawn((particle(4), Reservoir));
        world.spawn((particle(0), Fluid));
        world.spawn((particle(2), Outflow { outlet: 4 }));
        let frame = Frame::from_world(&world);

        assert_eq!((frame.time, frame.step, frame.time_step), (0.5, 7, 1e-4));
        assert_eq!(frame.zone, [0, 2, 3, 1, 4]);
        assert_eq!(frame.patch, [0, 1, 4, 2, 0]);
        assert_eq!(frame.passage, [0, 1, 2, 3, 4]);
        assert_eq!(&frame.position[0][..4], [0.0, 1.0, 2.0, 3.0]);
        assert_eq!(frame.density[3], 1003.0);
        assert!(frame.position[0][4].is_nan() && frame.velocity[0][4].is_nan());
        assert_eq!(frame.counts(), [1, 1, 1, 1, 1]);
        assert_eq!(frame.bounds(), Some([[0.0, 0.5, 0.0], [3.0, 0.5, 0.0]]));
    }

    #[test]
    fn missing_particle_number_is_absent() {
        let mut world = world();
        world.insert_resource(Clock::default());
        world.spawn((particle(2), Fluid));
        let frame = Frame::from_world(&world);
        assert_eq!(frame.zone, [ABSENT, ABSENT, 0]);
        assert_eq!(frame.counts(), [1, 0, 0, 0, 0]);
    }
}
