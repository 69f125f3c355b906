//! Wendland's C2 kernel.
//!
//! ```text
//! w(q) = (1 − q/2)⁴ (2q + 1),   (dw/dq)/q = β (1 − q/2)³,   β = −5,   q < 2
//! α_2 = 7/(4π),   α_3 = 21/(16π)
//! ```
//!
//! Wendland (1995), as in Alvarado-Rodríguez et al. (2017), Eq. 15.

use std::f64::consts::PI;

use super::KernelShape;
use crate::math::lanes::Lanes;

/// Shape of Wendland's C2 kernel.
#[derive(Clone, Copy, Debug)]
pub struct Wendland;

impl KernelShape for Wendland {
    const SUPPORT: f64 = 2.0;
    const SLOPE_NORM: f64 = -5.0;

    fn norm(dimensions: usize) -> f64 {
        if dimensions == 2 { 7.0 / (4.0 * PI) } else { 21.0 / (16.0 * PI) }
    }

    #[inline(always)]
    fn value<L: Lanes>(q: L) -> L {
        let t = compact(q);
        let t2 = t * t;
        t2 * t2 * q.mul_add(L::constant(2.0), L::constant(1.0))
    }

    #[inline(always)]
    fn add_value<L: Lanes>(q: L, sum: L) -> L {
        let t = compact(q);
        let t2 = t * t;
        (t2 * t2).mul_add(q.mul_add(L::constant(2.0), L::constant(1.0)), sum)
    }

    #[inline(always)]
    fn slope<L: Lanes>(q: L, _inverse_q: L) -> L {
        let t = compact(q);
        t * t * t
    }
}

/// Returns 1 − q/2, or zero beyond the support, which truncates value and slope alike.
#[inline(always)]
fn compact<L: Lanes>(q: L) -> L {
    q.mul_add(L::constant(-0.5), L::constant(1.0)).max(L::constant(0.0))
}
