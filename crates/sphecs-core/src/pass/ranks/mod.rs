//! Ranks: processes, or threads with a pool of their own, that run the same flow and share its pair
//! passes.
//!
//! Every rank holds all particles. A pass sums for the rows of its own cells on each rank, and all
//! ranks send each other the columns that they found: the atom decomposition of Plimpton (1995),
//! section 3. What is not a pass, such as the kick or the change of zones, every rank does for all
//! particles.
//!
//! The sums of a particle depend on the pack of its cell alone, and the summary of a pass on no
//! order, so every rank is bitwise identical to one rank alone. The cells of a rank follow each
//! other, and so do its rows. Their number follows the time that each rank needed (`balance.rs`).
//!
//! Limits: the memory is that of all particles on every rank, and a message goes from each rank to
//! all others after every pass.

mod balance;
mod shared_columns;
#[cfg(test)]
mod tests;

pub(super) use shared_columns::{OutputNumber, SharedColumns};

use std::fmt;
use std::ops::Range;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use super::blocks::for_each_block;
use crate::math::grid::CellGrid;
use balance::Balance;
use shared_columns::MessageRows;

/// Connection between the ranks of a flow.
pub trait Transport: fmt::Debug + Send + Sync {
    /// Returns the number of this rank, from 0.
    fn rank(&self) -> usize;

    /// Returns the number of ranks.
    fn size(&self) -> usize;

    /// Sends a message to all ranks, and puts the messages of all, this rank included, behind each
    /// other in the order of the ranks.
    ///
    /// All ranks call it together. `lengths` are the bytes of each rank's message, the same on all
    /// ranks.
    ///
    /// # Panics
    /// If another rank has ended.
    fn all_gather(&self, own: &[u8], lengths: &[usize], all: &mut Vec<u8>);

    /// Tells the other ranks that this one ends before its time, so that they do not wait for it.
    fn abandon(&self);
}

/// Ranks that share the pair passes; the default is one rank alone.
#[derive(Clone, Debug, Default)]
pub struct Ranks(Option<Arc<Group>>);

#[derive(Debug)]
struct Group {
    transport: Box<dyn Transport>,
    state: Mutex<State>,
}

/// Buffers and counters of a rank.
#[derive(Debug)]
struct State {
    balance: Balance,
    /// First cell of each rank, followed by the number of cells.
    cells: Vec<usize>,
    lengths: Vec<usize>,
    own: Vec<u8>,
    all: Vec<u8>,
    traffic: Traffic,
}

/// Messages of a rank to the others, and the time that they took.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Traffic {
    /// Messages sent to each other rank.
    pub messages: u64,
    /// Bytes sent to each other rank.
    pub sent: u64,
    /// Bytes received from all other ranks.
    pub received: u64,
    /// Wall-clock time of own sums, s.
    pub busy: f64,
    /// Wall-clock time of messages, waiting for other ranks included, s.
    pub exchanging: f64,
}

/// Result of a pass besides its columns, which the ranks join.
pub(super) trait Joined: bytemuck::Pod + Default + Send {}

impl<S: bytemuck::Pod + Default + Send> Joined for S {}

impl Ranks {
    /// Returns the ranks of a connection; one rank alone if it connects no others.
    pub fn new(transport: impl Transport + 'static) -> Self {
        let size = transport.size();
        if size < 2 {
            return Self::default();
        }
        let state = State {
            balance: Balance::even(size),
            cells: Vec::new(),
            lengths: Vec::new(),
            own: Vec::new(),
            all: Vec::new(),
            traffic: Traffic::default(),
        };
        Self(Some(Arc::new(Group { transport: Box::new(transport), state: Mutex::new(state) })))
    }

