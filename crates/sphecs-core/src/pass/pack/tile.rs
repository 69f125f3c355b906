//! Tiles of a pack, short enough to be read twice: once to find the neighbours, once to sum over
//! them.

use super::entries::{Entries, Entry};
use super::mask::{
    BITS, CoveredLanes, MaskBuilder, NeighbourMask, StartLanes, first_bits, least_lanes_per_bit,
};
use super::{CULLED_DIMENSIONS, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Largest number of vectors of a tile.
pub const TILE_VECTORS: usize = 64;

/// Returns the number of vectors of a full tile.
const fn tile_vectors<L: Lanes, const D: usize>() -> usize {
    if D < CULLED_DIMENSIONS { BITS * least_lanes_per_bit::<L>() / L::COUNT } else { TILE_VECTORS }
}

/// Consecutive vectors of a pack.
#[derive(Debug)]
pub struct Tile<'a, L: Lanes, const D: usize> {
    all: Entries<'a, L>,
    /// First vector of the tile in the pack.
    from: usize,
    len: usize,
}

impl<'a, L: Lanes, const D: usize> Tile<'a, L, D> {
    /// Returns the number of vectors.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Returns a vector by its number in the tile.
    #[inline(always)]
    pub fn at(&self, vector: usize) -> Entry<'a, L> {
        self.at_lane(vector * L::COUNT)
    }

    /// Returns the vector that starts at a lane of the tile.
    #[inline(always)]
    pub fn at_lane(&self, lane: usize) -> Entry<'a, L> {
        self.all.at(self.from * L::COUNT + lane)
    }

    /// Finds the particles closer to a point than the root of `limit`, without a branch.
    #[inline(always)]
    pub fn find_neighbours(&self, point: [L; D], limit: L) -> MaskBuilder {
        let mut mask = MaskBuilder::default();
        if D < CULLED_DIMENSIONS {
            for vector in 0..self.len {
                let mut square = L::constant(0.0);
                for x in self.at(vector).seen_from(point) {
                    square = x.mul_add(x, square);
                }
                mask.add::<L, D>(square, limit);
            }
        }
        mask
    }

    /// Returns the start lanes of the vectors that cover the neighbours of a mask, except those
    /// that the tile before has covered; `covered` is passed on to the next tile.
    #[inline(always)]
    pub fn start_lanes(&self, mask: MaskBuilder, covered: &mut CoveredLanes) -> StartLanes {
        if D >= CULLED_DIMENSIONS {
            return StartLanes::new::<L>(first_bits(self.len), L::COUNT);
        }
        let starts = StartLanes::new::<L>(mask.pairs & !covered.0, least_lanes_per_bit::<L>());
        if self.all.len() > tile_vectors::<L, D>() {
            *covered = starts.clone().covered_beyond();
        }
        starts
    }

    /// Adds the mask of the tile to that of its pack.
    #[inline(always)]
    pub fn store_mask(&self, mask: MaskBuilder, of_pack: &mut NeighbourMask) {
        if D >= CULLED_DIMENSIONS {
            return;
        }
        if self.all.len() <= tile_vectors::<L, D>() {
            *of_pack = NeighbourMask(mask.pairs);
        } else {
            self.store_part(mask.pairs, of_pack);
        }
    }

    /// Adds the mask of the tile to that of a pack of several tiles.
    #[cold]
    fn store_part(&self, pairs: u64, of_pack: &mut NeighbourMask) {
        if self.from == 0 {
            *of_pack = NeighbourMask(0);
        }
        let lanes_per_bit = NeighbourMask::lanes_per_bit::<L>(self.all.len());
        for pair in (0..BITS).filter(|pair| pairs >> pair & 1 != 0) {
            let bit = (self.from * L::COUNT + pair * least_lanes_per_bit::<L>()) / lanes_per_bit;
            if bit < BITS {
                of_pack.0 |= 1 << bit;
            }
        }
    }
}

/// The tiles of a pack, one after another.
#[derive(Debug)]
pub struct Tiles<'a, L: Lanes, const D: usize> {
    pack: &'a Pack<L::Real>,
    columns: usize,
    from: usize,
}

impl<'a, L: Lanes, const D: usize> Iterator for Tiles<'a, L, D> {
    type Item = Tile<'a, L, D>;

    #[inline(always)]
    fn next(&mut self) -> Option<Tile<'a, L, D>> {
        let all = self.pack.entries::<L>(self.columns);
        let (from, len) = (self.from, all.len().saturating_sub(self.from).min(tile_vectors::<L, D>()));
        self.from += tile_vectors::<L, D>();
        (len > 0).then_some(Tile { all, from, len })
    }
}

impl<R: Real> Pack<R> {
    /// Returns the packed particles in tiles; `columns` is the number of columns that will be read.
    #[inline(always)]
    pub fn tiles<L: Lanes<Real = R>, const D: usize>(&self, columns: usize) -> Tiles<'_, L, D> {
        Tiles { pack: self, columns, from: 0 }
    }
}
