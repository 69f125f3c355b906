//! SIMD vectors as plain arrays, for other machines and, with one lane, for scalars.

use std::array::from_fn;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::{Lanes, MOST_LANES};
use crate::math::real::Real;

/// Vector of `N` numbers in an array.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Array<R, const N: usize>(pub [R; N]);

macro_rules! operators {
    ($($operator:ident $function:ident),*) => { $(
        impl<R: Real, const N: usize> $operator for Array<R, N> {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                Self(from_fn(|i| self.0[i].$function(other.0[i])))
            }
        }
    )* };
}
operators!(Add add, Sub sub, Mul mul, Div div);

impl<R: Real, const N: usize> Neg for Array<R, N> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(self.0.map(|x| -x))
    }
}

impl<R: Real, const N: usize> Array<R, N> {
    /// Applies a function of two numbers in each lane.
    #[inline(always)]
    fn zip(self, other: Self, function: impl Fn(R, R) -> R) -> Self {
        Self(from_fn(|i| function(self.0[i], other.0[i])))
    }
}

impl<R: Real, const N: usize> Lanes for Array<R, N> {
    type Real = R;
    type Mask = [bool; N];
    const COUNT: usize = N;

    #[inline(always)]
    fn splat(value: R) -> Self {
        Self([value; N])
    }
    #[inline(always)]
    unsafe fn load(from: *const R) -> Self {
        // SAFETY: the caller guarantees `N` numbers; an array has the alignment of its element.
        unsafe { Self(from.cast::<[R; N]>().read()) }
    }
    #[inline(always)]
    unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
        // SAFETY: the caller guarantees `N` numbers.
        let positions = unsafe { from.cast::<[f64; N]>().read() };
        Self(positions.map(|x| R::from_f64((x - origin) * scale)))
    }
    #[inline(always)]
    unsafe fn store(self, to: *mut R) {
        // SAFETY: the caller guarantees `N` numbers.
        unsafe { to.cast::<[R; N]>().write(self.0) }
    }
    #[inline(always)]
    unsafe fn compress(self, mask: [bool; N], to: *mut R) {
        let mut next = 0;
        for i in 0..N {
            // SAFETY: `next` never exceeds `i`, which is below the `N` that the caller guarantees.
            unsafe { to.add(next).write(self.0[i]) };
            next += usize::from(mask[i]);
        }
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        // `f64::mul_add` without the instruction would be a call into the C library.
        self * factor + term
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.zip(other, |a, b| if a > b { a } else { b })
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.zip(other, |a, b| if a < b { a } else { b })
    }
    #[inline(always)]
    fn abs(self) -> Self {
        Self(self.0.map(R::abs))
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        Self(self.0.map(R::sqrt))
    }
    #[inline(always)]
    fn inverse(self) -> Self {
        Self::constant(1.0) / self
    }
    #[inline(always)]
    fn roots(self) -> (Self, Self) {
        let root = self.sqrt();
        (root, Self::constant(1.0) / root)
    }
    #[inline(always)]
    fn less(self, other: Self) -> [bool; N] {
        from_fn(|i| self.0[i] < other.0[i])
    }
    #[inline(always)]
    fn select(mask: [bool; N], yes: Self, no: Self) -> Self {
        Self(from_fn(|i| if mask[i] { yes.0[i] } else { no.0[i] }))
    }
    #[inline(always)]
    fn bits(mask: [bool; N]) -> u32 {
        (0..N).map(|i| u32::from(mask[i]) << i).sum()
    }
    #[inline(always)]
    fn sum(self) -> R {
        let mut sum = self.0[0];
        for i in 1..N {
            sum += self.0[i];
        }
        sum
    }
    #[inline(always)]
    fn sum_each(vectors: &[Self; MOST_LANES]) -> Self {
        Self(from_fn(|i| vectors[i].sum()))
    }
    #[inline(always)]
    fn largest(self) -> R {
        let mut largest = self.0[0];
        for i in 1..N {
            if self.0[i] > largest {
                largest = self.0[i];
            }
        }
        largest
    }
}
