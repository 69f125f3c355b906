//! All particles together on rank 0: for checkpoints and tables of particles as columns, for frames
//! one after the other.
//!
//! The other ranks first send how many particles each of their cells has, from which rank 0 finds
//! the row of every particle. The particles follow in batches, so that rank 0 needs little memory
//! besides what it makes of them.

use std::ops::Range;
use std::sync::atomic::Ordering;

use glam::DVec3;

use super::domains::Domains;
use super::{Group, Ranks, State};
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::record;
use crate::particles::rows::{ParticleRow, set_real_vector};

/// Particles that a rank sends at once: their records take 13 MB.
const BATCH: usize = 65_536;

/// Takes a particle with its acceleration (m/s²) and its row in the order in which one rank alone
/// would have all particles.
type Take<'a> = dyn FnMut(usize, &ParticleRow, DVec3) + 'a;

impl Ranks {
    /// Gives rank 0 the particles of all, in the order in which one rank alone would have them;
    /// it keeps them until the next step.
    ///
    /// All ranks call it together.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn assemble<R: Real, const D: usize>(
        &self,
        grid: &mut CellGrid<D>,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        if let Some(group) = &self.group {
            group.assemble(&mut group.state(), grid, arrays);
        }
    }

    /// Passes the particles of all ranks to `take` on rank 0, in any order, a batch of each rank at
    /// a time.
    ///
    /// All ranks call it together, after their first sort.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn for_each_row<R: Real, const D: usize>(
        &self,
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
        take: &mut dyn FnMut(&ParticleRow),
    ) {
        match &self.group {
            Some(group) => {
                let state = &mut *group.state();
                let starts = group.starts_of_all(state, grid);
                group.visit(state, (grid, arrays), &starts, &mut |_, particle, _| take(particle));
            }
            None => (0..arrays.len()).for_each(|row| take(&arrays.row(row))),
        }
    }

    /// Returns the particles of all ranks on rank 0, in the order in which one rank alone would
    /// have them, without accelerations; None on the others.
    ///
    /// All ranks call it together, after their first sort.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn all_rows<R: Real, const D: usize>(
        &self,
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
    ) -> Option<ParticleArrays<R, D>> {
        let Some(group) = &self.group else { return Some(arrays.clone()) };
        let state = &mut *group.state();
        let starts = group.starts_of_all(state, grid);
        let mut all = None;
        if group.transport.rank() == 0 {
            let all = all.insert(arrays.of_same_columns(number(&starts) + added(grid, arrays).len()));
            group.use_wall_columns(all);
        }
        group.visit(state, (grid, arrays), &starts, &mut |row, particle, _| {
            if let Some(all) = &mut all {
                all.set(row, particle);
            }
        });
        all
    }
}

impl Group {
    /// Gives rank 0 the particles of all in the order of the cells of the last sort, followed by
    /// those added since, which all ranks have.
    pub(super) fn assemble<R: Real, const D: usize>(
        &self,
        state: &mut State,
        grid: &mut CellGrid<D>,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        state.is_observed = true;
        if state.is_whole || state.domains.is_none() {
            return;
        }
        let starts = self.starts_of_all(state, grid);
        if self.transport.rank() == 0 {
            let total = number(&starts) + added(grid, arrays).len();
            let all = arrays.of_same_columns(total);
            let before = std::mem::replace(arrays, all);
            arrays.resize(total);
            self.use_wall_columns(arrays);
            self.visit(state, (grid, &before), &starts, &mut |row, particle, acceleration| {
                arrays.set(row, particle);
                set_real_vector(&mut arrays.acceleration, row, acceleration);
            });
            grid.set_starts(starts);
            grid.hold(None);
        } else {
            self.visit(state, (grid, arrays), &starts, &mut |_, _, _| {});
        }
        state.is_whole = true;
    }

    fn use_wall_columns<R: Real, const D: usize>(&self, arrays: &mut ParticleArrays<R, D>) {
        arrays.use_wall_columns(
            self.has_walls.load(Ordering::Relaxed),
            self.has_thin_walls.load(Ordering::Relaxed),
        );
    }

    /// Passes the particles of all ranks to `take` on rank 0, with the first row of each cell.
    fn visit<R: Real, const D: usize>(
        &self,
        state: &mut State,
        (grid, arrays): (&CellGrid<D>, &ParticleArrays<R, D>),
        starts: &[u32],
        take: &mut Take<'_>,
    ) {
        let rank = self.transport.rank();
        let mut take_own = |row: usize, from: usize| {
            if rank == 0 {
                take(row, &arrays.row(from), arrays.acceleration_of(from));
            }
        };
        let added = added(grid, arrays).enumerate();
        added.for_each(|(at, from)| take_own(number(starts) + at, from));
        let Some(domains) = state.domains.take_if(|_| !state.is_whole) else {
            (0..number(starts)).for_each(|row| take_own(row, row));
            return;
        };
        if rank == 0 {
            let own = &domains.owned[0];
            rows_of(starts, own).zip(rows_of(grid.starts(), own)).for_each(|(row, from)| take_own(row, from));
            self.receive_rows(state, &domains, starts, take);
        } else {
            self.send_rows(state, &domains, grid, arrays);
        }
        state.domains = Some(domains);
        // The buffers for these messages are larger than those of any pass.
        state.messages.outgoing.iter_mut().for_each(|message| *message = Vec::new());
        state.messages.incoming.iter_mut().for_each(|message| *message = Vec::new());
    }

