//! Readings of a simulation between two steps: fields at points, integral quantities, all
//! particles.
//!
//! With several ranks, each sums and fits for its own particles, and rank 0 gets the results. Only
//! tables of all particles need them all on rank 0, as one rank has them.

use bevy_ecs::world::World;
use glam::{DMat3, DVec3};

use super::Simulation;
use super::ranks::Command;
use crate::particle_state::ParticleState;
use crate::particle_table::ParticleTable;
use crate::resources::entity_index::EntityIndex;
use crate::resources::pair::Pair;
use crate::resources::state_location::StateLocation;
use crate::systems::monitor::MonitorRow;
use sphecs_core::particles::sample::Sample;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::grid_rows::{NodeRow, RowSink};
use sphecs_core::pass::section::Section;
use sphecs_core::pass::surface_flow::{Friction, SurfaceFlow, SurfacePoint};
use sphecs_scene::model::ProbeSight;

/// Preparations for reading the present state, which readings of one time share.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Readiness {
    /// The arrays have the density at the present positions.
    has_density: bool,
    /// They are sorted, with the sums of that density beside them.
    is_sorted: bool,
    /// Rank 0 has the particles of all ranks.
    is_whole: bool,
}

impl Simulation {
    /// Returns the world with up-to-date components, density and pressure at the present positions
    /// included; of several ranks, particles have no components.
    pub fn world(&mut self) -> &World {
        self.update_components();
        &self.world
    }

    /// Returns the world with up-to-date components; the next step starts from the components that
    /// the caller leaves in it, if the particles have any.
    pub fn world_mut(&mut self) -> &mut World {
        self.update_components();
        if self.has_components() {
            self.readiness = Readiness::default();
            self.world.insert_resource(StateLocation::Components);
        }
        &mut self.world
    }

    fn update_components(&mut self) {
        if !self.world.resource::<EntityIndex>().has_entities() {
            return;
        }
        self.find_all_densities();
        if self.scene.scheme.has_stress() {
            // The stress is beside the arrays.
            self.sort();
        }
        (self.functions.scatter)(&mut self.world);
    }

    /// Returns the state of all particles in the order of their numbers, as [`Self::world`] has it
    /// for single ones.
    pub fn particles(&mut self) -> ParticleTable {
        self.find_all_densities();
        (self.functions.table)(&self.world)
    }

    /// Passes the state of each particle to a function, with the density at the present positions,
    /// in any order; for rank 0.
    pub fn for_each_particle(&mut self, take: &mut dyn FnMut(&ParticleState)) {
        self.sort();
        self.connection.announce(Command::Particles);
        (self.functions.visit)(&mut self.world, take);
    }

    /// Passes zone and position (m) of each particle to a function, in any order, without finding
    /// the densities; for rank 0.
    pub fn for_each_position(&mut self, take: &mut dyn FnMut(Zone, DVec3)) {
        if self.connection.is_shared() {
            self.begin_reading();
        } else {
            (self.functions.gather)(&mut self.world);
        }
        self.connection.announce(Command::Particles);
        (self.functions.visit)(&mut self.world, &mut |particle| take(particle.zone, particle.position));
    }

    /// Returns true if the particles have components: in a simulation on one rank that was not
    /// built [without](super::SimulationBuilder::without_components) them.
    pub fn has_components(&self) -> bool {
        self.world.resource::<EntityIndex>().has_entities()
    }

    /// Gives rank 0 all particles with the densities at their present positions.
    fn find_all_densities(&mut self) {
        if !self.readiness.has_density {
            self.sort();
        }
        self.collect();
    }

    /// Sorts the particles of each rank and sums their densities at the present positions.
    fn sort(&mut self) {
        if !self.readiness.is_sorted {
            self.connection.announce(Command::Sort);
            self.own_sort();
            self.readiness = Readiness { has_density: true, is_sorted: true, ..self.readiness };
        }
    }

    /// Sorts the particles on this rank.
    pub(super) fn own_sort(&mut self) {
        (self.functions.refresh)(&mut self.world);
    }

    /// Sorts the particles of the ranks unless they were ever sorted, which makes their domains.
    pub(super) fn begin_reading(&mut self) {
        if self.world.resource::<Pair>().0.ranks.changes() == 0 {
            self.sort();
        }
    }

