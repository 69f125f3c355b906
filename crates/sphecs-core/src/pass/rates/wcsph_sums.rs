//! Sums of a row over its neighbours under `Wcsph`, and the rates that they give.

use super::wcsph_terms::WcsphTerms;
use crate::math::lanes::{self, Lanes};
use crate::math::real::Real;
use crate::pass::fused::{FluidRow, LoopShape};
use crate::physics::shifting::vacondio::{self, RepulsionSums};

/// Sums of a row, one per lane, without the factors that all its neighbours share.
pub(super) struct WcsphSums<L: Lanes, const D: usize> {
    /// Density of the row, kg/m³.
    pub density: f64,
    /// Part of the acceleration along x_ab, over −m ∇W/(slope · x_ab/h)/ρ_a.
    pub along_x: [L; D],
    /// Part of the acceleration along v_ab, over 4 ν m ∇W/(slope · x_ab).
    pub along_v: [L; D],
    /// Shifting vector.
    pub shift: [L; D],
    /// Σ V_b W_ab over the norm of the kernel, where the drift of shifting is corrected.
    pub shift_weights: L,
    /// Divergence.
    pub divergence: L,
    /// Rate of damping.
    pub damping: L,
    /// Largest |h x_ab·v_ab/(r² + η²)|, m/s.
    pub signal: L,
    /// Sums of Vacondio's shifting.
    pub repulsion: RepulsionSums<L>,
    /// Part of `along_x` due to pressure; 0 in a loop without moments.
    pub pressure_part: [L; D],
    /// Moments of the parts along x_ab (other than pressure, which has none) and along v_ab; 0 in
    /// a loop without moments.
    pub moments: [[L; 3]; 2],
}

/// Rates of a row in SI units.
pub(super) struct WcsphRates<const D: usize> {
    pub acceleration: [f64; D],
    pub shift: [f64; D],
    pub divergence: f64,
    pub signal_speed: f64,
    pub damping: f64,
}

impl<L: Lanes, const D: usize> WcsphSums<L, D> {
    /// Returns the sums of a row of this density, kg/m³, over no neighbours.
    #[inline(always)]
    pub(super) fn none(density: f64) -> Self {
        let zero = L::constant(0.0);
        Self {
            density,
            along_x: [zero; D],
            along_v: [zero; D],
            shift: [zero; D],
            shift_weights: zero,
            divergence: zero,
            damping: zero,
            signal: zero,
            repulsion: RepulsionSums { distance: zero, neighbours: zero },
            pressure_part: [zero; D],
            moments: [[zero; 3]; 2],
        }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> WcsphTerms<'_, '_, L, S, D> {
    /// Returns the rates of a row from its sums.
    #[inline(always)]
    pub(super) fn rates(&self, sums: &WcsphSums<L, D>, row: &FluidRow<L::Real, D>) -> WcsphRates<D> {
        let density = sums.density;
        let shift = self.shift(sums, row);
        let [along_x_scale, along_v_scale] = self.acceleration_scales(density);
        let mut rates = WcsphRates {
            acceleration: [0.0; D],
            shift,
            divergence: -self.settings.gradient_scale * sums.divergence.sum().to_f64(),
            signal_speed: self.settings.pair().tait.sound_speed_at(density) + sums.signal.largest().to_f64(),
            damping: -self.settings.viscous_scale * sums.damping.sum().to_f64()
                - self.settings.own_damping / density,
        };
        for d in 0..D {
            let total = sums.along_x[d].mul_add(along_x_scale, sums.along_v[d] * along_v_scale);
            rates.acceleration[d] = total.sum().to_f64();
        }
        rates
    }

    /// Returns the shifting vector of a row.
    #[inline(always)]
    fn shift(&self, sums: &WcsphSums<L, D>, row: &FluidRow<L::Real, D>) -> [f64; D] {
        let mut shift = lanes::sums(sums.shift);
        if let Some(concentration) = self.columns().concentration {
            let weights = sums.shift_weights.sum().to_f64();
            for d in 0..D {
                let own = self.settings.source.component(concentration.gradient, d, row.row).to_f64();
                shift[d] = own - shift[d] / weights;
            }
        }
        let scale = if self.columns().concentration.is_some() {
            1.0
        } else if self.choices().repulsion {
            let RepulsionSums { distance, neighbours } = sums.repulsion;
            vacondio::scale(distance.sum().to_f64(), neighbours.sum().to_f64())
        } else {
            self.settings.gradient_scale
        };
        for component in &mut shift {
            *component *= scale;
        }
        shift
    }

    /// Returns the pressure part of the acceleration, m/s², and Σ x_ab × (acceleration by the
    /// pair), m²/s², of the sums of a loop with moments.
    #[inline(always)]
    pub(super) fn pressure_and_moment(&self, sums: &WcsphSums<L, D>) -> ([f64; D], [f64; 3]) {
        let [along_x_scale, along_v_scale] = self.acceleration_scales(sums.density);
        let (mut pressure, mut moment) = ([0.0; D], [0.0; 3]);
        for d in 0..D {
            pressure[d] = (sums.pressure_part[d] * along_x_scale).sum().to_f64();
        }
        for c in 0..3 {
            let of_pairs = sums.moments[0][c].mul_add(along_x_scale, sums.moments[1][c] * along_v_scale);
            moment[c] = self.settings.pair().discretisation.smoothing_length * of_pairs.sum().to_f64();
        }
        (pressure, moment)
    }

    /// Returns the factors of `along_x` and `along_v` of a row of this density, kg/m³.
    #[inline(always)]
    pub(super) fn acceleration_scales(&self, density: f64) -> [L; 2] {
        [L::constant(-self.settings.gradient_scale / density), L::constant(self.settings.viscous_scale)]
    }
}
