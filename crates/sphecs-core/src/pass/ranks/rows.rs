//! Particles that enter and leave what a rank holds.
//!
//! Every rank advances all particles that it holds, in the same way. So after a step it lacks only
//! those that entered its cells from cells that it does not hold, and their owners send them.

use std::ops::Range;
use std::sync::atomic::Ordering;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::bisection::bisect;
use super::domains::{Domains, RankSet};
use super::regions::Region;
use super::{Group, Ranks, State};
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::record;
use crate::particles::rows::ParticleRow;
use crate::particles::zone::Zone;

/// Message of a rank to all others before a sort.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct Header {
    /// Time of own work since the last sort, s.
    busy: f64,
    /// 1 if a particle is outside the grid.
    is_outside: u64,
}

/// Rows that a thread checks at a time.
const CHUNK: usize = 8192;

impl Ranks {
    /// Takes the particles that enter what this rank holds, so that the next sort by the grid
    /// finds all of them; the sort drops those that leave it.
    ///
    /// The `regions` never change. Returns false if a particle is outside the grid; then rank 0 has
    /// the particles of all.
    ///
    /// All ranks call it together, with arrays in the order of the last sort.
    ///
    /// # Panics
    /// If another rank has ended.
    pub fn move_rows<R: Real, const D: usize>(
        &self,
        grid: &mut CellGrid<D>,
        arrays: &mut ParticleArrays<R, D>,
        regions: &[Region],
    ) -> bool {
        let Some(group) = &self.group else { return true };
        let state = &mut *group.state();
        if state.domains.is_none() {
            group.make_domains(state, grid, regions);
        } else {
            let before = state.is_change_due.then(|| group.change_domains(state, grid, regions));
            state.is_change_due = false;
            if !group.send_newcomers(state, before.flatten().as_ref(), grid, arrays) {
                return false;
            }
        }
        let (exist, thin) = (&group.has_walls, &group.has_thin_walls);
        arrays.use_wall_columns(exist.load(Ordering::Relaxed), thin.load(Ordering::Relaxed));
        let rank = group.transport.rank();
        state.is_whole = state.is_observed;
        let holds_all = rank == 0 && state.is_observed;
        grid.hold(state.domains.as_ref().filter(|_| !holds_all).map(|domains| domains.held.clone()));
        true
    }

    /// Counts the rows after the sort of a step.
    pub fn count_rows<const D: usize>(&self, grid: &CellGrid<D>) {
        let Some(group) = &self.group else { return };
        let state = &mut *group.state();
        // Rank 0 holds more than its domain needs when it reads the flow.
        let Some(domains) = state.domains.as_ref().filter(|_| !state.is_whole) else { return };
        let rows = |cells: &Range<usize>| grid.rows_of_run(cells).len() as u64;
        state.traffic.own_rows = domains.owned[group.transport.rank()].iter().map(rows).sum();
        state.traffic.held_rows = rows(&(0..grid.len()));
    }
}

impl Group {
    /// Makes the first domains from the division of the flow.
    fn make_domains<const D: usize>(&self, state: &mut State, grid: &CellGrid<D>, regions: &[Region]) {
        let (rank, ranks) = (self.transport.rank(), self.transport.size());
        let owner = std::mem::take(&mut state.first_owners);
        assert_eq!(owner.len(), grid.len(), "a flow is divided before its first step");
        state.domains = Some(Domains::new(grid, owner, (rank, ranks), regions));
        state.changes += 1;
    }

    /// Makes new domains by the times of the ranks and returns the old ones.
    fn change_domains<const D: usize>(
        &self,
        state: &mut State,
        grid: &CellGrid<D>,
        regions: &[Region],
    ) -> Option<Domains> {
        let domains = state.domains.take()?;
        let (rank, ranks) = (self.transport.rank(), self.transport.size());
        let cells_of = |rank: usize| domains.owned[rank].iter().flat_map(Clone::clone);
        let count = |cell: usize| grid.rows(cell).len() as u32;
        let own: Vec<u8> = cells_of(rank).flat_map(|cell| count(cell).to_ne_bytes()).collect();
        let lengths: Vec<usize> = (0..ranks).map(|rank| cells_of(rank).count() * size_of::<u32>()).collect();
        let mut all = Vec::new();
        self.transport.all_gather(&own, &lengths, &mut all);
        state.traffic.count(own.len(), all.len() - own.len());
        let mut counts = all
            .chunks_exact(size_of::<u32>())
            .map(|bytes| f64::from(bytemuck::pod_read_unaligned::<u32>(bytes)));
        let mut rows = vec![0.0; ranks];
        let mut of_cell = vec![(0.0, 0); grid.len()];
        for rank in 0..ranks {
            for (cell, count) in cells_of(rank).zip(&mut counts) {
                of_cell[cell] = (count, rank);
                rows[rank] += count;
            }
        }
        let cost_of_row = state.balance.take_costs(&rows);
        let costs: Vec<f64> = of_cell.into_iter().map(|(rows, rank)| rows * cost_of_row[rank]).collect();
        let owner = bisect(grid, &costs, ranks);
        state.domains = Some(Domains::new(grid, owner, (rank, ranks), regions));
        state.changes += 1;
        Some(domains)
    }

