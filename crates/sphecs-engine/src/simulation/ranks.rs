//! Ranks of a simulation: rank 0 leads, and the others follow it step by step.
//!
//! Each rank holds the particles of its domain (`sphecs_core::pass::ranks`). Rank 0 announces what
//! all do together: a step, and before it reads fields or saves the state, that it gets the
//! particles of all. The reading itself changes nothing that later steps depend on.

use bevy_ecs::change_detection::Mut;
use bevy_ecs::world::World;

use super::Simulation;
use crate::arrays::Arrays;
use crate::resources::grid::Grid;
use crate::resources::pair::Pair;
use crate::resources::scene::ActiveScene;
use crate::systems::body_forces::Bodies;
use crate::systems::boundaries::outlets::Outlets;
use crate::systems::boundaries::patch_rows::PatchRows;
use sphecs_core::pass::pair_real::PairReal;
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
    /// Rank 0 gets the particles of all.
    Collect,
    /// Rank 0 gets the particles of all, with the densities at the present positions.
    Refresh,
}

impl Command {
    const ALL: [Self; 5] = [Self::End, Self::Step, Self::Traffic, Self::Collect, Self::Refresh];
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

    /// Returns what rank 0 does next.
    fn next(&self) -> Command {
        let heard = self.0.from_first(&[], 1);
        let command = heard.first().and_then(|&number| Command::ALL.get(usize::from(number)));
        command.copied().unwrap_or(Command::End)
    }
}

/// Returns the shares of a number of ranks in the particles of the arrays.
pub(super) fn shares_of<R: PairReal<D>, const D: usize>(world: &mut World, ranks: usize) -> Vec<Share> {
    let scene = world.resource::<ActiveScene>().0.clone();
    let everywhere = world.resource_scope(|world, mut rows: Mut<PatchRows>| {
        let needs = world.resource::<Outlets<R, D>>().needs();
        rows.everywhere(&scene, needs, &world.resource::<Grid<D>>().0).to_vec()
    });
    let arrays = world.resource::<Arrays<R, D>>();
    let place = |row: usize| std::array::from_fn(|axis| arrays.position[axis][row]);
    shares(&world.resource::<Grid<D>>().0, (0..arrays.len()).map(place), &everywhere, ranks)
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
    /// Shares the pair passes with other ranks, which [follow](Self::follow) this one; for rank 0.
    ///
    /// Results are bitwise those of one rank. The components that [`Self::world_mut`] returns must
    /// not be changed any more, and the simulation must have no plugins.
    pub fn lead(&mut self, ranks: Ranks) {
        self.connect(ranks);
    }

    /// Takes the steps of rank 0 until that simulation is dropped; for all other ranks.
    ///
    /// The simulation must have the scene and the state of that of rank 0.
    pub fn follow(mut self, ranks: Ranks) {
        self.connect(ranks);
        loop {
            match self.connection.next() {
                Command::End => return,
                // Rank 0 finds the same reason to stop and announces the end.
                Command::Step => drop(self.own_step()),
                Command::Traffic => drop(self.connection.0.traffic()),
                Command::Collect => (self.functions.collect)(&mut self.world),
                Command::Refresh => self.own_refresh(),
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

    fn connect(&mut self, ranks: Ranks) {
        self.world.resource_mut::<Pair>().0.ranks = ranks.clone();
        self.world.resource_mut::<Bodies>().connect(ranks.clone());
        self.connection = Connection(ranks);
    }
}
