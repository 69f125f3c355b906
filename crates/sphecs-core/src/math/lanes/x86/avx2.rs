//! SIMD vectors of AVX2 with FMA.

use std::arch::x86_64::*;
use std::ops::{Add, Div, Mul, Neg, Sub};

use super::lanes;
use crate::math::lanes::{Lanes, MOST_LANES};

lanes! {
    /// Four f64 of AVX2.
    F64x4: [f64; 4] as __m256d, mask __m256d,
    _mm256_set1_pd, _mm256_loadu_pd, _mm256_storeu_pd,
    _mm256_add_pd, _mm256_sub_pd, _mm256_mul_pd, _mm256_div_pd,
    _mm256_fmadd_pd, _mm256_max_pd, _mm256_min_pd, _mm256_sqrt_pd,
    COSTLY_ROOTS = true,
    {
        unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
            // SAFETY: as above.
            unsafe { (Self::load(from) - Self::splat(origin)) * Self::splat(scale) }
        }
        unsafe fn compress(self, mask: __m256d, to: *mut f64) {
            // SAFETY: as above. A lane is moved as two halves of 32 bits.
            unsafe {
                let lanes = &COMPRESS_4[_mm256_movemask_pd(mask) as usize];
                let lanes = _mm256_loadu_si256(lanes.as_ptr().cast());
                let packed = _mm256_permutevar8x32_ps(_mm256_castpd_ps(self.0), lanes);
                _mm256_storeu_pd(to, _mm256_castps_pd(packed));
            }
        }
        fn abs(self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_andnot_pd(_mm256_set1_pd(-0.0), self.0)) }
        }
        fn inverse(self) -> Self {
            Self::splat(1.0) / self
        }
        fn roots(self) -> (Self, Self) {
            let root = self.sqrt();
            (root, Self::splat(1.0) / root)
        }
        fn less(self, other: Self) -> __m256d {
            // SAFETY: as above.
            unsafe { _mm256_cmp_pd::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __m256d, yes: Self, no: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_blendv_pd(no.0, yes.0, mask)) }
        }
        fn keep(mask: __m256d, value: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_and_pd(mask, value.0)) }
        }
        fn bits(mask: __m256d) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_pd(mask) as u32 }
        }
        fn sum(self) -> f64 {
            // SAFETY: as above.
            unsafe {
                let pair = _mm_add_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
                _mm_cvtsd_f64(_mm_add_sd(pair, _mm_unpackhi_pd(pair, pair)))
            }
        }
        fn sum_each(vectors: &[Self; MOST_LANES]) -> Self {
            let [a, b, c, d, ..] = vectors;
            // SAFETY: as above.
            unsafe { Self(four_pd([a.0, b.0, c.0, d.0])) }
        }
        fn largest(self) -> f64 {
            // SAFETY: as above.
            unsafe {
                let pair = _mm_max_pd(_mm256_castpd256_pd128(self.0), _mm256_extractf128_pd::<1>(self.0));
                _mm_cvtsd_f64(_mm_max_sd(pair, _mm_unpackhi_pd(pair, pair)))
            }
        }
    }
}

lanes! {
    /// Eight f32 of AVX2.
    F32x8: [f32; 8] as __m256, mask __m256,
    _mm256_set1_ps, _mm256_loadu_ps, _mm256_storeu_ps,
    _mm256_add_ps, _mm256_sub_ps, _mm256_mul_ps, _mm256_div_ps,
    _mm256_fmadd_ps, _mm256_max_ps, _mm256_min_ps, _mm256_sqrt_ps,
    {
        unsafe fn load_relative(from: *const f64, origin: f64, scale: f64) -> Self {
            // SAFETY: as above.
            unsafe {
                let low = F64x4::load_relative(from, origin, scale);
                let high = F64x4::load_relative(from.add(4), origin, scale);
                Self(_mm256_set_m128(_mm256_cvtpd_ps(high.0), _mm256_cvtpd_ps(low.0)))
            }
        }
        unsafe fn compress(self, mask: __m256, to: *mut f32) {
            // SAFETY: as above.
            unsafe {
                let lanes = &COMPRESS_8[_mm256_movemask_ps(mask) as usize];
                let lanes = _mm256_loadu_si256(lanes.as_ptr().cast());
                _mm256_storeu_ps(to, _mm256_permutevar8x32_ps(self.0, lanes));
            }
        }
        fn abs(self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_andnot_ps(_mm256_set1_ps(-0.0), self.0)) }
        }
        fn inverse(self) -> Self {
            Self::splat(1.0) / self
        }
        fn roots(self) -> (Self, Self) {
            // √x by its own instruction: the density pass is a quarter faster than with x times the
            // series of 1/√x. SAFETY: as above. From the 12 bits of this estimate, one term leaves
            // an error of 2⁻²³.
            let y = unsafe { Self(_mm256_rsqrt_ps(self.0)) };
            let e = (-(self * y)).mul_add(y, Self::splat(1.0));
            let series = e.mul_add(Self::splat(0.375), Self::splat(0.5));
            (self.sqrt(), (y * e).mul_add(series, y))
        }
        fn less(self, other: Self) -> __m256 {
            // SAFETY: as above.
            unsafe { _mm256_cmp_ps::<_CMP_LT_OQ>(self.0, other.0) }
        }
        fn select(mask: __m256, yes: Self, no: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_blendv_ps(no.0, yes.0, mask)) }
        }
        fn keep(mask: __m256, value: Self) -> Self {
            // SAFETY: as above.
            unsafe { Self(_mm256_and_ps(mask, value.0)) }
        }
        fn bits(mask: __m256) -> u32 {
            // SAFETY: as above.
            unsafe { _mm256_movemask_ps(mask) as u32 }
        }
        fn sum(self) -> f32 {
            // SAFETY: as above.
            unsafe {
                let four = _mm_add_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                let two = _mm_add_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_add_ss(two, _mm_movehdup_ps(two)))
            }
        }
        fn sum_each(vectors: &[Self; MOST_LANES]) -> Self {
            let [a, b, c, d, e, f, g, h, ..] = vectors;
            // SAFETY: as above.
            unsafe { Self(eight_ps([a.0, b.0, c.0, d.0, e.0, f.0, g.0, h.0])) }
        }
        fn largest(self) -> f32 {
            // SAFETY: as above.
            unsafe {
                let four = _mm_max_ps(_mm256_castps256_ps128(self.0), _mm256_extractf128_ps::<1>(self.0));
                let two = _mm_max_ps(four, _mm_movehl_ps(four, four));
                _mm_cvtss_f32(_mm_max_ss(two, _mm_movehdup_ps(two)))
            }
        }
    }
}