    /// Sends the own particles that enter what another rank holds, and appends those of others to
    /// the arrays. `before` are the domains of the last sort if they have changed.
    ///
    /// Returns false if a particle is outside the grid; then rank 0 has the particles of all.
    fn send_newcomers<R: Real, const D: usize>(
        &self,
        state: &mut State,
        before: Option<&Domains>,
        grid: &mut CellGrid<D>,
        arrays: &mut ParticleArrays<R, D>,
    ) -> bool {
        let (rank, ranks) = (self.transport.rank(), self.transport.size());
        let State { domains: Some(now), messages, is_whole, .. } = &mut *state else { return true };
        messages.outgoing.iter_mut().for_each(Vec::clear);
        let mut send = |row: usize, other: usize| {
            if other != rank && (other != 0 || !*is_whole) {
                record::write(&arrays.row(row), DVec3::ZERO, &mut messages.outgoing[other]);
            }
        };
        let rows = |cell: usize| {
            let moving = grid.rows(cell).filter(|&row| arrays.zone[row] != Zone::Reservoir);
            moving.filter_map(|row| Some((row, cell_of(grid, arrays, row)?)))
        };
        let (mut holders, mut new_holders) = (RankSet::new(ranks), RankSet::new(ranks));
        match before {
            None => {
                for cell in now.bordering.iter().flat_map(Clone::clone) {
                    for (row, entered) in rows(cell).filter(|(_, entered)| *entered != cell) {
                        if let Some(others) = now.new_holders(cell, entered) {
                            others.for_each(|other| send(row, other));
                            continue;
                        }
                        // It moved farther than the support.
                        now.find_holders(grid, cell, &mut holders);
                        now.find_holders(grid, entered, &mut new_holders);
                        let others = new_holders.ranks().filter(|&other| !holders.has(other));
                        others.for_each(|other| send(row, other));
                    }
                }
            }
            Some(old) => {
                for cell in old.owned[rank].iter().flat_map(Clone::clone) {
                    old.find_holders(grid, cell, &mut holders);
                    let mut last = None;
                    for (row, entered) in rows(cell) {
                        if last.replace(entered) != Some(entered) {
                            now.find_holders(grid, entered, &mut new_holders);
                        }
                        let others = new_holders.ranks().filter(|&other| !holders.has(other));
                        others.for_each(|other| send(row, other));
                    }
                }
            }
        }
        let header = Header {
            busy: std::mem::take(&mut state.busy),
            is_outside: u64::from(!are_inside(grid, arrays)),
        };
        self.gather(state, bytemuck::bytes_of(&header));
        let mut is_outside = false;
        for (other, header) in state.messages.gathered.chunks_exact(size_of::<Header>()).enumerate() {
            let header: Header = bytemuck::pod_read_unaligned(header);
            state.balance.add(other, header.busy);
            is_outside |= header.is_outside != 0;
        }
        if is_outside {
            self.assemble(state, grid, arrays);
            return false;
        }
        let lengths: Vec<u64> = state.messages.outgoing.iter().map(|message| message.len() as u64).collect();
        let lengths = self.exchange_numbers(state, &lengths);
        for (message, length) in state.messages.incoming.iter_mut().zip(lengths) {
            message.resize(length as usize, 0);
        }
        self.exchange(state);
        for message in &state.messages.incoming {
            let newcomers: Vec<ParticleRow> =
                message.chunks_exact(record::BYTES).map(|message| record::read(message).0).collect();
            arrays.extend(&newcomers);
        }
        true
    }
}

pub(super) fn cell_of<R: Real, const D: usize>(
    grid: &CellGrid<D>,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> Option<usize> {
    grid.cell_of(std::array::from_fn(|axis| arrays.position[axis][row]))
}

/// Returns true if all particles that are not bound for the reservoir are inside the grid.
fn are_inside<R: Real, const D: usize>(grid: &CellGrid<D>, arrays: &ParticleArrays<R, D>) -> bool {
    let (lower, upper) = (grid.lower(), grid.upper());
    (0..arrays.len().div_ceil(CHUNK)).into_par_iter().with_max_len(1).all(|chunk| {
        let rows = chunk * CHUNK..arrays.len().min((chunk + 1) * CHUNK);
        // Without branches, so that the compiler vectorises the loop; a NaN fails it.
        let is_inside = (0..D).all(|axis| {
            let column = arrays.position[axis][rows.clone()].iter();
            column.fold(true, |all, x| all & (*x >= lower[axis]) & (*x < upper[axis]))
        });
        is_inside
            || rows
                .clone()
                .all(|row| arrays.zone[row] == Zone::Reservoir || cell_of(grid, arrays, row).is_some())
    })
}
