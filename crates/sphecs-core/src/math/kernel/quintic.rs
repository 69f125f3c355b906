//! Quintic spline.
//!
//! ```text
//! w(q) = (3 − q)₊⁵ − 6 (2 − q)₊⁵ + 15 (1 − q)₊⁵
//! (dw/dq)/q = β [(3 − q)₊⁴ − 6 (2 − q)₊⁴]/q   for q ≥ 1,   β = −5
//!           = β [24 − 24 q² + 10 q³]          for q < 1
//! α_2 = 7/(478π),   α_3 = 1/(120π)
//! ```
//!
//! As in Negi et al. (2020), Eq. 5. Below q = 1 the three fourth powers are multiplied out. Their
//! sum is proportional to q at small q, and dividing the rounded sum by q would lose all digits in
//! single precision.

use std::f64::consts::PI;

use super::KernelShape;
use crate::math::lanes::Lanes;

/// Shape of the quintic spline.
#[derive(Clone, Copy, Debug)]
pub struct Quintic;

impl KernelShape for Quintic {
    const SUPPORT: f64 = 3.0;
    const SLOPE_NORM: f64 = -5.0;
    const COSTLY_VALUE: bool = true;

    fn norm(dimensions: usize) -> f64 {
        if dimensions == 2 { 7.0 / (478.0 * PI) } else { 1.0 / (120.0 * PI) }
    }

    #[inline(always)]
    fn value<L: Lanes>(q: L) -> L {
        let fifth = |edge: f64| {
            let t = (L::constant(edge) - q).max(L::constant(0.0));
            let t2 = t * t;
            t2 * t2 * t
        };
        fifth(1.0).mul_add(L::constant(15.0), fifth(2.0).mul_add(L::constant(-6.0), fifth(3.0)))
    }

    #[inline(always)]
    fn slope<L: Lanes>(q: L, inverse_q: L) -> L {
        let fourth = |edge: f64| {
            let t = (L::constant(edge) - q).max(L::constant(0.0));
            let t2 = t * t;
            t2 * t2
        };
        let outer = fourth(2.0).mul_add(L::constant(-6.0), fourth(3.0)) * inverse_q;
        let inner = (q * q).mul_add(q.mul_add(L::constant(10.0), L::constant(-24.0)), L::constant(24.0));
        L::select(q.less(L::constant(1.0)), inner, outer)
    }
}
