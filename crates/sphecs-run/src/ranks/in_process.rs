//! Ranks that are threads of this process.

use std::collections::VecDeque;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

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
        Self::start_changing(simulation, ranks, threads, None)
    }

    /// Starts ranks as [`Self::start`] does, whose domains change every few steps, `every`, even if
    /// the ranks are balanced.
    ///
    /// # Errors
    /// The system refuses a thread.
    pub fn start_changing(
        simulation: &mut Simulation,
        ranks: usize,
        threads: usize,
        every: Option<u32>,
    ) -> Result<Self, ThreadPoolBuildError> {
        if ranks < 2 {
            return Ok(Self::default());
        }
        let others = 1..ranks;
        let pools = others.map(|_| Threads::start(Some(threads))).collect::<Result<Vec<_>, _>>()?;
        let table = Arc::new(Table::new(ranks));
        let rank_of = |rank| Ranks::changing_domains(InProcess { rank, table: Arc::clone(&table) }, every);
        let division = simulation.divide(ranks);
        for (rank, pool) in (1..).zip(&pools) {
            let (scene, part) = (simulation.scene().clone(), simulation.part(&division, rank));
            let ranks = rank_of(rank);
            pool.begin(move || {
                let built = Simulation::builder(scene).part(part).build();
                // The state is that of a simulation of the same scene, which has no plugins.
                built.expect("a simulation from a part of another").follow(ranks);
            });
        }
        simulation.lead(rank_of(0), division);
        Ok(Self { _pools: pools })
    }
}

/// Time for which a rank looks for a message again and again before it sleeps: to be woken takes as
/// long.
const LOOKS_FOR: Duration = Duration::from_micros(100);

/// Place where the ranks of a process leave their messages for each other.
#[derive(Debug)]
struct Table {
    /// Messages of each rank for all, of this meeting and the one before.
    messages: Vec<[Mutex<Vec<u8>>; 2]>,
    meeting: Mutex<Meeting>,
    changed: Condvar,
    /// Number of meetings that were complete.
    round: AtomicU64,
    inboxes: Vec<Inbox>,
    /// True once a rank has ended before its time.
    is_abandoned: AtomicBool,
}

/// Returns true once something is the case, and false after some time in which it is not.
fn look_for(is_there: impl Fn() -> bool) -> bool {
    let started = Instant::now();
    loop {
        if is_there() {
            return true;
        }
        if started.elapsed() > LOOKS_FOR {
            return false;
        }
        // Other ranks may have to share the core.
        std::thread::yield_now();
    }
}

/// Messages for a rank.
#[derive(Debug)]
struct Inbox {
    /// Messages from each rank in the order in which they were sent.
    letters: Mutex<Vec<VecDeque<Vec<u8>>>>,
    arrived: Condvar,
}

/// Ranks that wait for the others.
#[derive(Debug, Default)]
struct Meeting {
    arrived: usize,
}

