//! Rows of nodes on several ranks: each rank samples the nodes in its own cells, and rank 0 gets
//! the fields of all.
//!
//! A rank holds all particles in reach of its nodes. The other nodes of a group may miss some, but
//! their fields are not used.

use std::ops::Range;

use super::{NodeFields, NodeRow, RowSampler};
use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::pass::ranks::OwnCells;

/// Nodes that are sent at a time.
const BATCH: usize = 1 << 16;

/// Numbers of a node in a message, of 64 bits each: its place in the batch and its fields.
const NUMBERS: usize = 1 + NodeFields::NUMBERS;

impl<R: Real, const D: usize> RowSampler<'_, R, D> {
    /// Samples all rows as [`Self::sample`] does, on several ranks.
    pub(super) fn sample_shared<S: Send>(
        &self,
        rows: &[NodeRow],
        sinks: &mut [S],
        take: impl Fn(&mut S, &[NodeFields]) + Sync,
    ) {
        let ranks = &self.pair.ranks;
        let (own, reference) = (ranks.own_cells(), self.reference());
        for batch in batches(rows, BATCH) {
            let rows = &rows[batch.clone()];
            let own_rows: Vec<NodeRow> = rows.iter().map(|row| row.of_cells(self.grid, &own)).collect();
            let mut nodes = 0;
            let mut messages: Vec<(usize, &NodeRow, Vec<u8>)> = Vec::with_capacity(rows.len());
            for row in &own_rows {
                messages.push((nodes, row, Vec::new()));
                nodes += row.wanted.len();
            }
            self.sample_all(&own_rows, &reference, &mut messages, |(first, row, message), fields| {
                for (node, fields) in fields.iter().enumerate().filter(|(node, _)| row.wanted[*node]) {
                    message.extend(((*first + node) as u64).to_ne_bytes());
                    message.extend(fields.numbers().into_iter().flat_map(f64::to_ne_bytes));
                }
            });
            let message = messages.iter().flat_map(|(.., message)| message).copied().collect();
            let found = ranks.to_first(message);
            if ranks.rank() > 0 {
                continue;
            }
            let mut all = vec![NodeFields::ABSENT; nodes];
            for node in found.iter().flat_map(|message| message.as_chunks::<8>().0.chunks_exact(NUMBERS)) {
                let numbers = std::array::from_fn(|number| f64::from_ne_bytes(node[1 + number]));
                all[u64::from_ne_bytes(node[0]) as usize] = NodeFields::of_numbers(numbers);
            }
            let mut rest = &all[..];
            for (row, sink) in rows.iter().zip(&mut sinks[batch]) {
                let (fields, after) = rest.split_at(row.wanted.len());
                rest = after;
                take(sink, fields);
            }
        }
    }
}

/// Divides rows into batches of at least as many nodes as given, except for the last.
fn batches(rows: &[NodeRow], least: usize) -> Vec<Range<usize>> {
    let mut batches = Vec::new();
    let (mut from, mut nodes) = (0, 0);
    for (index, row) in rows.iter().enumerate() {
        nodes += row.wanted.len();
        if nodes >= least || index + 1 == rows.len() {
            batches.push(from..index + 1);
            (from, nodes) = (index + 1, 0);
        }
    }
    batches
}

impl NodeRow {
    /// Returns the row with those of its nodes wanted that are in some cells.
    fn of_cells<const D: usize>(&self, grid: &CellGrid<D>, cells: &OwnCells) -> Self {
        let is_inside = |node: usize| {
            let point = self.start + node as f64 * self.step;
            cells.has(grid.nearest_cell(std::array::from_fn(|axis| point[axis])))
        };
        let wanted = self.wanted.iter().enumerate().map(|(node, &wanted)| wanted && is_inside(node));
        Self { start: self.start, step: self.step, wanted: wanted.collect() }
    }

    /// Appends the row to a message of numbers.
    pub fn write(&self, numbers: &mut Vec<f64>) {
        numbers.extend(self.start.to_array().into_iter().chain(self.step.to_array()));
        numbers.push(self.wanted.len() as f64);
        let word =
            |nodes: &[bool]| nodes.iter().rev().fold(0, |word: u32, &wanted| word << 1 | u32::from(wanted));
        numbers.extend(self.wanted.chunks(WORD).map(|nodes| f64::from(word(nodes))));
    }

    /// Returns the rows of a message of numbers.
    pub fn read_all(mut numbers: &[f64]) -> Vec<Self> {
        let mut rows = Vec::new();
        while let Some((&[a, b, c, d, e, f, count], rest)) = numbers.split_first_chunk::<7>() {
            let count = count as usize;
            let (words, rest) = rest.split_at(count.div_ceil(WORD));
            let is_wanted = |node: usize| words[node / WORD] as u32 >> (node % WORD) & 1 == 1;
            rows.push(Self {
                start: [a, b, c].into(),
                step: [d, e, f].into(),
                wanted: (0..count).map(is_wanted).collect(),
            });
            numbers = rest;
        }
        rows
    }
}

/// Nodes in a number of a message, one bit each.
const WORD: usize = u32::BITS as usize;

impl NodeFields {
    /// Numbers of the fields.
    const NUMBERS: usize = 10;

    fn numbers(&self) -> [f64; Self::NUMBERS] {
        let Self { velocity: [u, v, w], vorticity: [a, b, c], pressure, density, tag, fraction } = *self;
        [u, v, w, a, b, c, pressure, density, tag, fraction]
    }

    fn of_numbers([u, v, w, a, b, c, pressure, density, tag, fraction]: [f64; Self::NUMBERS]) -> Self {
        Self { velocity: [u, v, w], vorticity: [a, b, c], pressure, density, tag, fraction }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;

    fn row(count: usize, is_wanted: impl Fn(usize) -> bool) -> NodeRow {
        let wanted = (0..count).map(is_wanted).collect();
        NodeRow { start: DVec3::new(0.5, -2.0, count as f64), step: DVec3::new(0.1, 0.0, 0.3), wanted }
    }

    #[test]
    fn rows_are_read_as_they_were_written() {
        let rows =
            [row(0, |_| true), row(1, |_| true), row(32, |node| node > 7), row(71, |node| node % 3 == 0)];
        let mut numbers = Vec::new();
        rows.iter().for_each(|row| row.write(&mut numbers));
        assert_eq!(NodeRow::read_all(&numbers), rows);
    }

    #[test]
    fn batches_hold_all_rows_once() {
        let rows = [3, 3, 1, 9, 2].map(|count| row(count, |_| true));
        assert_eq!(batches(&rows, 5), [0..2, 2..4, 4..5]);
        assert_eq!(batches(&rows, 100).as_slice(), std::slice::from_ref(&(0..5)));
        assert!(batches(&[], 5).is_empty());
    }
}
