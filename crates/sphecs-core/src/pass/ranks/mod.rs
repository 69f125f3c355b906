//! Ranks: processes, or threads with a pool of their own, that run the same flow together.
//!
//! Each rank owns a domain, a set of cells of the grid, and sums for the particles in it: the
//! spatial decomposition of Plimpton (1995), section 5. It holds the particles of the cells in
//! reach too, and whole [`regions`] around openings that it touches. After each pass the ranks send
//! each other what they found for the particles that another one holds, so all that a rank holds is
//! always as it would be on one rank alone. Between passes each rank advances all that it holds.
//! Places are sent only of the few particles that enter the cells that another rank holds (`rows`).
//!
//! The sums of a particle depend on the pack of its cell alone, and the summary of a pass on no
//! order, so every rank is bitwise identical to one rank alone.
//!
//! - `answers`: values that rank 0 alone has
//! - `assembly`: all particles together on rank 0
//! - `balance`: what the particles of a domain cost
//! - `bisection`: domains of equal cost
//! - [`division`]: what each rank begins with
//! - `domains`: the cells that each rank owns and holds
//! - `group_messages`: messages of a rank, and the time that they take
//! - [`regions`]: regions that a rank holds whole or not at all
//! - `rows`: the particles that enter and leave what a rank holds
//! - `shared_blocks`: passes of which each rank runs the blocks of its cells
//! - `shared_columns`: output columns in messages
//! - `shared_points`: results at points that all members of a region need
//! - [`shares`]: particles that each of a number of ranks would own and hold
//! - `traffic`: messages and times of a rank
//! - `transport`: what sends the messages

mod answers;
mod assembly;
mod balance;
mod bisection;
pub mod division;
mod domains;
mod group_messages;
pub mod regions;
mod rows;
mod shared_blocks;
mod shared_columns;
mod shared_points;
pub mod shares;
#[cfg(test)]
mod tests;
mod traffic;
mod transport;

pub(super) use shared_columns::{OutputNumber, SharedColumns};
pub(super) use shared_points::PointResult;
pub use traffic::Traffic;
pub use transport::Transport;

use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use crate::math::exact_sum::ExactSum;
use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::CellSet;
use balance::Balance;
use domains::Domains;

/// Ranks that run a flow together; the default is one rank alone.
#[derive(Clone, Debug, Default)]
pub struct Ranks {
    group: Option<Arc<Group>>,
    /// Region whose members share the work at points.
    region: Option<usize>,
}

#[derive(Debug)]
struct Group {
    transport: Box<dyn Transport>,
    /// True if there are walls anywhere.
    has_walls: AtomicBool,
    /// True if any wall is thin.
    has_thin_walls: AtomicBool,
    state: Mutex<State>,
}

/// Domains, buffers and counters of a rank.
#[derive(Debug)]
struct State {
    balance: Balance,
    /// Rank of each cell before the first sort.
    first_owners: Vec<u16>,
    /// Domains of the ranks; None before the first sort.
    domains: Option<Domains>,
    /// Number of times that the domains changed.
    changes: u64,
    /// True if the domains change before the next step.
    is_change_due: bool,
    /// True if rank 0 has the particles of all.
    is_whole: bool,
    /// True if rank 0 keeps the particles of all in the next sort.
    is_observed: bool,
    /// Time of own work in steps since the ranks told each other, s.
    busy: f64,
    /// Beginning of the present step, and the time of messages before it, s.
    step_began: Option<(Instant, f64)>,
    messages: Messages,
    traffic: Traffic,
}

/// Buffers for messages, kept from pass to pass.
#[derive(Debug, Default)]
struct Messages {
    outgoing: Vec<Vec<u8>>,
    incoming: Vec<Vec<u8>>,
    lengths: Vec<usize>,
    gathered: Vec<u8>,
}

/// Cells that a rank owns.
#[derive(Clone, Debug, Default)]
pub struct OwnCells(Option<Arc<CellSet>>);

impl OwnCells {
    /// Returns true if the rank owns a cell.
    #[inline]
    pub fn has(&self, cell: usize) -> bool {
        self.0.as_ref().is_none_or(|own| own.contains(cell))
    }

    /// Returns true if the rank owns a row of arrays that are sorted by a grid; those added since
    /// belong to none.
    pub fn has_row<const D: usize>(&self, grid: &CellGrid<D>, row: usize) -> bool {
        let Some(own) = &self.0 else { return true };
        let cells = grid.starts().partition_point(|&start| start as usize <= row);
        cells <= grid.len() && own.contains(cells - 1)
    }
}

