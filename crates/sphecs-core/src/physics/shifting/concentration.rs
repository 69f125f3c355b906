//! Concentration gradient of the particles and its drift correction.
//!
//! ```text
//! ∇C_a = Σ_b V_b ∇W,   over all neighbours
//! corrected: s_a = ∇C_a − Σ_b V_b W_ab ∇C_b/Σ_b V_b W_ab,   b: fluid, a itself included
//! ```
//!
//! Lind et al. (2012): particles are displaced down the gradient of their concentration.
//!
//! Where a flow is stretched its lattice is, too, and ∇C contains ½ ∇·M (M = −Σ V_b x_ab ∇W, the
//! unit matrix on a lattice at rest). That part does not make the distribution more even: it is a
//! drift of the fluid as a whole, for which the velocities of a steady flow compensate
//! (docs/notebook/2026-11-23-noise.md). [`DriftCorrection::On`] subtracts the mean of the
//! neighbourhood from ∇C. A wave of wave number k is multiplied by 1 − Ŵ(k), with Ŵ the transform
//! of the kernel. So almost nothing remains of waves much longer than the support, and almost all
//! of a wave of two spacings. The correction is our own; no source has it.

use serde::{Deserialize, Serialize};

use super::ShiftStep;
use crate::math::lanes::Lanes;

/// Treatment of the part of a shift that neighbours share.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub enum DriftCorrection {
    /// The shift keeps it, and carries fluid upstream where a flow is stretched.
    /// Take it for flows that contract, which the correction weakens.
    #[default]
    Off,
    /// The mean of the neighbours' shifting vectors, weighted with V_b W_ab, is subtracted.
    /// Take it if mass must be conserved within 0.2 % downstream of a sharp edge.
    On,
}

/// Largest A v Δt/h. A shift diffuses the concentration. Above 0.71 its shortest waves on a cubic
/// lattice overshoot and grow (Wendland's kernel, 3D, h = 1.3 Δ). The limit is 0.73 in 2D and twice
/// as much for the quintic kernel (test `a_shift_is_a_stable_diffusion`).
const LARGEST_DIFFUSION: f64 = 0.6;

/// Returns the displacement over ∇C, m²: −A h v Δt, limited by the stability of the diffusion.
/// `coefficient` is A, `speed` is v in m/s.
#[inline(always)]
pub(super) fn scale(coefficient: f64, speed: f64, step: ShiftStep) -> f64 {
    let h = step.smoothing_length;
    -h * smaller(coefficient * speed * step.time_step, LARGEST_DIFFUSION * h)
}

/// Returns the smaller number as the instruction does; `f64::min` takes more for NaN.
#[inline(always)]
pub(super) fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// Adds the weight V_b W_ab and the weighted ∇C of the neighbours, of which the drift correction
/// takes the mean. `weight` is V_b w(q), `gradient` is ∇C_b.
#[inline(always)]
pub fn add_to_mean<L: Lanes, const D: usize>(weight: L, gradient: [L; D], sum: &mut [L; D], weights: &mut L) {
    *weights = *weights + weight;
    for d in 0..D {
        sum[d] = weight.mul_add(gradient[d], sum[d]);
    }
}
