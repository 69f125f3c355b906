//! Vectors of a pack, as the pair loops read them: one neighbour per lane.

use std::marker::PhantomData;

use super::Pack;
use crate::math::lanes::Lanes;
use crate::math::real::Real;

impl<R: Real> Pack<R> {
    /// Returns the packed particles, vector by vector; `columns` is the number of columns that will
    /// be read.
    #[inline(always)]
    pub fn entries<L: Lanes<Real = R>>(&self, columns: usize) -> Entries<'_, L> {
        assert!(columns <= self.columns && self.lanes == L::COUNT);
        Entries {
            base: self.storage[self.begin..].as_ptr(),
            left: self.len / L::COUNT,
            stride: self.stride,
            columns,
            pack: PhantomData,
        }
    }
}

/// The vectors of a pack, one after another.
#[derive(Debug)]
pub struct Entries<'a, L: Lanes> {
    base: *const L::Real,
    left: usize,
    stride: usize,
    columns: usize,
    pack: PhantomData<&'a L::Real>,
}

impl<'a, L: Lanes> Entries<'a, L> {
    /// Returns the number of remaining vectors.
    #[inline(always)]
    pub(super) fn len(&self) -> usize {
        self.left
    }

    /// Returns the vector that starts at a lane of the remaining ones. It may be any lane, since
    /// the columns have space for one more vector behind the last.
    #[inline(always)]
    pub(super) fn at(&self, lane: usize) -> Entry<'a, L> {
        debug_assert!(lane < self.left * L::COUNT);
        let base = self.base.wrapping_add(lane);
        Entry { base, stride: self.stride, columns: self.columns, pack: PhantomData }
    }
}

impl<'a, L: Lanes> Iterator for Entries<'a, L> {
    type Item = Entry<'a, L>;

    #[inline(always)]
    fn next(&mut self) -> Option<Entry<'a, L>> {
        if self.left == 0 {
            return None;
        }
        let entry = self.at(0);
        self.left -= 1;
        self.base = self.base.wrapping_add(L::COUNT);
        Some(entry)
    }
}

/// One vector of neighbours, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Entry<'a, L: Lanes> {
    base: *const L::Real,
    stride: usize,
    columns: usize,
    pack: PhantomData<&'a L::Real>,
}

impl<L: Lanes> Entry<'_, L> {
    /// Returns the numbers of a column: the coordinates first, then the columns in the order of the
    /// source.
    #[inline(always)]
    pub fn column(&self, column: usize) -> L {
        assert!(column < self.columns);
        // SAFETY: the pack has that many columns (checked when the iteration began), each of whole
        // vectors.
        unsafe { L::load(self.base.add(column * self.stride)) }
    }

    /// Returns `D` consecutive columns as a vector.
    #[inline(always)]
    pub fn vector<const D: usize>(&self, first: usize) -> [L; D] {
        let mut vector = [L::constant(0.0); D];
        for d in 0..D {
            vector[d] = self.column(first + d);
        }
        vector
    }

    /// Returns x_ab, a point minus the coordinates of the neighbours, in units of h.
    #[inline(always)]
    pub fn seen_from<const D: usize>(&self, point: [L; D]) -> [L; D] {
        let mut x = point;
        for d in 0..D {
            x[d] = point[d] - self.column(d);
        }
        x
    }
}