/// Returns the sums over the lanes of four vectors.
///
/// # Safety
/// The machine must support AVX2.
#[inline(always)]
pub(super) unsafe fn four_pd(v: [__m256d; 4]) -> __m256d {
    // SAFETY: as above. Closures are avoided: they would not be compiled for the instruction set.
    unsafe {
        let a = _mm256_add_pd(_mm256_unpacklo_pd(v[0], v[1]), _mm256_unpackhi_pd(v[0], v[1]));
        let b = _mm256_add_pd(_mm256_unpacklo_pd(v[2], v[3]), _mm256_unpackhi_pd(v[2], v[3]));
        _mm256_add_pd(_mm256_permute2f128_pd::<0x20>(a, b), _mm256_permute2f128_pd::<0x31>(a, b))
    }
}

/// Returns the sums over the lanes of eight vectors.
///
/// # Safety
/// The machine must support AVX2.
#[inline(always)]
pub(super) unsafe fn eight_ps(v: [__m256; 8]) -> __m256 {
    // SAFETY: as above.
    unsafe {
        let a = halves_ps([v[0], v[1], v[2], v[3]]);
        let b = halves_ps([v[4], v[5], v[6], v[7]]);
        _mm256_add_ps(_mm256_permute2f128_ps::<0x20>(a, b), _mm256_permute2f128_ps::<0x31>(a, b))
    }
}

/// Returns the sums over the lower and over the upper lanes of four vectors.
///
/// # Safety
/// The machine must support AVX2.
#[inline(always)]
unsafe fn halves_ps(v: [__m256; 4]) -> __m256 {
    // SAFETY: as above.
    unsafe {
        let a = _mm256_add_ps(_mm256_unpacklo_ps(v[0], v[1]), _mm256_unpackhi_ps(v[0], v[1]));
        let b = _mm256_add_ps(_mm256_unpacklo_ps(v[2], v[3]), _mm256_unpackhi_ps(v[2], v[3]));
        let (a, b) = (_mm256_castps_pd(a), _mm256_castps_pd(b));
        _mm256_add_ps(_mm256_castpd_ps(_mm256_unpacklo_pd(a, b)), _mm256_castpd_ps(_mm256_unpackhi_pd(a, b)))
    }
}

/// Lanes under each mask of eight lanes, in order.
static COMPRESS_8: [[i32; 8]; 256] = compress_table::<8, 256>(1);

/// Halves under each mask of four lanes of two halves, in order.
static COMPRESS_4: [[i32; 8]; 16] = compress_table::<4, 16>(2);

/// Returns the lanes, of `width` units of 32 bits, under each mask.
const fn compress_table<const LANES: usize, const MASKS: usize>(width: usize) -> [[i32; 8]; MASKS] {
    let mut table = [[0; 8]; MASKS];
    let mut mask = 0;
    while mask < MASKS {
        let mut lane = 0;
        let mut next = 0;
        while lane < LANES {
            if mask >> lane & 1 == 1 {
                let mut unit = 0;
                while unit < width {
                    table[mask][next] = (lane * width + unit) as i32;
                    next += 1;
                    unit += 1;
                }
            }
            lane += 1;
        }
        mask += 1;
    }
    table
}