    /// Gives rank 0 the particles of all ranks, unless it has them already.
    pub(super) fn collect(&mut self) {
        if self.connection.is_shared() && !self.readiness.is_whole {
            self.begin_reading();
            self.connection.announce(Command::Collect);
            (self.functions.collect)(&mut self.world);
            self.readiness = Readiness { is_sorted: false, is_whole: true, ..self.readiness };
        }
    }

    /// Returns the integral quantities at the present time; the mass flows are means since the
    /// previous call.
    pub fn monitor_row(&mut self) -> MonitorRow {
        self.sort();
        self.connection.announce(Command::MonitorRow);
        (self.functions.monitor_row)(&mut self.world)
    }

    /// Returns velocity (m/s), pressure (Pa) and density (kg/m³) of the fluid at points, m, by
    /// corrected kernel sums; None at a point without fluid nearby.
    pub fn sample(&mut self, points: &[DVec3]) -> Vec<Option<Sample>> {
        let fluid: Vec<_> = points.iter().map(|&point| (point, ProbeSight::Fluid)).collect();
        self.sample_seeing(&fluid)
    }

    /// Samples as [`Self::sample`] does, with a choice of the particles that count at each point.
    pub fn sample_seeing(&mut self, points: &[(DVec3, ProbeSight)]) -> Vec<Option<Sample>> {
        if self.request(Command::Sample, points.iter().flat_map(probe_numbers)) {
            (self.functions.sample)(&self.world, points)
        } else {
            Vec::new()
        }
    }

    /// Returns the pressure of [`Self::sample_seeing`], Pa, for less work than all fields.
    pub fn sample_pressure(&mut self, points: &[(DVec3, ProbeSight)]) -> Vec<Option<f64>> {
        if self.request(Command::Pressure, points.iter().flat_map(probe_numbers)) {
            (self.functions.pressure)(&self.world, points)
        } else {
            Vec::new()
        }
    }

    /// Samples the fields of the fluid at the nodes of a grid, in parallel, and passes those of
    /// each row to its sink; with `tagged`, the passive scalar too.
    ///
    /// # Panics
    /// If there are not as many sinks as rows.
    pub fn sample_rows(&mut self, rows: &[NodeRow], sinks: &mut [&mut dyn RowSink], tagged: bool) {
        if self.connection.is_shared() {
            let mut numbers = vec![f64::from(u8::from(tagged))];
            rows.iter().for_each(|row| row.write(&mut numbers));
            self.request(Command::Rows, numbers.into_iter());
        } else {
            self.sort();
        }
        (self.functions.sample_rows)(&self.world, rows, sinks, tagged);
    }

    /// Returns pressure and shear stress at points of the walls; None at a point without fluid
    /// nearby.
    pub fn sample_surface(&mut self, points: &[SurfacePoint]) -> Vec<Option<SurfaceFlow>> {
        if self.request(Command::Surface, points.iter().flat_map(surface_numbers)) {
            (self.functions.sample_surface)(&self.world, points, self.scene.fluid.viscosity)
        } else {
            Vec::new()
        }
    }

    /// Returns the mass flow through sections along their normals, kg/s (per metre of depth in 2D).
    ///
    /// It includes the displacement by shifting if the scene has a section among its probes.
    /// Otherwise `Wcsph` does not store that displacement, and the flow is that of the velocities.
    pub fn mass_flows(&mut self, sections: &[&Section]) -> Vec<f64> {
        let mut numbers = Vec::new();
        sections.iter().for_each(|section| section.write(&mut numbers));
        if self.request(Command::MassFlows, numbers.into_iter()) {
            (self.functions.mass_flows)(&self.world, sections)
        } else {
            Vec::new()
        }
    }

    /// Sorts the particles and tells the other ranks what is read next, with numbers that name it;
    /// returns false without any, when there is nothing to read.
    fn request(&mut self, command: Command, numbers: impl Iterator<Item = f64>) -> bool {
        let mut numbers = numbers.peekable();
        if numbers.peek().is_none() {
            return false;
        }
        self.sort();
        if self.connection.is_shared() {
            self.connection.announce(command);
            self.connection.tell(&numbers.collect::<Vec<f64>>());
        }
        true
    }

