//! State of the columns of emitters: the volume that each emitted, and its particles.

use std::collections::VecDeque;

use bevy_ecs::resource::Resource;
use serde::{Deserialize, Serialize};

use sphecs_core::particles::zone::Zone;
use sphecs_scene::model::{ParticleSeed, Scene};

/// Columns of the emitters of a scene.
#[derive(Resource, Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EmitterStates {
    /// Columns of each emitter, in the order of the scene.
    emitters: Vec<Vec<ColumnState>>,
    /// Place of each particle of a column, by its number; found from the columns.
    #[serde(skip)]
    places: Vec<ColumnPlace>,
}

/// Emitted volume and particles of a column.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct ColumnState {
    /// Emitted volume Q, m³ (m² in 2D).
    volume: f64,
    /// Part of it that is smaller than the rounding error, m³ (m² in 2D).
    rest: f64,
    /// Number of particles that it emitted.
    emitted: u32,
    /// Numbers of the particles in it, from the surface.
    particles: VecDeque<u32>,
}

/// Place of a particle in the columns of its emitter.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ColumnPlace {
    /// Index of the column.
    pub column: u32,
    /// Its number n among all that the column ever held.
    pub serial: u32,
}

impl ColumnState {
    /// Adds an emitted volume by a compensated sum.
    fn emit(&mut self, volume: f64) {
        let added = volume + self.rest;
        let sum = self.volume + added;
        self.rest = added - (sum - self.volume);
        self.volume = sum;
    }

    /// Returns the volume between the surface and a particle of the column, for the volume of a
    /// particle.
    fn between(&self, serial: u32, particle: f64) -> f64 {
        (f64::from(serial) + 0.5) * particle - self.volume - self.rest
    }
}

impl EmitterStates {
    /// Returns the columns of a scene whose seeds are given in the order of their numbers.
    pub(crate) fn new(scene: &Scene, seeds: &[ParticleSeed]) -> Self {
        let is_of_emitter =
            |seed: &ParticleSeed| seed.zone == Zone::Inflow && scene.emitter(seed.patch).is_some();
        let mut ids = (0..).zip(seeds).filter(|(_, seed)| is_of_emitter(seed)).map(|(id, _)| id);
        let emitters = scene.emitters.iter().map(|emitter| {
            let columns = emitter.columns.iter().map(|column| {
                let count = emitter.column_count(column, scene);
                ColumnState { particles: ids.by_ref().take(count).collect(), ..ColumnState::default() }
            });
            columns.collect()
        });
        Self { emitters: emitters.collect(), places: Vec::new() }
    }

    /// Returns the volume that each emitter emitted since the start, m³ (m² in 2D).
    pub fn emitted_volumes(&self) -> impl Iterator<Item = f64> {
        let volume =
            |columns: &Vec<ColumnState>| columns.iter().map(|column| column.volume + column.rest).sum();
        self.emitters.iter().map(volume)
    }

    /// Returns the largest difference of the emitted particles and the emitted volume of a column,
    /// in particles, for the volume of a particle.
    pub fn largest_difference(&self, particle: f64) -> f64 {
        let columns = self.emitters.iter().flatten();
        let difference = |column: &ColumnState| {
            (f64::from(column.emitted) - (column.volume + column.rest) / particle).abs()
        };
        columns.map(difference).fold(0.0, f64::max)
    }

    /// Adds the numbers of the particles of the emitters on a wall part: the fluid presses on them
    /// as on the wall around.
    pub(crate) fn add_numbers(&self, scene: &Scene, part: u16, numbers: &mut Vec<u32>) {
        for (emitter, columns) in scene.emitters.iter().zip(&self.emitters) {
            if emitter.part == part {
                numbers.extend(columns.iter().flat_map(|column| &column.particles));
            }
        }
    }

    /// Finds the places of the particles, unless they are known.
    pub(super) fn find_places(&mut self) {
        if !self.places.is_empty() {
            return;
        }
        for columns in &self.emitters {
            for (index, column) in columns.iter().enumerate() {
                for (serial, &id) in (column.emitted..).zip(&column.particles) {
                    set_place(&mut self.places, id, ColumnPlace { column: index as u32, serial });
                }
            }
        }
    }

    /// Returns the place of a particle, after [`Self::find_places`].
    pub(super) fn place(&self, id: u32) -> ColumnPlace {
        self.places[id as usize]
    }

    /// Returns the volume between the surface of an emitter and a place in one of its columns, for
    /// the volume of a particle, m³ (m² in 2D).
    pub(super) fn between(&self, emitter: usize, place: ColumnPlace, particle: f64) -> f64 {
        self.emitters[emitter][place.column as usize].between(place.serial, particle)
    }

    /// Adds the volumes that the columns emit in a step from `time`, s.
    pub(super) fn emit(&mut self, scene: &Scene, time: f64, time_step: f64) {
        for (emitter, columns) in scene.emitters.iter().zip(&mut self.emitters) {
            for (column, state) in emitter.columns.iter().zip(columns) {
                let speed = 0.5 * (emitter.speed(column, time) + emitter.speed(column, time + time_step));
                state.emit(column.area * speed * time_step);
            }
        }
    }

    /// Returns the columns that a particle crossed the surface of, in their order, with the number
    /// of the particle.
    pub(crate) fn crossed(&self, scene: &Scene) -> Vec<Crossed> {
        let volume = scene.discretisation.cell_volume();
        let mut crossed = Vec::new();
        for (emitter, columns) in self.emitters.iter().enumerate() {
            for (column, state) in columns.iter().enumerate() {
                for (serial, &id) in (state.emitted..).zip(&state.particles) {
                    if state.between(serial, volume) >= 0.0 {
                        break;
                    }
                    crossed.push(Crossed { emitter, column, id });
                }
            }
        }
        crossed
    }

    /// Takes the foremost particle out of a column, and returns the depth of the next at its end,
    /// m, for a stretch of the column.
    pub(crate) fn advance(&mut self, scene: &Scene, crossed: Crossed, stretch: f64) -> f64 {
        let volume = scene.discretisation.cell_volume();
        let state = &mut self.emitters[crossed.emitter][crossed.column];
        state.particles.pop_front();
        state.emitted += 1;
        let next = state.emitted + state.particles.len() as u32;
        let column = &scene.emitters[crossed.emitter].columns[crossed.column];
        column.depth(stretch * state.between(next, volume))
    }

    /// Adds a particle at the end of a column.
    pub(crate) fn append(&mut self, crossed: Crossed, id: u32) {
        let state = &mut self.emitters[crossed.emitter][crossed.column];
        let serial = state.emitted + state.particles.len() as u32;
        state.particles.push_back(id);
        set_place(&mut self.places, id, ColumnPlace { column: crossed.column as u32, serial });
    }
}

/// A particle that crossed the surface of its emitter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Crossed {
    /// Index of the emitter.
    pub emitter: usize,
    /// Index of its column.
    pub column: usize,
    /// Number of the particle.
    pub id: u32,
}

fn set_place(places: &mut Vec<ColumnPlace>, id: u32, place: ColumnPlace) {
    let index = id as usize;
    if places.len() <= index {
        places.resize(index + 1, ColumnPlace::default());
    }
    places[index] = place;
}
