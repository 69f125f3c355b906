//! Shifting by the repulsion of near neighbours.
//!
//! ```text
//! δx_a = β v_max Δt r̄_a² Σ_b (m_b/M_a) x_ab/r³,   r̄_a = mean r of the neighbours, M_a = Σ m_b
//! ```
//!
//! Vacondio et al. (2013) with the local mean spacing of Xu et al. (2009), over the support. Stands for Eqs. 12–14 of
//! Alvarado-Rodríguez et al. (2017), whose units are wrong as printed and whose sums run over the whole domain.
//! Measured too weak for separated flow at β = 0.04 (see [`Fickian`](super::Shifting::Fickian)).

use crate::math::lanes::Lanes;

/// Least distance over h: nearer pairs would throw each other away, and a particle meets itself here.
const LEAST_DISTANCE: f64 = 1e-4;

/// h³/r³, to be multiplied by x_ab/h: `inverse_q` is h/r.
#[inline(always)]
pub fn repulsion<L: Lanes>(inverse_q: L) -> L {
    let inverse = inverse_q.min(L::constant(1.0 / LEAST_DISTANCE));
    inverse * inverse * inverse
}