    /// Reads what rank 0 asks of this rank.
    pub(super) fn answer(&mut self, command: Command) {
        match command {
            Command::MonitorRow => drop((self.functions.monitor_row)(&mut self.world)),
            Command::Sample => drop((self.functions.sample)(&self.world, &probes(&self.connection.hear()))),
            Command::Pressure => {
                drop((self.functions.pressure)(&self.world, &probes(&self.connection.hear())))
            }
            Command::Surface => {
                let points = surface_points(&self.connection.hear());
                (self.functions.sample_surface)(&self.world, &points, self.scene.fluid.viscosity);
            }
            Command::MassFlows => {
                let sections = Section::read_all(&self.connection.hear());
                (self.functions.mass_flows)(&self.world, &sections.iter().collect::<Vec<_>>());
            }
            Command::Rows => {
                let numbers = self.connection.hear();
                let (tagged, rows) =
                    numbers.split_first().map_or((false, &[][..]), |(&tagged, rows)| (tagged != 0.0, rows));
                (self.functions.sample_rows)(&self.world, &NodeRow::read_all(rows), &mut [], tagged);
            }
            Command::End | Command::Step | Command::Traffic | Command::Sort => {}
            Command::Collect | Command::Particles | Command::State => {}
        }
    }
}

/// Returns the numbers of a point of a probe in a message.
fn probe_numbers(&(point, sight): &(DVec3, ProbeSight)) -> [f64; 4] {
    let sight = match sight {
        ProbeSight::Fluid => 0.0,
        ProbeSight::Flow => 1.0,
    };
    [point.x, point.y, point.z, sight]
}

/// Returns the points of probes in a message.
fn probes(numbers: &[f64]) -> Vec<(DVec3, ProbeSight)> {
    let probe = |&[x, y, z, sight]: &[f64; 4]| {
        (DVec3::new(x, y, z), if sight == 0.0 { ProbeSight::Fluid } else { ProbeSight::Flow })
    };
    numbers.as_chunks::<4>().0.iter().map(probe).collect()
}

/// Numbers of a point of a wall in a message.
const SURFACE_NUMBERS: usize = 19;

/// Returns the numbers of a point of a wall in a message.
fn surface_numbers(point: &SurfacePoint) -> [f64; SURFACE_NUMBERS] {
    let SurfacePoint { position, normal, velocity, gradient, friction } = *point;
    let friction = match friction {
        Friction::FreeSlip => 0.0,
        Friction::NoSlip => 1.0,
        Friction::WallFunction => 2.0,
    };
    let mut numbers = [friction; SURFACE_NUMBERS];
    let vectors = [position, velocity, normal, gradient.x_axis, gradient.y_axis, gradient.z_axis];
    for (to, vector) in numbers.chunks_exact_mut(3).zip(vectors) {
        to.copy_from_slice(&vector.to_array());
    }
    numbers
}

/// Returns the points of walls in a message.
fn surface_points(numbers: &[f64]) -> Vec<SurfacePoint> {
    let point = |numbers: &[f64; SURFACE_NUMBERS]| {
        let vector = |at: usize| DVec3::from_slice(&numbers[3 * at..]);
        SurfacePoint {
            position: vector(0),
            velocity: vector(1),
            normal: vector(2),
            gradient: DMat3::from_cols(vector(3), vector(4), vector(5)),
            friction: match numbers[SURFACE_NUMBERS - 1] {
                0.0 => Friction::FreeSlip,
                1.0 => Friction::NoSlip,
                _ => Friction::WallFunction,
            },
        }
    };
    numbers.as_chunks::<SURFACE_NUMBERS>().0.iter().map(point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_are_read_as_they_were_written() {
        let sights = [(DVec3::X, ProbeSight::Flow), (DVec3::NEG_Y, ProbeSight::Fluid)];
        assert_eq!(probes(&sights.map(|probe| probe_numbers(&probe)).concat()), sights);
        let point = SurfacePoint {
            position: DVec3::new(1.0, 2.0, 3.0),
            normal: DVec3::Y,
            velocity: DVec3::new(4.0, 5.0, 6.0),
            gradient: DMat3::from_cols(DVec3::X, DVec3::splat(7.0), DVec3::Z),
            friction: Friction::NoSlip,
        };
        let wall = SurfacePoint { friction: Friction::WallFunction, ..point };
        let slip = SurfacePoint { friction: Friction::FreeSlip, ..point };
        let points = [point, wall, slip];
        assert_eq!(surface_points(&points.map(|point| surface_numbers(&point)).concat()), points);
    }
}