impl Ranks {
    /// Returns the ranks of a connection; one rank alone if it connects no others.
    pub fn new(transport: impl Transport + 'static) -> Self {
        Self::changing_domains(transport, None)
    }

    /// Returns the ranks of a connection whose domains change every few steps, `every`, even if the
    /// ranks are balanced, as tests need it.
    pub fn changing_domains(transport: impl Transport + 'static, every: Option<u32>) -> Self {
        let size = transport.size();
        if size < 2 {
            return Self::default();
        }
        let buffers = || (0..size).map(|_| Vec::new()).collect::<Vec<Vec<u8>>>();
        let state = State {
            balance: Balance::new(size, every),
            first_owners: Vec::new(),
            domains: None,
            changes: 0,
            is_change_due: false,
            is_whole: true,
            is_observed: false,
            busy: 0.0,
            step_began: None,
            messages: Messages { outgoing: buffers(), incoming: buffers(), ..Messages::default() },
            traffic: Traffic::default(),
        };
        let group = Group {
            transport: Box::new(transport),
            has_walls: AtomicBool::new(false),
            has_thin_walls: AtomicBool::new(false),
            state: Mutex::new(state),
        };
        Self { group: Some(Arc::new(group)), region: None }
    }

    /// Returns the number of this rank, from 0.
    pub fn rank(&self) -> usize {
        self.group.as_ref().map_or(0, |group| group.transport.rank())
    }

    /// Returns the number of ranks.
    pub fn size(&self) -> usize {
        self.group.as_ref().map_or(1, |group| group.transport.size())
    }

