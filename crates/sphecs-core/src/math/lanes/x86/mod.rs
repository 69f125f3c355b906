//! SIMD vectors of x86-64: AVX-512 and AVX2 with FMA.
//!
//! All functions are inlined into one that is compiled for the instruction set (see
//! [`instruction_set`](super::instruction_set)). The types are not public, so that no other code
//! can name them. The hardware estimates of 1/x and 1/√x are refined by the first terms of their
//! series in the error e, which takes half as many instructions as another Newton step:
//!
//! ```text
//! 1/x  = y (1 + e + e² + e³ + …),          e = 1 − x y
//! 1/√x = y (1 + e/2 + 3e²/8 + 5e³/16 + …), e = 1 − x y²,   √x = x y (1 + …) by the same series
//! ```
//!
//! From an estimate of 14 bits, the terms up to e³ leave an error of 2⁻⁵⁴ in f64, and e alone 2⁻²⁷
//! in f32.

mod avx2;
mod avx512;

pub(super) use avx2::{F32x8, F64x4};
pub(super) use avx512::{F32x16, F64x8};

macro_rules! lanes {
    (
        $(#[$doc:meta])* $name:ident: [$real:ty; $count:literal] as $vector:ty, mask $mask:ty,
        $splat:ident, $load:ident, $store:ident, $add:ident, $sub:ident, $mul:ident, $div:ident,
        $fma:ident, $max:ident, $min:ident, $sqrt:ident,
        $($constant:ident = $value:literal,)?
        { $($special:item)* }
    ) => {
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name($vector);

        lanes!(@operator $name Add add $add);
        lanes!(@operator $name Sub sub $sub);
        lanes!(@operator $name Mul mul $mul);
        lanes!(@operator $name Div div $div);

        impl Neg for $name {
            type Output = Self;
            #[inline(always)]
            fn neg(self) -> Self {
                // SAFETY: a value of this type exists only where its instructions do. −0 − x is −x
                // for every x.
                unsafe { Self($sub($splat(-0.0), self.0)) }
            }
        }

        // SAFETY of all blocks below: the instruction set is detected before any function of this
        // type is called; the caller guarantees that the pointers are valid.
        impl Lanes for $name {
            type Real = $real;
            type Mask = $mask;
            const COUNT: usize = $count;
            $(const $constant: bool = $value;)?
            #[inline(always)]
            fn splat(value: $real) -> Self {
                // SAFETY: as above.
                unsafe { Self($splat(value)) }
            }
            #[inline(always)]
            unsafe fn load(from: *const $real) -> Self {
                // SAFETY: as above.
                unsafe { Self($load(from)) }
            }
            #[inline(always)]
            unsafe fn store(self, to: *mut $real) {
                // SAFETY: as above.
                unsafe { $store(to, self.0) }
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                // SAFETY: as above.
                unsafe { Self($fma(self.0, factor.0, term.0)) }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { Self($max(self.0, other.0)) }
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                // SAFETY: as above.
                unsafe { Self($min(self.0, other.0)) }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                // SAFETY: as above.
                unsafe { Self($sqrt(self.0)) }
            }
            $(
                #[inline(always)]
                $special
            )*
        }
    };
    (@operator $name:ident $operator:ident $function:ident $intrinsic:ident) => {
        impl $operator for $name {
            type Output = Self;
            #[inline(always)]
            fn $function(self, other: Self) -> Self {
                // SAFETY: a value of this type exists only where its instructions do.
                unsafe { Self($intrinsic(self.0, other.0)) }
            }
        }
    };
}

use lanes;