impl Table {
    fn new(ranks: usize) -> Self {
        Self {
            messages: (0..ranks).map(|_| Default::default()).collect(),
            meeting: Mutex::default(),
            changed: Condvar::new(),
            round: AtomicU64::new(0),
            inboxes: (0..ranks).map(|_| Inbox::new(ranks)).collect(),
            is_abandoned: AtomicBool::new(false),
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
        let round = self.round();
        meeting.arrived += 1;
        if meeting.arrived == self.messages.len() {
            meeting.arrived = 0;
            self.round.store(round + 1, Ordering::SeqCst);
            self.changed.notify_all();
        } else {
            drop(meeting);
            let is_over = || self.round() != round || self.is_abandoned();
            if !look_for(is_over) {
                meeting = self.meeting();
                while !is_over() {
                    meeting = self.changed.wait(meeting).unwrap_or_else(PoisonError::into_inner);
                }
            }
        }
        self.check();
    }

    fn round(&self) -> u64 {
        self.round.load(Ordering::SeqCst)
    }

    fn is_abandoned(&self) -> bool {
        self.is_abandoned.load(Ordering::SeqCst)
    }

    /// Ends this rank with another.
    ///
    /// # Panics
    /// If a rank has ended before its time.
    fn check(&self) {
        assert!(!self.is_abandoned(), "another rank has ended before its time");
    }

    /// Returns the next message of a rank for another one.
    ///
    /// # Panics
    /// If a rank has ended before its time.
    fn next_letter(&self, from: usize, to: usize) -> Vec<u8> {
        let inbox = &self.inboxes[to];
        look_for(|| !inbox.letters()[from].is_empty() || self.is_abandoned());
        let mut letters = inbox.letters();
        loop {
            if let Some(letter) = letters[from].pop_front() {
                return letter;
            }
            if self.is_abandoned() {
                drop(letters);
                self.check();
                return Vec::new();
            }
            letters = inbox.arrived.wait(letters).unwrap_or_else(PoisonError::into_inner);
        }
    }
}

impl Inbox {
    fn new(ranks: usize) -> Self {
        Self { letters: Mutex::new(vec![VecDeque::new(); ranks]), arrived: Condvar::new() }
    }

    fn letters(&self) -> MutexGuard<'_, Vec<VecDeque<Vec<u8>>>> {
        // The lists stay valid when a rank panics.
        self.letters.lock().unwrap_or_else(PoisonError::into_inner)
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
        // Nobody writes the next but one before all have read this one: they have met in between.
        let place = (self.table.round() % 2) as usize;
        let message =
            |rank: usize| self.table.messages[rank][place].lock().unwrap_or_else(PoisonError::into_inner);
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
    }

    fn exchange_during(&self, outgoing: &[Vec<u8>], incoming: &mut [Vec<u8>], work: &mut dyn FnMut()) {
        for (inbox, message) in self.table.inboxes.iter().zip(outgoing) {
            if !message.is_empty() {
                inbox.letters()[self.rank].push_back(message.clone());
                inbox.arrived.notify_all();
            }
        }
        work();
        for (other, message) in incoming.iter_mut().enumerate().filter(|(_, message)| !message.is_empty()) {
            let letter = self.table.next_letter(other, self.rank);
            assert_eq!(letter.len(), message.len(), "rank {other} is in another pass");
            *message = letter;
        }
    }

    fn abandon(&self) {
        self.table.is_abandoned.store(true, Ordering::SeqCst);
        // Under the locks, so that no rank is between its check and its wait.
        drop(self.table.meeting());
        self.table.changed.notify_all();
        for inbox in &self.table.inboxes {
            drop(inbox.letters());
            inbox.arrived.notify_all();
        }
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
    fn messages_arrive_at_single_ranks_in_their_order() {
        let table = Arc::new(Table::new(3));
        std::thread::scope(|scope| {
            for rank in 0..3_usize {
                let place = InProcess { rank, table: Arc::clone(&table) };
                scope.spawn(move || {
                    // To the next rank, whose number is in the message.
                    let (next, previous) = ((rank + 1) % 3, (rank + 2) % 3);
                    for round in 1..100 {
                        let mut outgoing = vec![Vec::new(); 3];
                        outgoing[next] = vec![(round * 2 + next) as u8; round];
                        let mut incoming = vec![Vec::new(); 3];
                        incoming[previous] = vec![0; round];
                        place.exchange(&outgoing, &mut incoming);
                        assert_eq!(incoming[previous], vec![(round * 2 + rank) as u8; round]);
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
            let gather = || waiting.all_gather(&[1], &[1, 0], &mut Vec::new());
            let receive = || waiting.exchange(&[vec![], vec![]], &mut [vec![], vec![0]]);
            catch_unwind(AssertUnwindSafe(gather)).is_err()
                && catch_unwind(AssertUnwindSafe(receive)).is_err()
        });
        ended.abandon();
        assert!(waits.join().expect("no further panic"));
    }
}
