//! Masks of the particles of a pack that are in the support of a row.
//!
//! In 2D a third of the particles of a pack are, and a quarter of its vectors contain none. A
//! branch that skips such a vector is mispredicted once or twice per row, which costs as much as
//! one or two vectors. So the density pass, which needs no branch, stores a mask for every row,
//! with one bit for two particles. Later passes over the same packs step from one set bit to the
//! next. A vector starts at any particle in the support, and the next vector at the first such
//! particle behind it. That makes a fifth fewer vectors than the aligned ones with a particle in
//! the support.
//!
//! A pass that sums much besides the density processes the pack tile by tile (`tile.rs`): it first
//! finds the neighbours, then sums over these alone. In a culled pack too few particles are out of
//! reach, so no mask is made and all vectors are read.

use super::entries::{Entries, Entry};
use super::{CULLED_DIMENSIONS, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;
use crate::pass::ranks::OutputNumber;

/// Bits of a mask.
pub(super) const BITS: usize = u64::BITS as usize;

/// Returns the smallest number of lanes that share a bit. Vectors that start at every other
/// particle are nearly as few as vectors that start at any.
#[inline(always)]
pub(super) const fn least_lanes_per_bit<L: Lanes>() -> usize {
    if L::COUNT < 2 { 1 } else { 2 }
}

/// Particles of a pack in the support of a row: one bit for some consecutive lanes (two if there
/// are bits enough), the first lanes lowest. Lanes beyond the last bit count as in the support.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct NeighbourMask(pub(super) u64);

impl OutputNumber for NeighbourMask {
    const IS_SENT: bool = false;
}

impl NeighbourMask {
    /// All particles of a pack, which is correct for every row but slower.
    pub const ALL: NeighbourMask = NeighbourMask(u64::MAX);

    /// Returns the mask of a row, or that of all particles if none were made.
    #[inline(always)]
    pub fn of_row(masks: &[NeighbourMask], row: usize) -> NeighbourMask {
        masks.get(row).copied().unwrap_or(NeighbourMask::ALL)
    }

    /// Returns the number of lanes that share a bit in a pack of `vectors` vectors.
    #[inline(always)]
    pub(super) fn lanes_per_bit<L: Lanes>(vectors: usize) -> usize {
        let mut lanes = least_lanes_per_bit::<L>();
        while lanes < L::COUNT && vectors * L::COUNT > BITS * lanes {
            lanes *= 2;
        }
        lanes
    }
}

/// Returns the number of masks for `rows` rows, 0 where packs are culled.
pub const fn mask_len<const D: usize>(rows: usize) -> usize {
    if D < CULLED_DIMENSIONS { rows } else { 0 }
}

/// Mask of a tile, built vector by vector: one bit for every two lanes.
#[derive(Clone, Copy, Debug, Default)]
pub struct MaskBuilder {
    pub(super) pairs: u64,
    /// Bits that are built.
    len: u32,
}

impl MaskBuilder {
    /// Adds the next vector by its squared distances; `limit` is the square of the support.
    #[inline(always)]
    pub fn add<L: Lanes, const D: usize>(&mut self, q2: L, limit: L) {
        if D < CULLED_DIMENSIONS {
            self.pairs |= u64::from(L::pair_bits(q2.less(limit))) << (self.len % u64::BITS);
            self.len += (L::COUNT / least_lanes_per_bit::<L>()) as u32;
        }
    }
}

/// Returns the bits that masks of a pack of `vectors` vectors use, and the lanes that share one.
#[inline(always)]
pub(super) fn used_bits<L: Lanes>(vectors: usize) -> (u64, usize) {
    let lanes_per_bit = NeighbourMask::lanes_per_bit::<L>(vectors);
    (first_bits(vectors * L::COUNT / lanes_per_bit), lanes_per_bit)
}

/// Returns the lowest `count` bits.
#[inline(always)]
pub(super) fn first_bits(count: usize) -> u64 {
    if count < BITS { !(u64::MAX << count) } else { u64::MAX }
}

/// Mask bits of a tile whose lanes the last vector of the tile before already covers.
#[derive(Clone, Copy, Debug, Default)]
pub struct CoveredLanes(pub(super) u64);

/// Start lanes of the vectors that together cover every neighbour in the support.
#[derive(Clone, Debug)]
pub struct StartLanes {
    bits: u64,
    /// Bits of one vector.
    vector: u64,
    lanes_per_bit: usize,
}

impl StartLanes {
    #[inline(always)]
    pub(super) fn new<L: Lanes>(bits: u64, lanes_per_bit: usize) -> Self {
        Self { bits, vector: first_bits(L::COUNT / lanes_per_bit), lanes_per_bit }
    }

    /// Returns the lanes of the next tile that the last of these vectors covers.
    #[cold]
    pub(super) fn covered_beyond(self) -> CoveredLanes {
        let (vector, lanes_per_bit) = (self.vector, self.lanes_per_bit);
        let last = self.last().map_or(0, |lane| lane / lanes_per_bit);
        CoveredLanes(u64::try_from((u128::from(vector) << last) >> BITS).unwrap_or(0))
    }
}

impl Iterator for StartLanes {
    type Item = usize;

    #[inline(always)]
    fn next(&mut self) -> Option<usize> {
        if self.bits == 0 {
            return None;
        }
        let bit = self.bits.trailing_zeros();
        self.bits &= !(self.vector << bit);
        Some(bit as usize * self.lanes_per_bit)
    }
}

impl<R: Real> Pack<R> {
    /// Returns the vectors that together cover every neighbour of a mask; `columns` is the number
    /// of columns that will be read.
    #[inline(always)]
    pub fn masked_entries<L: Lanes<Real = R>, const D: usize>(
        &self,
        columns: usize,
        mask: NeighbourMask,
    ) -> MaskedEntries<'_, L, D> {
        let all = self.entries::<L>(columns);
        let starts = StartLanes::new::<L>(mask.0 & self.used_bits, self.lanes_per_bit);
        MaskedEntries { all, starts, beyond: BITS }
    }
}

/// Vectors of a pack that together cover every neighbour of a mask.
#[derive(Debug)]
pub struct MaskedEntries<'a, L: Lanes, const D: usize> {
    all: Entries<'a, L>,
    starts: StartLanes,
    /// Next of the vectors without a bit.
    beyond: usize,
}

impl<'a, L: Lanes, const D: usize> Iterator for MaskedEntries<'a, L, D> {
    type Item = Entry<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry<'a, L>> {
        if D >= CULLED_DIMENSIONS {
            return self.all.next();
        }
        if let Some(lane) = self.starts.next() {
            return Some(self.all.at(lane));
        }
        if self.beyond >= self.all.len() {
            return None;
        }
        self.beyond += 1;
        Some(self.all.at((self.beyond - 1) * L::COUNT))
    }
}
