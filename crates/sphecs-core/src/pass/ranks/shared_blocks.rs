//! Passes of which each rank runs the blocks of its own cells.
//!
//! The blocks of the cells that others hold come first, and their results are under way while the
//! other blocks are run. So a rank waits for the first part of the pass of its neighbours only.

use std::ops::Range;

use super::domains::{Domains, Kind, Run};
use super::shared_columns::SharedColumns;
use super::{Group, Ranks, State};
use crate::math::grid::CellGrid;
use crate::pass::blocks::{blocks_of, for_each_block};

impl Ranks {
    /// Runs `work` over the cells in blocks, in parallel, and joins the results; each rank runs it
    /// over its own cells, and has the rows of all cells that it holds in the end.
    ///
    /// `work` takes the cells of a block and the rows of the output columns that belong to them.
    /// The result is that of the cells of this rank, and must not depend on the order of the joins.
    pub(in crate::pass) fn for_each_block<C: SharedColumns, S: Default + Send, const D: usize>(
        &self,
        grid: &CellGrid<D>,
        columns: C,
        work: &(impl Fn(Range<usize>, &mut C) -> S + Sync),
        join: &(impl Fn(S, S) -> S + Sync),
    ) -> S {
        let shared = self.group.as_ref().map(|group| (group, group.state()));
        match shared.filter(|(_, state)| state.domains.is_some()) {
            None => {
                let work = |cells: Range<usize>, mut columns: C| work(cells, &mut columns);
                for_each_block(grid.starts(), 0..grid.len(), columns, &work, join)
            }
            Some((group, mut state)) => group.for_each_block(&mut state, grid.starts(), columns, work, join),
        }
    }
}

/// Consecutive cells of one kind that have rows.
struct Piece {
    cells: Range<usize>,
    first_row: usize,
    kind: Kind,
}

/// Returns the pieces of the cells in their order; those of this rank are not larger than a block.
fn pieces(domains: &Domains, starts: &[u32]) -> Vec<Piece> {
    let mut pieces = Vec::with_capacity(domains.runs.len());
    for Run { cells, kind } in &domains.runs {
        let mut add = |cells: Range<usize>| {
            if starts[cells.start] < starts[cells.end] {
                pieces.push(Piece { first_row: starts[cells.start] as usize, cells, kind: *kind });
            }
        };
        if *kind == Kind::Other {
            add(cells.clone());
        } else {
            blocks_of(starts, cells.clone(), add);
        }
    }
    pieces
}

/// Cuts columns into the rows of the pieces, which are all rows.
fn cut<C: SharedColumns>(pieces: &[Piece], starts: &[u32], columns: C) -> Vec<C> {
    let mut rest = columns;
    let cut = |piece: &Piece| {
        let rows = starts[piece.cells.end] as usize - piece.first_row;
        let (columns, after) = std::mem::replace(&mut rest, C::none()).cut(rows);
        rest = after;
        columns
    };
    pieces.iter().map(cut).collect()
}

/// Lists the rows of cells, each with the index of its piece.
fn rows_in(pieces: &[Piece], cells: &[Range<usize>], starts: &[u32], found: &mut Vec<(usize, Range<usize>)>) {
    found.clear();
    let mut piece = 0;
    for cell in cells.iter().flat_map(Clone::clone) {
        let rows = starts[cell] as usize..starts[cell + 1] as usize;
        if rows.is_empty() {
            continue;
        }
        while pieces[piece].cells.end <= cell {
            piece += 1;
        }
        let first = pieces[piece].first_row;
        found.push((piece, rows.start - first..rows.end - first));
    }
}

/// Work on the cells of a block and the rows of the output columns that belong to them.
///
/// It is called through a pointer: a copy of the loops for every pass would take long to compile.
type Work<'a, C, S> = dyn Fn(Range<usize>, &mut C) -> S + Sync + 'a;

/// Joins two results.
type Join<'a, S> = dyn Fn(S, S) -> S + Sync + 'a;

/// Runs `work` over the pieces of a kind, in parallel, and joins the results; None if there are
/// none.
fn run<C: Send, S: Send>(
    kind: Kind,
    pieces: &[Piece],
    columns: &mut [C],
    work: &Work<'_, C, S>,
    join: &Join<'_, S>,
) -> Option<S> {
    if let ([piece], [columns]) = (pieces, &mut *columns) {
        return (piece.kind == kind).then(|| work(piece.cells.clone(), columns));
    }
    if pieces.iter().all(|piece| piece.kind != kind) {
        return None;
    }
    let middle = pieces.len() / 2;
    let ((low, high), (low_columns, high_columns)) = (pieces.split_at(middle), columns.split_at_mut(middle));
    let (low, high) =
        rayon::join(|| run(kind, low, low_columns, work, join), || run(kind, high, high_columns, work, join));
    joined(low, high, join)
}

/// Joins two results if there are two.
fn joined<S>(low: Option<S>, high: Option<S>, join: &Join<'_, S>) -> Option<S> {
    match (low, high) {
        (Some(low), Some(high)) => Some(join(low, high)),
        (low, high) => low.or(high),
    }
}

impl Group {
    fn for_each_block<C: SharedColumns, S: Default + Send>(
        &self,
        state: &mut State,
        starts: &[u32],
        columns: C,
        work: &Work<'_, C, S>,
        join: &Join<'_, S>,
    ) -> S {
        let ranks = self.transport.size();
        let Some(domains) = state.domains.take() else { return S::default() };
        let (width, is_whole) = (columns.width(), state.is_whole);
        let pieces = pieces(&domains, starts);
        let mut columns = cut(&pieces, starts, columns);
        let mut found = run(Kind::Sent, &pieces, &mut columns, work, join);
        let inner = |columns: &mut [C]| run(Kind::Inner, &pieces, columns, work, join);
        if width == 0 || is_whole {
            // Either nothing is sent, or also the inner cells are.
            found = joined(found, inner(&mut columns), join);
        }
        if width > 0 {
            let mut rows = Vec::new();
            for other in 0..ranks {
                let message = &mut state.messages.outgoing[other];
                message.clear();
                rows_in(&pieces, domains.sent_to(other, is_whole), starts, &mut rows);
                rows.drain(..).for_each(|(piece, rows)| columns[piece].write(rows, message));
                let count = |cells: &Range<usize>| (starts[cells.end] - starts[cells.start]) as usize;
                let expected: usize = domains.received_from(other, is_whole).iter().map(count).sum();
                state.messages.incoming[other].resize(expected * width, 0);
            }
            let mut of_inner = None;
            self.exchange_during(state, &mut || {
                if !is_whole {
                    of_inner = inner(&mut columns);
                }
            });
            found = joined(found, of_inner, join);
            for other in 0..ranks {
                let mut message = &state.messages.incoming[other][..];
                rows_in(&pieces, domains.received_from(other, is_whole), starts, &mut rows);
                for (piece, rows) in rows.drain(..) {
                    message = columns[piece].read(rows, message);
                }
            }
        }
        state.domains = Some(domains);
        found.unwrap_or_default()
    }
}
