//! Lanes over the vectors of AVX-512.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::lanes;
use crate::math::lanes::Lanes;

lanes! {
    /// Eight f64 of AVX-512.
    F64x8: [f64; 8] as __m512d, mask __mmask8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd,
    _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd,
    _mm512_fmadd_pd, _mm512_max_pd, _mm512_min_pd, _mm512_sqrt_pd,
    {
        unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
            // SAFETY: as said above.
            unsafe { (Self::load(from) - Self::splat(origin)) * Self::splat(scale) }
        }
        unsafe fn compress(self, mask: __mmask8, to: *mut f64) {
            // SAFETY: as said above. Compressing in a register and storing all of it is many times faster than the
            // compressing store.
            unsafe { _mm512_storeu_pd(to, _mm512_maskz_compress_pd(mask, self.0)) }
        }
        fn abs(self) -> Self {
            // SAFETY: as said above.
            unsafe { Self(_mm512_abs_pd(self.0)) }
        }
        fn inverse(self) -> Self {
            // SAFETY: as said above.
            let y = unsafe { Self(_mm512_rcp14_pd(self.0)) };
            let e = (-self).mul_add(y, Self::splat(1.0));
            let series = e.mul_add(e, e).mul_add(e, e);
            y.mul_add(series, y)
        }
        fn roots(self) -> (Self, Self) {
            // SAFETY: as said above.
            let y = unsafe { Self(_mm512_rsqrt14_pd(self.0)) };
            let e = (-(self * y)).mul_add(y, Self::splat(1.0));
            let series = e.mul_add(Self::splat(0.3125), Self::splat(0.375)).mul_add(e, Self::splat(0.5));
            let inverse = (y * e).mul_add(series, y);
            (self * inverse, inverse)
        }
        fn less(self, other: Self) -> __mmask8 {
            // SAFETY: as said above.
            unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __mmask8, yes: Self, no: Self) -> Self {
            // SAFETY: as said above.
            unsafe { Self(_mm512_mask_blend_pd(mask, no.0, yes.0)) }
        }
        fn bits(mask: __mmask8) -> u32 {
            u32::from(mask)
        }
        fn sum(self) -> f64 {
            // SAFETY: as said above.
            unsafe { _mm512_reduce_add_pd(self.0) }
        }
        fn largest(self) -> f64 {
            // SAFETY: as said above.
            unsafe { _mm512_reduce_max_pd(self.0) }
        }
    }
}

lanes! {
    /// Sixteen f32 of AVX-512.
    F32x16: [f32; 16] as __m512, mask __mmask16,
    _mm512_set1_ps, _mm512_loadu_ps, _mm512_storeu_ps,
    _mm512_add_ps, _mm512_sub_ps, _mm512_mul_ps, _mm512_div_ps,
    _mm512_fmadd_ps, _mm512_max_ps, _mm512_min_ps, _mm512_sqrt_ps,
    {
        unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
            // SAFETY: as said above.
            unsafe {
                let low = F64x8::load_relative(from, origin, scale);
                let high = F64x8::load_relative(from.add(8), origin, scale);
                let (low, high) = (_mm512_cvtpd_ps(low.0), _mm512_cvtpd_ps(high.0));
                Self(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
            }
        }
        unsafe fn compress(self, mask: __mmask16, to: *mut f32) {
            // SAFETY: as said above.
            unsafe { _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask, self.0)) }
        }
        fn abs(self) -> Self {
            // SAFETY: as said above.
            unsafe { Self(_mm512_abs_ps(self.0)) }
        }
        fn inverse(self) -> Self {
            // SAFETY: as said above.
            let y = unsafe { Self(_mm512_rcp14_ps(self.0)) };
            let e = (-self).mul_add(y, Self::splat(1.0));
            y.mul_add(e, y)
        }
        fn roots(self) -> (Self, Self) {
            // SAFETY: as said above.
            let y = unsafe { Self(_mm512_rsqrt14_ps(self.0)) };
            let e = (-(self * y)).mul_add(y, Self::splat(1.0));
            let inverse = (y * e).mul_add(Self::splat(0.5), y);
            (self * inverse, inverse)
        }
        fn less(self, other: Self) -> __mmask16 {
            // SAFETY: as said above.
            unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __mmask16, yes: Self, no: Self) -> Self {
            // SAFETY: as said above.
            unsafe { Self(_mm512_mask_blend_ps(mask, no.0, yes.0)) }
        }
        fn bits(mask: __mmask16) -> u32 {
            u32::from(mask)
        }
        fn sum(self) -> f32 {
            // SAFETY: as said above.
            unsafe { _mm512_reduce_add_ps(self.0) }
        }
        fn largest(self) -> f32 {
            // SAFETY: as said above.
            unsafe { _mm512_reduce_max_ps(self.0) }
        }
    }
}
