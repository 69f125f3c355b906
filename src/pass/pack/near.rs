//! Which vectors of a cell's pack have something in the support of a row.
//!
//! In 2D a quarter of them have nothing. A branch that leaves such a vector out is guessed wrong once or twice a row, and a wrong guess
//! costs as much as a vector or two. So the pass that sums the density, which needs no branch, notes which they are, and those that
//! walk the same packs after it step from one to the next. A pass that sums much beside the density walks the pack twice, stretch by
//! stretch: once for what all vectors need, once for what is near. In a culled pack they are too few: there nothing is noted, and all are
//! walked.

use super::entries::{Entries, Entry};
use super::{CULLED_DIMENSIONS, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Vectors of a pack, a bit each from the lowest on. Of a pack of more vectors than there are bits it is all.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Near(u64);

impl Near {
    /// All vectors: right for every row, if not the fastest.
    pub const ALL: Near = Near(u64::MAX);

    /// What was noted of a row; all if nothing was.
    #[inline(always)]
    pub fn of_row(noted: &[Near], row: usize) -> Near {
        noted.get(row).copied().unwrap_or(Near::ALL)
    }

    /// Which of the first so many vectors it has.
    #[inline(always)]
    fn among(self, count: usize) -> Noted {
        Noted(if count < STRETCH { self.0 & !(u64::MAX << count) } else { self.0 })
    }
}

/// How many of so many rows are to be noted of.
pub const fn noted<const D: usize>(rows: usize) -> usize {
    if D < CULLED_DIMENSIONS { rows } else { 0 }
}

/// Notes made while a pack is walked, vector by vector.
#[derive(Clone, Copy, Debug, Default)]
pub struct NearNotes {
    found: u64,
    vectors: u32,
}

impl NearNotes {
    /// Takes note of the next vector by its squared distances; `limit` is the square of the support.
    #[inline(always)]
    pub fn take<L: Lanes, const D: usize>(&mut self, q2: L, limit: L) {
        if D >= CULLED_DIMENSIONS {
            return;
        }
        let any = L::bits(q2.less(limit)) != 0;
        // Beyond the last bit it is written over from the first on, and not believed.
        self.found |= u64::from(any) << (self.vectors % u64::BITS);
        self.vectors += 1;
    }

    /// What was found.
    #[inline(always)]
    pub fn done<const D: usize>(self) -> Near {
        if D < CULLED_DIMENSIONS && self.vectors <= u64::BITS { Near(self.found) } else { Near::ALL }
    }
}

/// Vectors of a stretch at most: of each there is a bit.
pub const STRETCH: usize = u64::BITS as usize;

/// A stretch of a pack, to be walked twice: all of it, then what is near.
#[derive(Debug)]
pub struct Stretch<'a, L: Lanes> {
    all: Entries<'a, L>,
    from: usize,
    len: usize,
}

impl<'a, L: Lanes> Stretch<'a, L> {
    /// Number of its vectors, [`STRETCH`] at most.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// One of its vectors.
    #[inline(always)]
    pub fn at(&self, vector: usize) -> Entry<'a, L> {
        self.all.at(self.from + vector)
    }

    /// Those of its vectors that were noted, one after another.
    #[inline(always)]
    pub fn near(&self, near: Near) -> Noted {
        near.among(self.len)
    }

    /// What is noted of its vectors, as what is known of all of the pack.
    #[inline(always)]
    pub fn of_pack(&self, near: Near) -> Near {
        if self.all.len() <= STRETCH { near } else { Near::ALL }
    }
}

/// Numbers of the vectors that are near a row.
#[derive(Debug)]
pub struct Noted(u64);

impl Iterator for Noted {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.0 == 0 {
            return None;
        }
        let vector = self.0.trailing_zeros() as usize;
        self.0 &= self.0 - 1;
        Some(vector)
    }
}

/// The stretches of a pack, one after another.
#[derive(Debug)]
pub struct Stretches<'a, L: Lanes> {
    pack: &'a Pack<L::Real>,
    columns: usize,
    from: usize,
}

impl<'a, L: Lanes> Iterator for Stretches<'a, L> {
    type Item = Stretch<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Stretch<'a, L>> {
        let all = self.pack.entries::<L>(self.columns);
        let (from, len) = (self.from, all.len().saturating_sub(self.from).min(STRETCH));
        self.from += STRETCH;
        (len > 0).then_some(Stretch { all, from, len })
    }
}

