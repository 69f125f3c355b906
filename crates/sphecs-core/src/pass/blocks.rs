//! Parallel loops over blocks of cells and over parts of the rows, each with the rows that it may
//! write.

use std::ops::Range;

use rayon::iter::{IndexedParallelIterator, IntoParallelRefMutIterator, ParallelIterator};

/// Largest number of rows of a block of several cells: enough to amortise a task, few enough to
/// balance the threads.
const ROWS: usize = 1024;

/// Largest number of rows of a part. A row costs less here, so it is more than for a block.
const PART: usize = 4096;

/// Rows that are processed together: the compiler vectorises a loop over them without branches.
pub const GROUP: usize = 64;

/// Output columns that can be split at a row.
pub trait SplittableColumns: Send + Sized {
    /// Returns columns without rows.
    fn none() -> Self;

    /// Returns the columns up to `row` and from `row` on.
    fn cut(self, row: usize) -> (Self, Self);
}

impl<T: Send> SplittableColumns for &mut [T] {
    fn none() -> Self {
        &mut []
    }

    fn cut(self, row: usize) -> (Self, Self) {
        // A column that is not in use is empty, and so are both parts of it.
        let row = row.min(self.len());
        self.split_at_mut(row)
    }
}

impl<C: SplittableColumns, const N: usize> SplittableColumns for [C; N] {
    fn none() -> Self {
        std::array::from_fn(|_| C::none())
    }

    fn cut(self, row: usize) -> (Self, Self) {
        let (mut low, mut high) = (Self::none(), Self::none());
        for ((column, low), high) in self.into_iter().zip(&mut low).zip(&mut high) {
            (*low, *high) = column.cut(row);
        }
        (low, high)
    }
}

macro_rules! tuples {
    ($($name:ident $low:ident $high:ident),*) => {
        impl<$($name: SplittableColumns),*> SplittableColumns for ($($name,)*) {
            fn none() -> Self {
                ($($name::none(),)*)
            }

            fn cut(self, row: usize) -> (Self, Self) {
                #[allow(non_snake_case, reason = "the type's letter names the value too")]
                let ($($name,)*) = self;
                $(let ($low, $high) = $name.cut(row);)*
                (($($low,)*), ($($high,)*))
            }
        }
    };
}
tuples!(A a_low a_high, B b_low b_high);
tuples!(A a_low a_high, B b_low b_high, C c_low c_high);
tuples!(A a_low a_high, B b_low b_high, C c_low c_high, E e_low e_high);

/// Runs `work` over cells in blocks, in parallel, and joins the results.
///
/// `starts` are the first rows of all cells. `work` takes the cells of a block and the rows of the
/// output columns that belong to them. The result must not depend on the order of the joins.
pub(super) fn for_each_block<C: SplittableColumns, S: Send>(
    starts: &[u32],
    cells: Range<usize>,
    columns: C,
    work: &(impl Fn(Range<usize>, C) -> S + Sync),
    join: &(impl Fn(S, S) -> S + Sync),
) -> S {
    let rows = (starts[cells.end] - starts[cells.start]) as usize;
    if rows <= ROWS || cells.len() == 1 {
        return work(cells, columns);
    }
    // The halves have equal numbers of rows, not cells: most cells around a bent domain may be
    // empty.
    let middle_row = starts[cells.start] + rows as u32 / 2;
    let inner = &starts[cells.start + 1..cells.end];
    let middle = cells.start + 1 + inner.partition_point(|&start| start < middle_row).min(inner.len() - 1);
    let (low, high) = columns.cut((starts[middle] - starts[cells.start]) as usize);
    let (a, b) = rayon::join(
        || for_each_block(starts, cells.start..middle, low, work, join),
        || for_each_block(starts, middle..cells.end, high, work, join),
    );
    join(a, b)
}

