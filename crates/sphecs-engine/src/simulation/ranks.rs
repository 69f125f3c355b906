//! Ranks of a simulation: rank 0 leads, and the others follow it step by step.
//!
//! Each rank holds the particles of its domain (`sphecs_core::pass::ranks`), without components.
//! Rank 0 announces what all do together: a step, or that it reads fields or particles or saves the
//! state. The reading itself changes nothing that later steps depend on.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::resource::Resource;
use bevy_ecs::world::World;

use super::Simulation;
use super::readings::Readiness;
use crate::arrays::Arrays;
use crate::resources::grid::{Grid, SortBuffers};
use crate::resources::pair::Pair;
use crate::resources::pair_sums::Sums;
use crate::resources::scene::ActiveScene;
use crate::saved_state::{SavedResources, part};
use crate::spawn::despawn_particles;
use crate::systems::body_forces::Bodies;
use crate::systems::boundaries::opening_regions::OpeningRegions;
use crate::systems::boundaries::outlets::Outlets;
use sphecs_core::math::column::Columns;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_core::pass::ranks::division::Division;
use sphecs_core::pass::ranks::regions::Region;
use sphecs_core::pass::ranks::shares::{Share, shares};
use sphecs_core::pass::ranks::{Ranks, Traffic};

/// Announcement of rank 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// The simulation has ended.
    End,
    /// All ranks take a step.
    Step,
    /// All ranks tell what they have sent.
    Traffic,
    /// Rank 0 gets the particles of all and keeps them.
    Collect,
    /// Rank 0 reads the particles of all, one after the other.
    Particles,
    /// Rank 0 saves the state.
    State,
    /// All ranks sort their particles and sum the densities at the present positions.
    Sort,
    /// All ranks sum for a row of the monitor.
    MonitorRow,
    /// All ranks find the fields at points that follow.
    Sample,
    /// All ranks find the pressure at points that follow.
    Pressure,
    /// All ranks find the flow at points of walls that follow.
    Surface,
    /// All ranks sum the mass flows through sections that follow.
    MassFlows,
    /// All ranks find the fields at the nodes of grids that follow.
    Rows,
}

impl Command {
    const ALL: [Self; 13] = [
        Self::End,
        Self::Step,
        Self::Traffic,
        Self::Collect,
        Self::Particles,
        Self::State,
        Self::Sort,
        Self::MonitorRow,
        Self::Sample,
        Self::Pressure,
        Self::Surface,
        Self::MassFlows,
        Self::Rows,
    ];
}

/// Connection of a rank to the others; its end is announced to them.
#[derive(Debug, Default)]
pub(super) struct Connection(Ranks);

impl Connection {
    /// Announces what rank 0 does next.
    pub(super) fn announce(&self, command: Command) {
        if self.is_shared() {
            self.0.from_first(&[command as u8], 1);
        }
    }

    /// Returns true if there are other ranks.
    pub(super) fn is_shared(&self) -> bool {
        self.0.size() > 1
    }

    /// Tells the other ranks numbers.
    pub(super) fn tell(&self, numbers: &[f64]) {
        let bytes: Vec<u8> = numbers.iter().flat_map(|number| number.to_ne_bytes()).collect();
        self.0.from_first(&bytes.len().to_ne_bytes(), size_of::<usize>());
        self.0.from_first(&bytes, bytes.len());
    }

    /// Returns the numbers that rank 0 tells.
    pub(super) fn hear(&self) -> Vec<f64> {
        let length = self.0.from_first(&[], size_of::<usize>());
        let length = length.try_into().map_or(0, usize::from_ne_bytes);
        let bytes = self.0.from_first(&[], length);
        bytes.as_chunks().0.iter().map(|&number| f64::from_ne_bytes(number)).collect()
    }

    /// Returns what rank 0 does next.
    fn next(&self) -> Command {
        let heard = self.0.from_first(&[], 1);
        let command = heard.first().and_then(|&number| Command::ALL.get(usize::from(number)));
        command.copied().unwrap_or(Command::End)
    }
}

/// Division with which a rank begins, until it is connected.
#[derive(Resource, Debug)]
pub(super) struct FirstDivision(pub Division);

/// Returns the regions around the openings.
fn regions<R: PairReal<D>, const D: usize>(world: &mut World) -> Vec<Region> {
    let scene = world.resource::<ActiveScene>().0.clone();
    world.resource_scope(|world, mut openings: Mut<OpeningRegions>| {
        let needs = world.resource::<Outlets<R, D>>().needs();
        openings.regions(&scene, needs, &world.resource::<Grid<D>>().0).to_vec()
    })
}

/// Divides the particles of the arrays among a number of ranks.
pub(super) fn divide<R: PairReal<D>, const D: usize>(world: &World, ranks: usize) -> Division {
    Division::new(&world.resource::<Grid<D>>().0, &world.resource::<Arrays<R, D>>().0, ranks)
}

