//! Ranks of a simulation: rank 0 leads, and the others follow it step by step.
//!
//! A step and a refresh of the densities run pair passes, which all ranks run together
//! (`sphecs_core::pass::ranks`). So rank 0 announces each of them. All else, such as reading fields
//! or saving the state, runs on rank 0 alone: it changes nothing that later steps depend on.

use super::Simulation;
use crate::resources::pair::Pair;
use sphecs_core::pass::ranks::{Ranks, Traffic};

/// Announcement of rank 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Command {
    /// The simulation has ended.
    End,
    /// All ranks take a step.
    Step,
    /// All ranks sum the densities at the present positions.
    Refresh,
}

impl Command {
    const ALL: [Self; 3] = [Self::End, Self::Step, Self::Refresh];
}

/// Connection of a rank to the others; its end is announced to them.
#[derive(Debug, Default)]
pub(super) struct Connection(Ranks);

impl Connection {
    /// Announces what rank 0 does next.
    pub(super) fn announce(&self, command: Command) {
        if self.0.size() > 1 {
            self.0.from_first(&[command as u8], 1);
        }
    }

    /// Returns what rank 0 does next.
    fn next(&self) -> Command {
        let heard = self.0.from_first(&[], 1);
        let command = heard.first().and_then(|&number| Command::ALL.get(usize::from(number)));
        command.copied().unwrap_or(Command::End)
    }
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
                Command::Refresh => (self.functions.refresh)(&mut self.world),
            }
        }
    }

    /// Returns the number of ranks that share the pair passes.
    pub fn ranks(&self) -> usize {
        self.connection.0.size()
    }

    /// Returns what this rank has sent to the others.
    pub fn traffic(&self) -> Traffic {
        self.connection.0.traffic()
    }

    fn connect(&mut self, ranks: Ranks) {
        self.world.resource_mut::<Pair>().0.ranks = ranks.clone();
        self.connection = Connection(ranks);
    }
}