/// Visits consecutive cells in blocks of about [`ROWS`] rows, one after the other.
pub(super) fn blocks_of(starts: &[u32], cells: Range<usize>, mut visit: impl FnMut(Range<usize>)) {
    let mut first = cells.start;
    for cell in cells.clone() {
        if (starts[cell + 1] - starts[first]) as usize >= ROWS {
            visit(first..cell + 1);
            first = cell + 1;
        }
    }
    if first < cells.end {
        visit(first..cells.end);
    }
}

/// Runs `work` over the rows in parts, in parallel, for work that needs no neighbours.
///
/// `work` takes the rows of a part and the same rows of the columns.
pub fn for_each_part<C: SplittableColumns>(
    rows: Range<usize>,
    columns: C,
    work: &(impl Fn(Range<usize>, C) + Sync),
) {
    if rows.len() <= PART {
        return work(rows, columns);
    }
    let half = rows.len() / 2;
    let middle = rows.start + half;
    let (low, high) = columns.cut(half);
    rayon::join(
        || for_each_part(rows.start..middle, low, work),
        || for_each_part(middle..rows.end, high, work),
    );
}

/// Rows of a part that is searched for a list of few rows.
const LISTED: usize = 1024;

/// Runs `work` over the rows in parts, in parallel, each with a list of its own.
///
/// The lists are kept from call to call as `work` left them. Returns those of these rows, in the
/// order of the rows.
pub fn with_lists<'a, T: Default + Send>(
    rows: usize,
    lists: &'a mut Vec<T>,
    work: &(impl Fn(Range<usize>, &mut T) + Sync),
) -> &'a mut [T] {
    let parts = rows.div_ceil(LISTED);
    if lists.len() < parts {
        lists.resize_with(parts, T::default);
    }
    let lists = &mut lists[..parts];
    lists
        .par_iter_mut()
        .enumerate()
        .for_each(|(part, list)| work(part * LISTED..rows.min((part + 1) * LISTED), list));
    lists
}

/// Runs `work` over the rows in parts, in parallel, and joins the results in the order of the rows.
pub fn join_parts<S: Send>(
    rows: Range<usize>,
    work: &(impl Fn(Range<usize>) -> S + Sync),
    join: &(impl Fn(S, S) -> S + Sync),
) -> S {
    if rows.len() <= PART {
        return work(rows);
    }
    let middle = rows.start + rows.len() / 2;
    let (low, high) = rayon::join(
        || join_parts(rows.start..middle, work, join),
        || join_parts(middle..rows.end, work, join),
    );
    join(low, high)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_is_processed_once() {
        for rows in [0, 1, PART, PART + 1, 5 * PART + 3] {
            let (mut first, mut second) = (vec![0; rows], vec![0.0; rows]);
            let columns = ([&mut first[..]], [&mut second[..]]);
            for_each_part(
                0..rows,
                columns,
                &|rows, ([first], [second]): ([&mut [usize]; 1], [&mut [f64]; 1])| {
                    for (at, row) in rows.enumerate() {
                        first[at] += row;
                        second[at] += 1.0;
                    }
                },
            );
            assert!(first.iter().enumerate().all(|(row, &found)| row == found));
            assert!(second.iter().all(|&times| times == 1.0));
        }
    }

    #[test]
    fn lists_are_in_the_order_of_the_rows() {
        let mut lists = Vec::<Vec<usize>>::new();
        for rows in [0, 5 * LISTED + 3, LISTED + 1, LISTED, 1] {
            let found = with_lists(rows, &mut lists, &|rows, list| {
                list.clear();
                list.extend(rows);
            });
            assert!(found.iter().flatten().copied().eq(0..rows), "{rows}");
        }
    }

    #[test]
    fn parts_are_joined_in_the_order_of_the_rows() {
        let join = |mut low: Vec<usize>, high: Vec<usize>| {
            low.extend(high);
            low
        };
        let found = join_parts(0..9 * PART, &|rows| rows.step_by(7).take(20).collect(), &join);
        assert!(found.is_sorted() && found.len() > 20);
    }
}
