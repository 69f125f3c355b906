//! Shifting by the repulsion of near neighbours.
//!
//! ```text
//! δx_a = β v_max Δt r̄_a² Σ_b (m_b/M_a) x_ab/r³,   r̄_a = mean r of the neighbours, M_a = Σ m_b
//! ```
//!
//! Vacondio et al. (2013) with the local mean spacing of Xu et al. (2009), over the support. Stands
//! for Eqs. 12–14 of Alvarado-Rodríguez et al. (2017), whose units are wrong as printed and whose
//! sums run over the whole domain. Measured too weak for separated flow at β = 0.04 (compare
//! [`fickian`](super::fickian)).

use serde::{Deserialize, Serialize};

use super::{ShiftStep, ShiftingMethod, ShiftingNeeds};
use crate::math::lanes::Lanes;

/// Parameter of the method.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Vacondio {
    /// Strength β, dimensionless.
    #[serde(default = "usual_beta")]
    pub beta: f64,
}

fn usual_beta() -> f64 {
    0.04
}

impl Default for Vacondio {
    fn default() -> Self {
        Self { beta: usual_beta() }
    }
}

impl ShiftingMethod for Vacondio {
    fn strength(&self) -> f64 {
        self.beta
    }

    fn strength_field(&self) -> &'static str {
        "beta"
    }

    fn needs(&self) -> ShiftingNeeds {
        ShiftingNeeds { repulsion: true, ..ShiftingNeeds::default() }
    }

    #[inline(always)]
    fn scales(&self, squared_speeds: &mut [f64], step: ShiftStep) {
        squared_speeds.fill(self.beta * step.largest_speed * step.time_step);
    }
}

/// Least distance over h: closer pairs would repel each other without bound, and a particle is its
/// own neighbour here.
const LEAST_DISTANCE: f64 = 1e-4;

/// Sums that the repulsion is divided by.
#[derive(Clone, Copy, Debug)]
pub struct RepulsionSums<L> {
    /// Σ q over the neighbours in the support.
    pub distance: L,
    /// Number of neighbours in the support, the particle itself included.
    pub neighbours: L,
}

/// Returns h³/r³ in the support and 0 outside, to be multiplied by x_ab/h, and counts the
/// neighbours. `q` is r/h and `inverse_q` is h/r.
#[inline(always)]
pub fn pair_term<L: Lanes>(in_support: L::Mask, q: L, inverse_q: L, sums: &mut RepulsionSums<L>) -> L {
    let (zero, one) = (L::constant(0.0), L::constant(1.0));
    sums.distance = sums.distance + L::select(in_support, q, zero);
    sums.neighbours = sums.neighbours + L::select(in_support, one, zero);
    L::select(in_support, repulsion(inverse_q), zero)
}

/// Returns h³/r³, to be multiplied by x_ab/h: `inverse_q` is h/r.
#[inline(always)]
fn repulsion<L: Lanes>(inverse_q: L) -> L {
    let inverse = inverse_q.min(L::constant(1.0 / LEAST_DISTANCE));
    inverse * inverse * inverse
}

/// Returns r̄²/N, dimensionless, by which the repulsion of a particle is multiplied, from Σ q and
/// the number of neighbours, the particle itself included.
pub fn scale(distance: f64, neighbours: f64) -> f64 {
    // The particle itself was counted, at distance zero.
    let others = (neighbours - 1.0).max(1.0);
    (distance / others).powi(2) / others
}
