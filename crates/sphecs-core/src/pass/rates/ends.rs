//! The end of a row: of what lies in the lanes, what the step asks for.

use super::layout::Layout;
use super::row::{PairLoop, Terms};
use crate::math::lanes::{self, Lanes};
use crate::math::real::Real;
use crate::pass::pack::Source;

/// What a row has summed up, lane by lane, without the factors that all its neighbours share.
pub(super) struct RowSums<L: Lanes, const D: usize> {
    /// Density of the row, kg/m³.
    pub density: f64,
    /// Of the acceleration what is to be multiplied by −m ∇W/(slope · x_ab/h)/ρ_a.
    pub along_x: [L; D],
    /// What is to be multiplied by 4 ν m ∇W/(slope · x_ab).
    pub along_v: [L; D],
    /// Shifting vector.
    pub shift: [L; D],
    /// Σ V_b W_ab/norm, where a shift carries nothing.
    pub shift_weights: L,
    /// Divergence.
    pub divergence: L,
    /// Rate of damping.
    pub damping: L,
    /// Largest |h x_ab·v_ab/(r² + η²)|, m/s.
    pub signal: L,
    /// Σ q and number of those in the support, for Vacondio's shifting.
    pub distance: L,
    pub neighbours: L,
    /// Of `along_x` what is pressure, and moments of both.
    pub pressed: [L; D],
    pub turn: [[L; 3]; 2],
}

/// The same in SI units.
pub(super) struct RowRates<const D: usize> {
    pub acceleration: [f64; D],
    pub shift: [f64; D],
    pub divergence: f64,
    pub signal_speed: f64,
    pub damping: f64,
    /// The part of the acceleration that is pressure, and Σ x_ab × (the pair's acceleration), m²/s²; 0 unless asked for.
    pub split: ([f64; D], [f64; 3]),
}

impl<L: Lanes, const D: usize> PairLoop<'_, L, D> {
    /// The rates of a row; `SPLIT`: with pressure and moment apart.
    #[inline(always)]
    pub fn end<const SPLIT: bool>(
        &self,
        sums: RowSums<L, D>,
        layout: Layout,
        terms: Terms,
        source: &Source<L::Real, D>,
        row: usize,
    ) -> RowRates<D> {
        let (pair, h, density) = (self.pair, self.pair.smoothing_length, sums.density);
        let own = |column: usize| source.columns[column - D][row];
        let mut shift = lanes::sums(sums.shift);
        if let Some(first) = layout.crowding {
            let weights = sums.shift_weights.sum().to_f64();
            for d in 0..D {
                shift[d] = own(first + d).to_f64() - shift[d] / weights;
            }
        }
        let along_x_scale = L::constant(-self.gradient_scale / density);
        let along_v_scale = L::constant(self.viscous_scale);
        let shift_scale = if layout.crowding.is_some() {
            1.0
        } else if terms.vacondio {
            // The row itself was counted, at distance zero.
            let others = (sums.neighbours.sum().to_f64() - 1.0).max(1.0);
            (sums.distance.sum().to_f64() / others).powi(2) / others
        } else {
            self.gradient_scale
        };
        let mut rates = RowRates {
            acceleration: [0.0; D],
            shift: [0.0; D],
            divergence: -self.gradient_scale * sums.divergence.sum().to_f64(),
            signal_speed: pair.tait.sound_speed_at(density) + sums.signal.largest().to_f64(),
            damping: -self.viscous_scale * sums.damping.sum().to_f64() - self.own_damping / density,
            split: ([0.0; D], [0.0; 3]),
        };
        for d in 0..D {
            let total = sums.along_x[d].mul_add(along_x_scale, sums.along_v[d] * along_v_scale);
            rates.acceleration[d] = total.sum().to_f64();
            rates.shift[d] = shift_scale * shift[d];
        }
        if SPLIT {
            for d in 0..D {
                rates.split.0[d] = (sums.pressed[d] * along_x_scale).sum().to_f64();
            }
            for c in 0..3 {
                let moment = sums.turn[0][c].mul_add(along_x_scale, sums.turn[1][c] * along_v_scale);
                rates.split.1[c] = h * moment.sum().to_f64();
            }
        }
        rates
    }
}