    /// Returns the number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.0.as_ref().map_or(0, |group| group.transport.rank())
    }

    /// Returns the number of ranks.
    pub fn size(&self) -> usize {
        self.0.as_ref().map_or(1, |group| group.transport.size())
    }

    /// Returns what this rank has sent so far.
    pub fn traffic(&self) -> Traffic {
        self.0.as_ref().map_or(Traffic::default(), |group| group.state().traffic)
    }

    /// Sends bytes of rank 0 to all ranks and returns them; `length` is their number on all ranks.
    ///
    /// All ranks call it together; the bytes of the other ranks do not matter.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn from_first(&self, bytes: &[u8], length: usize) -> Vec<u8> {
        let Some(group) = &self.0 else { return bytes.to_vec() };
        let mut lengths = vec![0; group.transport.size()];
        lengths[0] = length;
        let own = if group.transport.rank() == 0 { bytes } else { &[] };
        let mut all = Vec::new();
        group.transport.all_gather(own, &lengths, &mut all);
        let traffic = &mut group.state().traffic;
        traffic.messages += 1;
        traffic.sent += own.len() as u64;
        traffic.received += (all.len() - own.len()) as u64;
        all
    }

    /// Tells the other ranks that this one ends before its time.
    pub fn abandon(&self) {
        if let Some(group) = &self.0 {
            group.transport.abandon();
        }
    }

    /// Begins a step: the cells of each rank stay the same until the next one.
    pub fn begin_step(&self) {
        if let Some(group) = &self.0 {
            group.state().balance.begin_step();
        }
    }

    /// Runs `work` over the cells in blocks, in parallel, and joins the results; each rank runs it
    /// over its own cells, and all have all rows in the end.
    ///
    /// `work` takes the cells of a block and the rows of the output columns that belong to them.
    /// The result must not depend on the order of the joins.
    pub(super) fn for_each_block<C: SharedColumns, S: Joined, const D: usize>(
        &self,
        grid: &CellGrid<D>,
        columns: C,
        work: &(impl Fn(Range<usize>, &mut C) -> S + Sync),
        join: &(impl Fn(S, S) -> S + Sync),
    ) -> S {
        match &self.0 {
            None => {
                let work = |cells: Range<usize>, mut columns: C| work(cells, &mut columns);
                for_each_block(grid.starts(), 0..grid.len(), columns, &work, join)
            }
            Some(group) => group.for_each_block(grid.starts(), columns, work, join),
        }
    }
}

/// Bytes of the busy time at the end of a message.
const BUSY: usize = size_of::<f64>();

impl Group {
    fn state(&self) -> MutexGuard<'_, State> {
        // A panic of a pass ends the run; the counters stay valid.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn for_each_block<C: SharedColumns, S: Joined>(
        &self,
        starts: &[u32],
        columns: C,
        work: &(impl Fn(Range<usize>, &mut C) -> S + Sync),
        join: &(impl Fn(S, S) -> S + Sync),
    ) -> S {
        let state = &mut *self.state();
        let State { balance, cells, lengths, own, all, traffic } = state;
        let rank = self.transport.rank();
        let width = columns.width();
        let tail = size_of::<S>() + BUSY;
        balance.cells(starts, cells);
        let rows = |rank: usize| starts[cells[rank]] as usize..starts[cells[rank + 1]] as usize;
        lengths.clear();
        lengths.extend((0..self.transport.size()).map(|rank| rows(rank).len() * width + tail));

        let started = Instant::now();
        own.resize(lengths[rank], 0);
        let (own_rows, own_tail) = own.split_at_mut(lengths[rank] - tail);
        let (before, rest) = columns.cut(rows(rank).start);
        let (mine, after) = rest.cut(rows(rank).len());
        let message = MessageRows { bytes: own_rows, width };
        let own_cells = cells[rank]..cells[rank + 1];
        let mut found = S::default();
        if !own_cells.is_empty() {
            let work = |cells: Range<usize>, (mut columns, message): (C, MessageRows<'_>)| {
                let found = work(cells, &mut columns);
                columns.write(message.bytes);
                found
            };
            found = for_each_block(starts, own_cells, (mine, message), &work, join);
        }
        let busy = started.elapsed().as_secs_f64();
        own_tail[..size_of::<S>()].copy_from_slice(bytemuck::bytes_of(&found));
        own_tail[size_of::<S>()..].copy_from_slice(bytemuck::bytes_of(&busy));

        let started = Instant::now();
        self.transport.all_gather(own, lengths, all);
        let mut joined: Option<S> = None;
        let mut rest = &mut all[..];
        let (mut before, mut after) = (before, after);
        for other in 0..lengths.len() {
            let (message, next) = rest.split_at_mut(lengths[other]);
            rest = next;
            let (bytes, end) = message.split_at_mut(lengths[other] - tail);
            let found: S = bytemuck::pod_read_unaligned(&end[..size_of::<S>()]);
            joined = Some(joined.map_or(found, |joined| join(joined, found)));
            balance.add(other, bytemuck::pod_read_unaligned(&end[size_of::<S>()..]));
            let their_cells = cells[other]..cells[other + 1];
            if other == rank || width == 0 || their_cells.is_empty() {
                continue;
            }
            let side = if other < rank { &mut before } else { &mut after };
            let (theirs, others) = std::mem::replace(side, C::none()).cut(rows(other).len());
            *side = others;
            // In the blocks in which the other rank has written them.
            let read = |_: Range<usize>, (mut columns, message): (C, MessageRows<'_>)| {
                columns.read(message.bytes);
            };
            let message = MessageRows { bytes, width };
            for_each_block(starts, their_cells, (theirs, message), &read, &|(), ()| ());
        }
        traffic.messages += 1;
        traffic.sent += own.len() as u64;
        traffic.received += (all.len() - own.len()) as u64;
        traffic.busy += busy;
        traffic.exchanging += started.elapsed().as_secs_f64();
        joined.unwrap_or_default()
    }
}
