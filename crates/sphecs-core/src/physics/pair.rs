//! A particle a and a vector of its neighbours b, one per lane, as the pair terms take them.
//!
//! Lengths are in units of h and the kernel is without its norm; the pair loop multiplies the sums
//! by the dimensions once per particle.

use crate::math::lanes::Lanes;
use crate::math::lattice::ETA_SQUARED;

/// Distance, relative velocity and kernel of a pair.
#[derive(Clone, Copy, Debug)]
pub struct PairGeometry<L, const D: usize> {
    /// x_ab/h = (x_a − x_b)/h.
    pub x: [L; D],
    /// v_ab = v_a − v_b, m/s.
    pub v: [L; D],
    /// q² = r²/h², slightly above 0 for the particle itself.
    pub q2: L,
    /// q = r/h.
    pub q: L,
    /// 1/q.
    pub inverse_q: L,
    /// f(q) ≤ 0, to which F = (dW/dr)/r is proportional.
    pub slope: L,
}

/// Densities of a pair and the quotients that its terms need.
#[derive(Clone, Copy, Debug)]
pub struct PairDensities<L> {
    /// ρ_a, kg/m³.
    pub own: L,
    /// ρ_a², kg²/m⁶.
    pub own_square: L,
    /// ρ_b, kg/m³.
    pub other: L,
    /// 1/ρ_b, m³/kg.
    pub inverse_other: L,
    /// 1/(ρ_a + ρ_b), m³/kg.
    pub inverse_sum: L,
    /// 1/(q² + η²/h²), η² = 0.01 h².
    pub inverse_softened_q2: L,
}

impl<L: Lanes> PairDensities<L> {
    /// Returns the quotients of a pair by one division.
    #[inline(always)]
    pub fn new(own: L, own_square: L, other: L, q2: L) -> Self {
        let sum = own + other;
        let softened = q2 + L::constant(ETA_SQUARED);
        // The product that does not depend on the distance comes first: it need not wait for it.
        let densities = sum * other;
        let inverse = (densities * softened).inverse();
        Self {
            own,
            own_square,
            other,
            inverse_softened_q2: inverse * densities,
            inverse_other: inverse * (sum * softened),
            inverse_sum: inverse * (softened * other),
        }
    }
}