    /// Sends the own particles.
    fn send_rows<R: Real, const D: usize>(
        &self,
        state: &mut State,
        domains: &Domains,
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
    ) {
        let cells = &domains.owned[self.transport.rank()];
        state.messages.incoming.iter_mut().for_each(Vec::clear);
        state.messages.outgoing.iter_mut().for_each(Vec::clear);
        let mut rows = rows_of(grid.starts(), cells);
        for _ in 0..self.batches(state, rows_in(grid.starts(), cells)) {
            let message = &mut state.messages.outgoing[0];
            message.clear();
            for row in rows.by_ref().take(BATCH) {
                record::write(&arrays.row(row), arrays.acceleration_of(row), message);
            }
            self.exchange(state);
        }
    }

    /// Passes the particles of the other ranks to `take`.
    fn receive_rows(&self, state: &mut State, domains: &Domains, starts: &[u32], take: &mut Take<'_>) {
        let mut rest: Vec<usize> = domains.owned.iter().map(|cells| rows_in(starts, cells)).collect();
        rest[0] = 0;
        let mut rows: Vec<_> = domains.owned.iter().map(|cells| rows_of(starts, cells)).collect();
        state.messages.outgoing.iter_mut().for_each(Vec::clear);
        for _ in 0..self.batches(state, 0) {
            for (message, rest) in state.messages.incoming.iter_mut().zip(&mut rest) {
                let count = BATCH.min(*rest);
                message.resize(count * record::BYTES, 0);
                *rest -= count;
            }
            self.exchange(state);
            for (message, rows) in state.messages.incoming.iter().zip(&mut rows) {
                for (record, row) in message.chunks_exact(record::BYTES).zip(rows) {
                    let (particle, acceleration) = record::read(record);
                    take(row, &particle, acceleration);
                }
            }
        }
    }

    /// Returns the first row of each cell on rank 0, once it has the particles of all; on the
    /// others that of their own arrays.
    fn starts_of_all<const D: usize>(&self, state: &mut State, grid: &CellGrid<D>) -> Vec<u32> {
        let Some(domains) = state.domains.take_if(|_| !state.is_whole) else {
            return grid.starts().to_vec();
        };
        let rank = self.transport.rank();
        state.messages.incoming.iter_mut().for_each(Vec::clear);
        state.messages.outgoing.iter_mut().for_each(Vec::clear);
        let own = domains.owned[rank].iter().flat_map(Clone::clone);
        let starts = if rank == 0 {
            for (message, cells) in state.messages.incoming.iter_mut().zip(&domains.owned).skip(1) {
                let count: usize = cells.iter().map(ExactSizeIterator::len).sum();
                message.resize(count * size_of::<u32>(), 0);
            }
            self.exchange(state);
            // Entry `cell + 1` gets the number of particles in the cell, and then the running sum
            // of the numbers, which is where the next cell starts.
            let mut starts = vec![0; grid.len() + 1];
            own.for_each(|cell| starts[cell + 1] = grid.rows(cell).len() as u32);
            for (message, cells) in state.messages.incoming.iter().zip(&domains.owned) {
                let counts = message.chunks_exact(size_of::<u32>());
                for (cell, count) in cells.iter().flat_map(Clone::clone).zip(counts) {
                    starts[cell + 1] = bytemuck::pod_read_unaligned(count);
                }
            }
            let mut first = 0;
            for start in &mut starts {
                first += *start;
                *start = first;
            }
            starts
        } else {
            let counts = own.map(|cell| grid.rows(cell).len() as u32);
            state.messages.outgoing[0].extend(counts.flat_map(u32::to_ne_bytes));
            self.exchange(state);
            grid.starts().to_vec()
        };
        state.domains = Some(domains);
        starts
    }

    /// Returns the number of batches in which the rank with most particles sends its own.
    fn batches(&self, state: &mut State, own: usize) -> u64 {
        self.joined(state, own.div_ceil(BATCH) as u64, u64::max)
    }
}

/// Returns the number of rows of all cells, from the first row of each.
fn number(starts: &[u32]) -> usize {
    starts.last().map_or(0, |&end| end as usize)
}

/// Returns the rows that were added since the last sort.
fn added<R: Real, const D: usize>(grid: &CellGrid<D>, arrays: &ParticleArrays<R, D>) -> Range<usize> {
    number(grid.starts())..arrays.len()
}

/// Returns the rows of cells, from the first row of each.
fn rows_of(starts: &[u32], cells: &[Range<usize>]) -> impl Iterator<Item = usize> + use<> {
    let run = |run: &Range<usize>| starts[run.start] as usize..starts[run.end] as usize;
    let runs: Vec<Range<usize>> = cells.iter().map(run).collect();
    runs.into_iter().flatten()
}

/// Returns the number of particles in cells, from the first row of each.
fn rows_in(starts: &[u32], cells: &[Range<usize>]) -> usize {
    cells.iter().map(|run| (starts[run.end] - starts[run.start]) as usize).sum()
}
