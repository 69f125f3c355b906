//! Which particles of a cell's pack are in the support of a row.
//!
//! In 2D a third of them are, and a quarter of the pack's vectors have none. A branch that leaves such a vector out is guessed wrong once
//! or twice a row, and a wrong guess costs as much as a vector or two. So the pass that sums the density, which needs no branch, notes
//! which particles are near, a bit for each two, and those that walk the same packs after it go from one to the next: a vector begins at a
//! particle that is near, wherever in the pack that is, and the next at the first one that is near behind it. Those are a fifth fewer than
//! whole vectors of the pack with something near in them. A pass that sums much beside the density walks the pack stretch by
//! stretch: once to see what is near, then that. In a culled pack too few are not near: there nothing is noted, and all
//! are walked.

use super::entries::{Entries, Entry};
use super::{CULLED_DIMENSIONS, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Bits of a note.
pub(super) const BITS: usize = u64::BITS as usize;

/// Fewest lanes that share a bit: vectors may begin at every other particle, which is nearly as good as at each.
#[inline(always)]
pub(super) const fn fewest<L: Lanes>() -> usize {
    if L::COUNT < 2 { 1 } else { 2 }
}

/// Lanes of a pack, so many of them a bit (two if there are bits enough), from the lowest on; of a pack of more vectors than
/// there are bits all is near that has no bit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Near(pub(super) u64);

impl Near {
    /// All of a pack: right for every row, if not the fastest.
    pub const ALL: Near = Near(u64::MAX);

    /// What was noted of a row; all if nothing was.
    #[inline(always)]
    pub fn of_row(noted: &[Near], row: usize) -> Near {
        noted.get(row).copied().unwrap_or(Near::ALL)
    }

    /// Lanes that share a bit in a pack of so many vectors.
    #[inline(always)]
    pub(super) fn unit<L: Lanes>(vectors: usize) -> usize {
        let mut unit = fewest::<L>();
        while unit < L::COUNT && vectors * L::COUNT > BITS * unit {
            unit *= 2;
        }
        unit
    }
}

/// How many of so many rows are to be noted of.
pub const fn noted<const D: usize>(rows: usize) -> usize {
    if D < CULLED_DIMENSIONS { rows } else { 0 }
}

/// Notes made while a stretch is walked, vector by vector: a bit for each two lanes, whether one of them is near.
#[derive(Clone, Copy, Debug, Default)]
pub struct NearNotes {
    pub(super) pairs: u64,
    noted: u32,
}

impl NearNotes {
    /// Takes note of the next vector by its squared distances; `limit` is the square of the support.
    #[inline(always)]
    pub fn take<L: Lanes, const D: usize>(&mut self, q2: L, limit: L) {
        if D < CULLED_DIMENSIONS {
            self.pairs |= u64::from(L::pair_bits(q2.less(limit))) << (self.noted % u64::BITS);
            self.noted += (L::COUNT / fewest::<L>()) as u32;
        }
    }
}

/// The bits that notes of a pack of so many vectors have, and the lanes that share one.
#[inline(always)]
pub(super) fn bits_of<L: Lanes>(vectors: usize) -> (u64, usize) {
    let unit = Near::unit::<L>(vectors);
    (first_bits(vectors * L::COUNT / unit), unit)
}

/// So many of the lowest bits.
#[inline(always)]
pub(super) fn first_bits(count: usize) -> u64 {
    if count < BITS { !(u64::MAX << count) } else { u64::MAX }
}

/// Bits of a stretch whose lanes the last of the vectors of the stretch before has in it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Covered(pub(super) u64);

/// Lanes of a pack where vectors begin that have all in them that is near, one after another.
#[derive(Clone, Debug)]
pub struct Windows {
    bits: u64,
    /// Bits of a vector.
    vector: u64,
    /// Lanes of a bit.
    unit: usize,
}

impl Windows {
    #[inline(always)]
    pub(super) fn new<L: Lanes>(bits: u64, unit: usize) -> Self {
        Self { bits, vector: first_bits(L::COUNT / unit), unit }
    }

    /// What the last of these vectors has of the bits that follow.
    #[cold]
    pub(super) fn covered_beyond(self) -> Covered {
        let (vector, unit) = (self.vector, self.unit);
        let last = self.last().map_or(0, |lane| lane / unit);
        Covered(u64::try_from((u128::from(vector) << last) >> BITS).unwrap_or(0))
    }
}

impl Iterator for Windows {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.bits == 0 {
            return None;
        }
        let bit = self.bits.trailing_zeros();
        self.bits &= !(self.vector << bit);
        Some(bit as usize * self.unit)
    }
}

impl<R: Real> Pack<R> {
    /// Vectors that have all in them that is near a row, one after another; `columns` says how many columns will be asked for.
    #[inline(always)]
    pub fn entries_near<L: Lanes<Real = R>, const D: usize>(
        &self,
        columns: usize,
        near: Near,
    ) -> NearEntries<'_, L, D> {
        let all = self.entries::<L>(columns);
        let windows = Windows::new::<L>(near.0 & self.bits, self.unit);
        NearEntries { all, windows, beyond: BITS }
    }
}

/// Vectors of a pack that have all in them that is near a row.
#[derive(Debug)]
pub struct NearEntries<'a, L: Lanes, const D: usize> {
    all: Entries<'a, L>,
    windows: Windows,
    /// The next of the vectors that have no bit of their own.
    beyond: usize,
}

impl<'a, L: Lanes, const D: usize> Iterator for NearEntries<'a, L, D> {
    type Item = Entry<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry<'a, L>> {
        if D >= CULLED_DIMENSIONS {
            return self.all.next();
        }
        if let Some(lane) = self.windows.next() {
            return Some(self.all.at(lane));
        }
        if self.beyond >= self.all.len() {
            return None;
        }
        self.beyond += 1;
        Some(self.all.at((self.beyond - 1) * L::COUNT))
    }
}
