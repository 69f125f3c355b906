//! A pack in stretches, to be walked more than once each: to see what is near, and then that.

use super::entries::{Entries, Entry};
use super::near::{BITS, Covered, Near, NearNotes, Windows, fewest, first_bits};
use super::{CULLED_DIMENSIONS, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Vectors of a stretch at most.
pub const STRETCH: usize = 64;

/// Vectors of a stretch of so many lanes each.
const fn stretch<L: Lanes, const D: usize>() -> usize {
    if D < CULLED_DIMENSIONS { BITS * fewest::<L>() / L::COUNT } else { STRETCH }
}

/// A stretch of a pack, of which all is walked, and then what is near.
#[derive(Debug)]
pub struct Stretch<'a, L: Lanes, const D: usize> {
    all: Entries<'a, L>,
    from: usize,
    len: usize,
}

impl<'a, L: Lanes, const D: usize> Stretch<'a, L, D> {
    /// Number of its vectors.
    #[inline(always)]
    pub fn len(&self) -> usize {
        self.len
    }

    /// One of its vectors.
    #[inline(always)]
    pub fn at(&self, vector: usize) -> Entry<'a, L> {
        self.at_lane(vector * L::COUNT)
    }

    /// The vector that begins at one of its lanes.
    #[inline(always)]
    pub fn at_lane(&self, lane: usize) -> Entry<'a, L> {
        self.all.at(self.from * L::COUNT + lane)
    }

    /// Takes note of what is nearer to a point than the root of `limit`, in a walk without a branch.
    #[inline(always)]
    pub fn find_near(&self, point: [L; D], limit: L) -> NearNotes {
        let mut notes = NearNotes::default();
        if D < CULLED_DIMENSIONS {
            for vector in 0..self.len {
                let mut square = L::constant(0.0);
                for x in self.at(vector).seen_from(point) {
                    square = x.mul_add(x, square);
                }
                notes.take::<L, D>(square, limit);
            }
        }
        notes
    }

    /// Lanes where vectors begin that have all in them that was noted, but for what those of the stretch before had of this one.
    #[inline(always)]
    pub fn near(&self, notes: NearNotes, covered: &mut Covered) -> Windows {
        if D >= CULLED_DIMENSIONS {
            return Windows::new::<L>(first_bits(self.len), L::COUNT);
        }
        let windows = Windows::new::<L>(notes.pairs & !covered.0, fewest::<L>());
        if self.all.len() > stretch::<L, D>() {
            *covered = windows.clone().covered_beyond();
        }
        windows
    }

    /// Adds what was noted of it to what is known of its pack.
    #[inline(always)]
    pub fn note(&self, notes: NearNotes, of_pack: &mut Near) {
        if D >= CULLED_DIMENSIONS {
            return;
        }
        if self.all.len() <= stretch::<L, D>() {
            *of_pack = Near(notes.pairs);
        } else {
            self.note_part(notes.pairs, of_pack);
        }
    }

    /// The same for a pack of more stretches than one.
    #[cold]
    fn note_part(&self, pairs: u64, of_pack: &mut Near) {
        if self.from == 0 {
            *of_pack = Near(0);
        }
        let unit = Near::unit::<L>(self.all.len());
        for pair in (0..BITS).filter(|pair| pairs >> pair & 1 != 0) {
            let bit = (self.from * L::COUNT + pair * fewest::<L>()) / unit;
            if bit < BITS {
                of_pack.0 |= 1 << bit;
            }
        }
    }
}

/// The stretches of a pack, one after another.
#[derive(Debug)]
pub struct Stretches<'a, L: Lanes, const D: usize> {
    pack: &'a Pack<L::Real>,
    columns: usize,
    from: usize,
}

impl<'a, L: Lanes, const D: usize> Iterator for Stretches<'a, L, D> {
    type Item = Stretch<'a, L, D>;

    #[inline(always)]
    fn next(&mut self) -> Option<Stretch<'a, L, D>> {
        let all = self.pack.entries::<L>(self.columns);
        let (from, len) = (self.from, all.len().saturating_sub(self.from).min(stretch::<L, D>()));
        self.from += stretch::<L, D>();
        (len > 0).then_some(Stretch { all, from, len })
    }
}

impl<R: Real> Pack<R> {
    /// The packed particles in stretches; `columns` says how many columns will be asked for.
    #[inline(always)]
    pub fn stretches<L: Lanes<Real = R>, const D: usize>(&self, columns: usize) -> Stretches<'_, L, D> {
        Stretches { pack: self, columns, from: 0 }
    }
}