/// Saves the particles that a rank holds.
pub(super) fn save_part<R: PairReal<D>, const D: usize>(
    world: &mut World,
    division: &Division,
    rank: usize,
    to: &mut Columns,
) {
    let regions = regions::<R, D>(world);
    let (grid, arrays) = (&world.resource::<Grid<D>>().0, &world.resource::<Arrays<R, D>>().0);
    part::save::<R, D>(world, division.rows_of(rank, grid, arrays, &regions), to);
}

/// Drops the particles that rank 0 does not hold, and the buffers that were made for all.
pub(super) fn keep_part<R: PairReal<D>, const D: usize>(world: &mut World, division: &Division) {
    let regions = regions::<R, D>(world);
    let (grid, arrays) = (&world.resource::<Grid<D>>().0, &world.resource::<Arrays<R, D>>().0);
    let kept = arrays.of_rows(&division.rows_of(0, grid, arrays, &regions));
    let grid = grid.without_rows();
    world.insert_resource(Arrays(kept));
    world.insert_resource(Grid(grid));
    world.insert_resource(SortBuffers::<R>::default());
    world.insert_resource(Sums::<R, D>::default());
}

/// Returns the shares of a number of ranks in the particles of the arrays.
pub(super) fn shares_of<R: PairReal<D>, const D: usize>(world: &mut World, ranks: usize) -> Vec<Share> {
    let regions = regions::<R, D>(world);
    let arrays = world.resource::<Arrays<R, D>>();
    let place = |row: usize| std::array::from_fn(|axis| arrays.position[axis][row]);
    shares(&world.resource::<Grid<D>>().0, (0..arrays.len()).map(place), &regions, ranks)
}

impl Drop for Connection {
    fn drop(&mut self) {
        if std::thread::panicking() {
            self.0.abandon();
        } else if self.0.rank() == 0 {
            self.announce(Command::End);
        }
    }
}

impl Simulation {
    /// Divides the particles among a number of ranks, which begin with [parts](Self::part) of the
    /// state.
    ///
    pub fn divide(&mut self, ranks: usize) -> Division {
        (self.functions.gather)(&mut self.world);
        (self.functions.divide)(&self.world, ranks)
    }

    /// Returns the part of the state with which a rank begins.
    pub fn part(&mut self, division: &Division, rank: usize) -> Columns {
        let mut part = Columns::default();
        division.save(&mut part);
        (self.functions.part)(&mut self.world, division, rank, &mut part);
        SavedResources::save(&self.world, &mut part);
        part
    }

    /// Shares the pair passes with other ranks, which [follow](Self::follow) this one from their
    /// parts of its present state; for rank 0.
    ///
    /// Results are bitwise those of one rank. The particles have no components any more, and the
    /// simulation must have no plugins.
    pub fn lead(&mut self, ranks: Ranks, division: Division) {
        despawn_particles(&mut self.world);
        (self.functions.keep_part)(&mut self.world, &division);
        self.readiness = Readiness::default();
        self.connect(ranks, division);
    }

    /// Takes the steps of rank 0 until that simulation is dropped; for all other ranks.
    ///
    /// The simulation must have the scene and [a part](super::SimulationBuilder::part) of the state
    /// of that of rank 0.
    ///
    /// # Panics
    /// If it was not built from a part of a state.
    pub fn follow(mut self, ranks: Ranks) {
        let FirstDivision(division) =
            self.world.remove_resource().expect("a simulation from a part of a state");
        self.connect(ranks, division);
        loop {
            match self.connection.next() {
                Command::End => return,
                // Rank 0 finds the same reason to stop and announces the end.
                Command::Step => drop(self.own_step()),
                Command::Traffic => drop(self.connection.0.traffic()),
                Command::Collect => (self.functions.collect)(&mut self.world),
                Command::Particles => (self.functions.visit)(&mut self.world, &mut |_| ()),
                Command::State => (self.functions.save_all)(&mut self.world, &mut Columns::default()),
                Command::Sort => self.own_sort(),
                reading => self.answer(reading),
            }
        }
    }

    /// Returns the number of ranks that share the pair passes.
    pub fn ranks(&self) -> usize {
        self.connection.0.size()
    }

    /// Returns what each rank has sent so far; nothing for one rank alone.
    pub fn traffic(&self) -> Vec<Traffic> {
        self.connection.announce(Command::Traffic);
        self.connection.0.traffic()
    }

    /// Returns the particles that each of a number of ranks would own and hold at present; their
    /// domains change in the course of a run.
    pub fn shares(&mut self, ranks: usize) -> Vec<Share> {
        self.collect();
        (self.functions.gather)(&mut self.world);
        (self.functions.shares)(&mut self.world, ranks)
    }

    fn connect(&mut self, ranks: Ranks, division: Division) {
        ranks.divide(division);
        self.world.resource_mut::<Pair>().0.ranks = ranks.clone();
        self.world.resource_mut::<Bodies>().connect(ranks.clone());
        self.connection = Connection(ranks);
    }
}
