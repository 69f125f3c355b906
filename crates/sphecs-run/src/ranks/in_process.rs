//! Ranks that are threads of this process.

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};

use rayon::ThreadPoolBuildError;

use crate::threads::Threads;
use sphecs_core::pass::ranks::{Ranks, Transport};
use sphecs_engine::simulation::Simulation;

/// Ranks other than 0 of a run in this process; dropping them waits until they have ended.
#[derive(Debug, Default)]
pub struct Followers {
    _pools: Vec<Threads>,
}

impl Followers {
    /// Starts ranks in this process, each with a pool of `threads`, that follow a simulation from
    /// its present state on; `ranks` counts that of the simulation too.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn start(
        simulation: &mut Simulation,
        ranks: usize,
        threads: usize,
    ) -> Result<Self, ThreadPoolBuildError> {
        if ranks < 2 {
            return Ok(Self::default());
        }
        let others = 1..ranks;
        let pools = others.map(|_| Threads::start(Some(threads))).collect::<Result<Vec<_>, _>>()?;
        let table = Arc::new(Table::new(ranks));
        let rank_of = |rank| Ranks::new(InProcess { rank, table: Arc::clone(&table) });
        let state = simulation.state();
        for (rank, pool) in (1..).zip(&pools) {
            let (scene, state, ranks) = (simulation.scene().clone(), state.clone(), rank_of(rank));
            pool.begin(move || {
                let built = Simulation::builder(scene).state(state).build();
                // The state is that of a simulation of the same scene, which has no plugins.
                built.expect("a simulation from the state of another").follow(ranks);
            });
        }
        simulation.lead(rank_of(0));
        Ok(Self { _pools: pools })
    }
}

/// Place where the ranks of a process leave their messages for each other.
#[derive(Debug)]
struct Table {
    messages: Vec<Mutex<Vec<u8>>>,
    meeting: Mutex<Meeting>,
    changed: Condvar,
}

/// Ranks that wait for the others.
#[derive(Debug, Default)]
struct Meeting {
    arrived: usize,
    /// Number of meetings that were complete.
    round: u64,
    /// True once a rank has ended before its time.
    is_abandoned: bool,
}

impl Table {
    fn new(ranks: usize) -> Self {
        Self {
            messages: (0..ranks).map(|_| Mutex::default()).collect(),
            meeting: Mutex::default(),
            changed: Condvar::new(),
        }
    }

    fn meeting(&self) -> MutexGuard<'_, Meeting> {
        // The counters stay valid when a rank panics.
        self.meeting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Waits until all ranks are here.
    ///
    /// # Panics
    /// If a rank has ended before its time.
    fn meet(&self) {
        let mut meeting = self.meeting();
        meeting.arrived += 1;
        if meeting.arrived == self.messages.len() {
            meeting.arrived = 0;
            meeting.round += 1;
            self.changed.notify_all();
        } else {
            let round = meeting.round;
            while meeting.round == round && !meeting.is_abandoned {
                meeting = self.changed.wait(meeting).unwrap_or_else(PoisonError::into_inner);
            }
        }
        let is_abandoned = meeting.is_abandoned;
        drop(meeting);
        assert!(!is_abandoned, "another rank has ended before its time");
    }
}

/// Place of a rank at the table.
#[derive(Debug)]
struct InProcess {
    rank: usize,
    table: Arc<Table>,
}

impl Transport for InProcess {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.table.messages.len()
    }

    fn all_gather(&self, own: &[u8], lengths: &[usize], all: &mut Vec<u8>) {
        let message = |rank: usize| self.table.messages[rank].lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut mine = message(self.rank);
            mine.clear();
            mine.extend_from_slice(own);
        }
        self.table.meet();
        all.clear();
        for (rank, &length) in lengths.iter().enumerate() {
            let theirs = message(rank);
            assert_eq!(theirs.len(), length, "rank {rank} is in another pass");
            all.extend_from_slice(&theirs);
        }
        // Nobody writes the next message before all have read this one.
        self.table.meet();
    }

    fn abandon(&self) {
        self.table.meeting().is_abandoned = true;
        self.table.changed.notify_all();
    }
}

#[cfg(test)]
mod tests {
    use std::panic::{AssertUnwindSafe, catch_unwind};

    use super::*;

    #[test]
    fn messages_arrive_in_the_order_of_the_ranks() {
        let table = Arc::new(Table::new(3));
        std::thread::scope(|scope| {
            for rank in 0..3 {
                let place = InProcess { rank, table: Arc::clone(&table) };
                scope.spawn(move || {
                    let mut all = Vec::new();
                    for round in 0..100_u8 {
                        let own = vec![round + rank as u8; rank + 1];
                        place.all_gather(&own, &[1, 2, 3], &mut all);
                        let expected = [0, 1, 1, 2, 2, 2].map(|rank| round + rank);
                        assert_eq!(all, expected, "rank {rank}");
                    }
                });
            }
        });
    }

    #[test]
    fn ranks_do_not_wait_for_one_that_has_ended() {
        let table = Arc::new(Table::new(2));
        let waiting = InProcess { rank: 0, table: Arc::clone(&table) };
        let ended = InProcess { rank: 1, table };
        let waits = std::thread::spawn(move || {
            let wait = || waiting.all_gather(&[1], &[1, 0], &mut Vec::new());
            catch_unwind(AssertUnwindSafe(wait)).is_err()
        });
        ended.abandon();
        assert!(waits.join().expect("no further panic"));
    }
}
