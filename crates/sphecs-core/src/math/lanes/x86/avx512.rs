//! SIMD vectors of AVX-512.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::avx2::{eight_ps, four_pd};
use super::lanes;
use crate::math::lanes::{Lanes, MOST_LANES};

lanes! {
    /// Eight f64 of AVX-512.
    F64x8: [f64; 8] as __m512d, mask __mmask8,
    _mm512_set1_pd, _mm512_loadu_pd, _mm512_storeu_pd,
    _mm512_add_pd, _mm512_sub_pd, _mm512_mul_pd, _mm512_div_pd,
    _mm512_fmadd_pd, _mm512_max_pd, _mm512_min_pd, _mm512_sqrt_pd,
    {
        unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
            // SAFETY: as above.
            unsafe { (Self::load(from) - Self::splat(origin)) * Self::splat(scale) }
        }
        unsafe fn compress(self, mask: __mmask8, to: *mut f64) {
            // SAFETY: as above. Compressing in a register and storing all lanes is many times
            // faster than the compressing store.
            unsafe { _mm512_storeu_pd(to, _mm512_maskz_compress_pd(mask, self.0)) }
        }
        fn abs(self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm512_abs_pd(self.0)) }
        }
        fn inverse(self) -> Self {
            // SAFETY: as above.
            let y = unsafe { Self(_mm512_rcp14_pd(self.0)) };
            let e = (-self).mul_add(y, Self::splat(1.0));
            let series = e.mul_add(e, e).mul_add(e, e);
            y.mul_add(series, y)
        }
        fn roots(self) -> (Self, Self) {
            // SAFETY: as above.
            let y = unsafe { Self(_mm512_rsqrt14_pd(self.0)) };
            // Both are computed from the estimate, so that neither depends on the other: most
            // callers need only √x.
            let root = self * y;
            let e = (-root).mul_add(y, Self::splat(1.0));
            let series = e.mul_add(Self::splat(0.3125), Self::splat(0.375)).mul_add(e, Self::splat(0.5));
            ((root * e).mul_add(series, root), (y * e).mul_add(series, y))
        }
        fn less(self, other: Self) -> __mmask8 {
            // SAFETY: as above.
            unsafe { _mm512_cmp_pd_mask::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __mmask8, yes: Self, no: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm512_mask_blend_pd(mask, no.0, yes.0)) }
        }
        fn bits(mask: __mmask8) -> u32 {
            u32::from(mask)
        }
        fn sum(self) -> f64 {
            // SAFETY: as above.
            unsafe { _mm512_reduce_add_pd(self.0) }
        }
        fn sum_each(vectors: &[Self; MOST_LANES]) -> Self {
            let [a, b, c, d, e, f, g, h, ..] = vectors;
            // SAFETY: as above.
            unsafe {
                let low = four_pd([half_pd(a.0), half_pd(b.0), half_pd(c.0), half_pd(d.0)]);
                let high = four_pd([half_pd(e.0), half_pd(f.0), half_pd(g.0), half_pd(h.0)]);
                Self(_mm512_insertf64x4::<1>(_mm512_castpd256_pd512(low), high))
            }
        }
        fn largest(self) -> f64 {
            // SAFETY: as above.
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
            // SAFETY: as above.
            unsafe {
                let low = F64x8::load_relative(from, origin, scale);
                let high = F64x8::load_relative(from.add(8), origin, scale);
                let (low, high) = (_mm512_cvtpd_ps(low.0), _mm512_cvtpd_ps(high.0));
                Self(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
            }
        }
        unsafe fn compress(self, mask: __mmask16, to: *mut f32) {
            // SAFETY: as above.
            unsafe { _mm512_storeu_ps(to, _mm512_maskz_compress_ps(mask, self.0)) }
        }
        fn abs(self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm512_abs_ps(self.0)) }
        }
        fn inverse(self) -> Self {
            // SAFETY: as above.
            let y = unsafe { Self(_mm512_rcp14_ps(self.0)) };
            let e = (-self).mul_add(y, Self::splat(1.0));
            y.mul_add(e, y)
        }
        fn roots(self) -> (Self, Self) {
            // SAFETY: as above.
            let y = unsafe { Self(_mm512_rsqrt14_ps(self.0)) };
            let (root, half) = (self * y, Self::splat(0.5));
            let e = (-root).mul_add(y, Self::splat(1.0));
            ((root * half).mul_add(e, root), (y * half).mul_add(e, y))
        }
        fn less(self, other: Self) -> __mmask16 {
            // SAFETY: as above.
            unsafe { _mm512_cmp_ps_mask::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __mmask16, yes: Self, no: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm512_mask_blend_ps(mask, no.0, yes.0)) }
        }
        fn bits(mask: __mmask16) -> u32 {
            u32::from(mask)
        }
        fn pair_bits(mask: __mmask16) -> u32 {
            // SAFETY: as above. `pext` is fast on every processor with AVX-512.
            unsafe { _pext_u32(u32::from(mask | mask >> 1), 0x5555) }
        }
        fn sum(self) -> f32 {
            // SAFETY: as above.
            unsafe { _mm512_reduce_add_ps(self.0) }
        }
        fn sum_each(vectors: &[Self; MOST_LANES]) -> Self {
            let [a, b, c, d, e, f, g, h, i, j, k, l, m, n, o, p] = vectors;
            // SAFETY: as above.
            unsafe {
                let (a, b, c, d) = (half_ps(a.0), half_ps(b.0), half_ps(c.0), half_ps(d.0));
                let (e, f, g, h) = (half_ps(e.0), half_ps(f.0), half_ps(g.0), half_ps(h.0));
                let (i, j, k, l) = (half_ps(i.0), half_ps(j.0), half_ps(k.0), half_ps(l.0));
                let (m, n, o, p) = (half_ps(m.0), half_ps(n.0), half_ps(o.0), half_ps(p.0));
                let (low, high) = (eight_ps([a, b, c, d, e, f, g, h]), eight_ps([i, j, k, l, m, n, o, p]));
                Self(_mm512_insertf32x8::<1>(_mm512_castps256_ps512(low), high))
            }
        }
        fn largest(self) -> f32 {
            // SAFETY: as above.
            unsafe { _mm512_reduce_max_ps(self.0) }
        }
    }
}

/// Adds the lower lanes to the upper lanes.
///
/// # Safety
/// The machine must support AVX-512 F.
#[inline(always)]
unsafe fn half_pd(v: __m512d) -> __m256d {
    // SAFETY: as above.
    unsafe { _mm256_add_pd(_mm512_castpd512_pd256(v), _mm512_extractf64x4_pd::<1>(v)) }
}

/// Adds the lower lanes to the upper lanes.
///
/// # Safety
/// The machine must support AVX-512 F and DQ.
#[inline(always)]
unsafe fn half_ps(v: __m512) -> __m256 {
    // SAFETY: as above.
    unsafe { _mm256_add_ps(_mm512_castps512_ps256(v), _mm512_extractf32x8_ps::<1>(v)) }
}