    /// Returns what each rank has sent so far, in the order of the ranks; nothing for one rank
    /// alone.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn traffic(&self) -> Vec<Traffic> {
        let Some(group) = &self.group else { return Vec::new() };
        let state = &mut *group.state();
        let own = state.traffic;
        group.gather(state, bytemuck::bytes_of(&own));
        state.messages.gathered.chunks_exact(size_of::<Traffic>()).map(bytemuck::pod_read_unaligned).collect()
    }

    /// Returns true if another rank has walls, whether this one has any or not.
    pub(super) fn have_walls(&self) -> bool {
        self.group.as_ref().is_some_and(|group| group.has_walls.load(Ordering::Relaxed))
    }

    /// Returns true if another rank has thin walls, whether this one has any or not.
    pub(super) fn have_thin_walls(&self) -> bool {
        self.group.as_ref().is_some_and(|group| group.has_thin_walls.load(Ordering::Relaxed))
    }

    /// Returns the cells of this rank; all for one rank alone.
    pub fn own_cells(&self) -> OwnCells {
        OwnCells(self.group.as_ref().and_then(|group| Some(Arc::clone(&group.state().domains.as_ref()?.own))))
    }

    /// Returns the number of times that the cells of this rank changed.
    pub fn changes(&self) -> u64 {
        self.group.as_ref().map_or(0, |group| group.state().changes)
    }

    /// Sends bytes of rank 0 to all ranks and returns them; `length` is their number on all ranks.
    ///
    /// All ranks call it together; the bytes of the other ranks do not matter.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn from_first(&self, bytes: &[u8], length: usize) -> Vec<u8> {
        let Some(group) = &self.group else { return bytes.to_vec() };
        let mut lengths = vec![0; group.transport.size()];
        lengths[0] = length;
        let own = if group.transport.rank() == 0 { bytes } else { &[] };
        let mut all = Vec::new();
        group.transport.all_gather(own, &lengths, &mut all);
        group.state().traffic.count(own.len(), all.len() - own.len());
        all
    }

    /// Returns the values of all ranks behind each other in their order; all ranks have as many.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn values_of_all<T: bytemuck::Pod>(&self, own: &[T]) -> Vec<T> {
        let Some(group) = &self.group else { return own.to_vec() };
        let state = &mut *group.state();
        group.gather(state, bytemuck::cast_slice(own));
        let values = state.messages.gathered.chunks_exact(size_of::<T>().max(1));
        values.map(bytemuck::pod_read_unaligned).collect()
    }

    /// Returns the messages of all ranks behind each other in their order; `lengths` are the bytes
    /// of each, the same on all ranks.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn messages_of_all(&self, own: &[u8], lengths: &[usize]) -> Vec<u8> {
        let Some(group) = &self.group else { return own.to_vec() };
        let state = &mut *group.state();
        state.messages.lengths.clear();
        state.messages.lengths.extend_from_slice(lengths);
        group.gather_lengths(state, own);
        state.messages.gathered.clone()
    }

    /// Returns true if this rank has the particles of all since the last sort.
    pub fn has_all(&self) -> bool {
        self.group.as_ref().is_none_or(|group| group.transport.rank() == 0 && group.state().is_whole)
    }

    /// Joins a value of each rank in the order of the ranks; the result is that of all ranks.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn joined<T: bytemuck::Pod>(&self, own: T, join: impl Fn(T, T) -> T) -> T {
        let Some(group) = &self.group else { return own };
        group.joined(&mut group.state(), own, join)
    }

    /// Adds up exact sums of all ranks, each in its place; all ranks have as many.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn sum_exactly(&self, sums: &mut [ExactSum]) {
        let Some(group) = self.group.as_ref().filter(|_| !sums.is_empty()) else { return };
        let state = &mut *group.state();
        let mut own = vec![0; sums.len() * ExactSum::BYTES];
        for (sum, message) in sums.iter().zip(own.chunks_exact_mut(ExactSum::BYTES)) {
            sum.write(message);
        }
        group.gather(state, &own);
        let others = state.messages.gathered.chunks_exact(own.len());
        for (_, message) in others.enumerate().filter(|(rank, _)| *rank != group.transport.rank()) {
            for (sum, other) in sums.iter_mut().zip(message.chunks_exact(ExactSum::BYTES)) {
                *sum += &ExactSum::read(other);
            }
        }
    }

    /// Gives rank 0 a message of each rank, in the order of the ranks; the others get none.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn to_first(&self, own: Vec<u8>) -> Vec<Vec<u8>> {
        let Some(group) = &self.group else { return vec![own] };
        let state = &mut *group.state();
        let is_first = group.transport.rank() == 0;
        let mut length = vec![0; group.transport.size()];
        length[0] = own.len() as u64;
        let lengths = group.exchange_numbers(state, &length);
        state.messages.outgoing.iter_mut().for_each(Vec::clear);
        for (message, length) in state.messages.incoming.iter_mut().zip(lengths) {
            message.resize(length as usize, 0);
        }
        if !is_first {
            state.messages.outgoing[0] = own;
            group.exchange(state);
            return Vec::new();
        }
        group.exchange(state);
        let mut all: Vec<Vec<u8>> = state.messages.incoming.iter_mut().map(std::mem::take).collect();
        all[0] = own;
        all
    }

    /// Returns the rows of this rank in arrays that are sorted by a grid: those of its cells; all
    /// for one rank alone.
    pub fn own_rows<const D: usize>(&self, grid: &CellGrid<D>) -> Vec<Range<usize>> {
        let rows = |cells: &Range<usize>| grid.rows_of_run(cells);
        let own = self.group.as_ref().and_then(|group| {
            let state = group.state();
            Some(state.domains.as_ref()?.owned[group.transport.rank()].iter().map(rows).collect())
        });
        own.unwrap_or_else(|| vec![rows(&(0..grid.len()))])
    }

    /// Tells the other ranks that this one ends before its time.
    pub fn abandon(&self) {
        if let Some(group) = &self.group {
            group.transport.abandon();
        }
    }

    /// Begins a step: rank 0 need not keep the particles of all any more.
    pub fn begin_step(&self) {
        if let Some(group) = &self.group {
            let state = &mut *group.state();
            state.is_observed = false;
            state.is_change_due = state.balance.begin_step();
            state.step_began = Some((Instant::now(), state.traffic.exchanging));
        }
    }

    /// Ends a step: what this rank did in it counts for the balance, but not the time that it
    /// waited.
    pub fn end_step(&self) {
        if let Some(group) = &self.group {
            let state = &mut *group.state();
            if let Some((began, exchanging)) = state.step_began.take() {
                let busy = began.elapsed().as_secs_f64() - (state.traffic.exchanging - exchanging);
                state.busy += busy;
                state.traffic.busy += busy;
            }
        }
    }
}

impl Group {
    fn state(&self) -> MutexGuard<'_, State> {
        // A panic of a pass ends the run; the counters stay valid.
        self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }
}