impl<R: Real> Pack<R> {
    /// The packed particles in stretches of [`STRETCH`] vectors; `columns` says how many columns will be asked for.
    #[inline(always)]
    pub fn stretches<L: Lanes<Real = R>>(&self, columns: usize) -> Stretches<'_, L> {
        Stretches { pack: self, columns, from: 0 }
    }

    /// The vectors that are near a row, one after another; `columns` says how many columns will be asked for.
    #[inline(always)]
    pub fn entries_near<L: Lanes<Real = R>, const D: usize>(
        &self,
        columns: usize,
        near: Near,
    ) -> NearEntries<'_, L, D> {
        let all = self.entries::<L>(columns);
        let near = near.among(all.len());
        NearEntries { all, near, beyond: STRETCH }
    }
}

/// The vectors of a pack that are near a row.
#[derive(Debug)]
pub struct NearEntries<'a, L: Lanes, const D: usize> {
    all: Entries<'a, L>,
    near: Noted,
    /// The next of those that have no bit of their own.
    beyond: usize,
}

impl<'a, L: Lanes, const D: usize> Iterator for NearEntries<'a, L, D> {
    type Item = Entry<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry<'a, L>> {
        if D >= CULLED_DIMENSIONS {
            return self.all.next();
        }
        if let Some(vector) = self.near.next() {
            return Some(self.all.at(vector));
        }
        if self.beyond >= self.all.len() {
            return None;
        }
        self.beyond += 1;
        Some(self.all.at(self.beyond - 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::grid::CellGrid;
    use crate::math::lanes::{InstructionSet, Vectorised};
    use crate::pass::pack::{Only, Source};

    /// So many particles in a row of one cell, each 0.001 h from the next.
    struct Walk(usize);

    impl Vectorised<f64> for Walk {
        type Output = ();

        #[inline(always)]
        fn run<L: Lanes<Real = f64>>(self) {
            let count = self.0;
            let position = [(0..count).map(|row| 0.001 * row as f64).collect(), vec![0.5; count]];
            let mut grid = CellGrid::new([0.0; 2], [1.0; 2], [false; 2], 1.0, 1.0);
            let ids: Vec<u32> = (0..count as u32).collect();
            grid.build(&position, &ids, |_| true).expect("all are inside");
            let (inverse_h, support_ratio) = (1.0, 1.0);
            let source = Source {
                grid: &grid,
                position: &position,
                columns: &[],
                inverse_h,
                support_ratio,
                only: Only::All,
            };
            let mut pack = Pack::default();
            assert!(pack.fill::<L, 2>(&source, 0, |_| true));
            // The first and the last are in reach of a support of 0.0005 of themselves alone.
            for row in [0, count / 2, count - 1] {
                let point = pack.relative(&source, row).map(L::splat);
                let mut notes = NearNotes::default();
                for entry in pack.entries::<L>(2) {
                    let x = point[0] - entry.column(0);
                    notes.take::<L, 2>(x * x, L::constant(0.0005 * 0.0005));
                }
                let near = notes.done::<2>();
                let vectors = count.div_ceil(L::COUNT);
                let seen = |near: Near| {
                    pack.entries_near::<L, 2>(2, near)
                        .map(|entry| entry.column(0).largest())
                        .collect::<Vec<f64>>()
                };
                let all = seen(Near::ALL);
                assert_eq!(all.len(), vectors, "{} lanes, {count} particles", L::COUNT);
                let vector = row / L::COUNT;
                let expected = if vectors <= 64 { &all[vector..=vector] } else { &all[..] };
                assert_eq!(seen(near), expected, "row {row} of {count}, {} lanes", L::COUNT);
                // In stretches every vector comes once, and the one of the row is found however many there are.
                let (mut walked, mut found) = (Vec::new(), Vec::new());
                for stretch in pack.stretches::<L>(2) {
                    let mut notes = NearNotes::default();
                    for vector in 0..stretch.len() {
                        let first = stretch.at(vector).column(0);
                        walked.push(first.largest());
                        let x = point[0] - first;
                        notes.take::<L, 2>(x * x, L::constant(0.0005 * 0.0005));
                    }
                    let noted = notes.done::<2>();
                    found.extend(stretch.near(noted).map(|vector| stretch.at(vector).column(0).largest()));
                    assert_eq!(stretch.of_pack(noted), near, "row {row} of {count}, {} lanes", L::COUNT);
                }
                assert_eq!(walked, all);
                assert_eq!(found, &all[vector..=vector], "row {row} of {count}, {} lanes", L::COUNT);
            }
        }
    }

    #[test]
    fn the_vector_of_a_particle_is_found_and_where_bits_do_not_suffice_all_are_walked() {
        for set in InstructionSet::available() {
            for count in [1, 7, 128, 129, 200, 256, 257, 64 * 8, 64 * 8 + 1, 999] {
                <f64 as Real>::dispatch(set, Walk(count));
            }
        }
    }
}
