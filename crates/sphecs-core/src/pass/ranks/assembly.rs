//! All particles together on rank 0, for frames and checkpoints.
//!
//! The other ranks first send how many particles each of their cells has, from which rank 0 finds
//! the row of every particle. The particles follow in batches, so that rank 0 needs little memory
//! besides the columns.

use std::ops::Range;
use std::sync::atomic::Ordering;

use super::domains::Domains;
use super::{Group, Ranks, State};
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::record;
use crate::particles::rows::set_real_vector;

/// Particles that a rank sends at once: their records take 13 MB.
const BATCH: usize = 65_536;

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
        if let Some(group) = &self.0 {
            group.assemble(&mut group.state(), grid, arrays);
        }
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
        if state.is_whole {
            return;
        }
        let Some(domains) = state.domains.take() else { return };
        if self.transport.rank() == 0 {
            self.receive_rows(state, &domains, grid, arrays);
        } else {
            self.send_rows(state, &domains, grid, arrays);
        }
        state.domains = Some(domains);
        state.is_whole = true;
        // The buffers for these messages are larger than those of any pass.
        state.messages.outgoing.iter_mut().for_each(|message| *message = Vec::new());
        state.messages.incoming.iter_mut().for_each(|message| *message = Vec::new());
    }

    /// Sends the numbers of own particles in each cell, then the particles.
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
        let counts = cells.iter().flat_map(Clone::clone).map(|cell| grid.rows(cell).len() as u32);
        state.messages.outgoing[0].extend(counts.flat_map(u32::to_ne_bytes));
        self.exchange(state);
        let mut rows = rows_of(grid, cells);
        for _ in 0..self.batches(state, rows_in(grid, cells)) {
            let message = &mut state.messages.outgoing[0];
            message.clear();
            for row in rows.by_ref().take(BATCH) {
                record::write(&arrays.row(row), arrays.acceleration_of(row), message);
            }
            self.exchange(state);
        }
    }

    /// Puts the particles of all ranks into the arrays.
    fn receive_rows<R: Real, const D: usize>(
        &self,
        state: &mut State,
        domains: &Domains,
        grid: &mut CellGrid<D>,
        arrays: &mut ParticleArrays<R, D>,
    ) {
        let own: Vec<usize> = rows_of(grid, &domains.owned[0]).collect();
        let sorted = grid.starts().last().map_or(0, |&end| end as usize);
        grid.set_starts(self.receive_starts(state, domains, grid));
        let total = grid.starts().last().map_or(0, |&end| end as usize);
        let all = ParticleArrays {
            evolves_pressure: arrays.evolves_pressure,
            drifts: arrays.drifts,
            ..ParticleArrays::default()
        };
        let before = std::mem::replace(arrays, all);
        arrays.reserve(total + before.len() - sorted);
        arrays.resize(total);
        arrays.use_wall_columns(
            self.has_walls.load(Ordering::Relaxed),
            self.has_thin_walls.load(Ordering::Relaxed),
        );
        for (row, from) in rows_of(grid, &domains.owned[0]).zip(own) {
            arrays.set(row, &before.row(from));
            set_real_vector(&mut arrays.acceleration, row, before.acceleration_of(from));
        }
        for row in sorted..before.len() {
            arrays.push(&before.row(row));
        }
        drop(before);
        let mut rest: Vec<usize> = domains.owned.iter().map(|cells| rows_in(grid, cells)).collect();
        rest[0] = 0;
        let mut rows: Vec<_> = domains.owned.iter().map(|cells| rows_of(grid, cells)).collect();
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
                    arrays.set(row, &particle);
                    set_real_vector(&mut arrays.acceleration, row, acceleration);
                }
            }
        }
        grid.hold(None);
    }

    /// Returns the first row of each cell once rank 0 has the particles of all.
    fn receive_starts<const D: usize>(
        &self,
        state: &mut State,
        domains: &Domains,
        grid: &CellGrid<D>,
    ) -> Vec<u32> {
        state.messages.outgoing.iter_mut().for_each(Vec::clear);
        for (message, cells) in state.messages.incoming.iter_mut().zip(&domains.owned) {
            let count: usize = cells.iter().map(ExactSizeIterator::len).sum();
            message.resize(count * size_of::<u32>(), 0);
        }
        state.messages.incoming[0].clear();
        self.exchange(state);
        // Entry `cell + 1` gets the number of particles in the cell, and then the running sum of
        // the numbers, which is where the next cell starts.
        let mut starts = vec![0; grid.len() + 1];
        for cell in domains.owned[0].iter().flat_map(Clone::clone) {
            starts[cell + 1] = grid.rows(cell).len() as u32;
        }
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
    }

    /// Returns the number of batches in which the rank with most particles sends its own.
    fn batches(&self, state: &mut State, own: usize) -> u64 {
        self.joined(state, own.div_ceil(BATCH) as u64, u64::max)
    }
}

/// Returns the rows of cells.
fn rows_of<const D: usize>(
    grid: &CellGrid<D>,
    cells: &[Range<usize>],
) -> impl Iterator<Item = usize> + use<D> {
    let runs: Vec<Range<usize>> = cells.iter().map(|run| grid.rows_of_run(run)).collect();
    runs.into_iter().flatten()
}

/// Returns the number of particles in cells.
fn rows_in<const D: usize>(grid: &CellGrid<D>, cells: &[Range<usize>]) -> usize {
    cells.iter().map(|run| grid.rows_of_run(run).len()).sum()
}
