//! Sums of a row over its neighbours under `EdacTvf`, and the rates that they give.

use super::edac_terms::EdacTerms;
use crate::math::lanes::{self, Lanes};
use crate::math::real::Real;
use crate::pass::fused::{FluidRow, LoopShape};

/// Sums of a row, one per lane, without the factors that all its neighbours share.
pub(super) struct EdacSums<L: Lanes, const D: usize> {
    /// Part of the acceleration by pressure and by the neighbours' half of the transport stress.
    pub along_x: [L; D],
    /// Part of the acceleration along v_ab.
    pub along_v: [L; D],
    /// Σ S_ab ∇W, of the background pressure.
    pub background: [L; D],
    /// Divergence.
    pub divergence: L,
    /// Diffusion of the pressure.
    pub diffusion: L,
    /// Rate of damping.
    pub damping: L,
    /// Σ (p_b − p_a) in the support, Pa, and the number of its terms.
    pub differences: L,
    pub neighbours: L,
    /// Part of `along_x` due to pressure; 0 in a loop without moments.
    pub pressure_part: [L; D],
    /// Moments of the neighbours' half of the transport stress, of the viscous term and of the
    /// particle's own half of the stress; 0 in a loop without moments.
    pub moments: [[L; 3]; 3],
}

/// Rates of a row in SI units.
pub(super) struct EdacRates<const D: usize> {
    pub acceleration: [f64; D],
    pub background: [f64; D],
    pub pressure_rate: f64,
    pub divergence: f64,
    pub damping: f64,
    /// Part of the acceleration due to pressure, m/s²; without meaning in a loop without moments.
    pub pressure_part: [f64; D],
}

impl<L: Lanes, const D: usize> EdacSums<L, D> {
    /// Returns sums over no neighbours.
    #[inline(always)]
    pub(super) fn none() -> Self {
        let zero = L::constant(0.0);
        Self {
            along_x: [zero; D],
            along_v: [zero; D],
            background: [zero; D],
            divergence: zero,
            diffusion: zero,
            damping: zero,
            differences: zero,
            neighbours: zero,
            pressure_part: [zero; D],
            moments: [[zero; 3]; 3],
        }
    }
}

impl<L: Lanes, S: LoopShape, const D: usize> EdacTerms<'_, '_, L, S, D> {
    /// Returns the rates of a row from its sums.
    #[inline(always)]
    pub(super) fn rates(&self, sums: &EdacSums<L, D>, row: &FluidRow<L::Real, D>) -> EdacRates<D> {
        let (settings, columns) = (self.settings, self.columns());
        let (pair, edac, source) = (settings.pair(), settings.edac, settings.source);
        let density = source.scalar(columns.density, row.row).to_f64();
        let pressure = source.scalar(columns.pressure, row.row).to_f64();
        let (h, reference) = (pair.discretisation.smoothing_length, pair.tait.reference_density);
        // Weights are of volumes over masses: V²/m ∇W is m ∇W times them.
        let scale = settings.gradient_scale;
        let [nu, nu_of_pressure] = self.viscous_scales(density);
        let squared_speed = pair.tait.sound_speed * pair.tait.sound_speed;
        let push = lanes::sums(sums.background);
        let drift: [f64; D] = std::array::from_fn(|d| source.component(columns.drift, d, row.row).to_f64());
        let drift_along: f64 = drift.iter().zip(push).map(|(w, push)| w * push).sum();
        // p̄_a − p_a, or −p_a where no mean is subtracted.
        let mean = if edac.average_pressure {
            sums.differences.sum().to_f64() / sums.neighbours.sum().to_f64()
        } else {
            -pressure
        };
        let [along_x_scale, along_v_scale] = [L::constant(-density * scale), L::constant(nu)];
        let background = edac.background * reference * squared_speed;
        let inflow = scale * sums.divergence.sum().to_f64();
        let diffusion = -nu_of_pressure * sums.diffusion.sum().to_f64();
        let relaxing = edac.relaxing(h, pair.tait.sound_speed, density - reference, pressure);
        let mut rates = EdacRates {
            acceleration: [0.0; D],
            background: push.map(|push| -background * scale * push),
            pressure_rate: density * squared_speed * inflow + diffusion + relaxing,
            divergence: -inflow,
            damping: -nu.min(nu_of_pressure) * sums.damping.sum().to_f64() - settings.own_damping / density
                + edac.relaxation * pair.tait.sound_speed / h,
            pressure_part: [0.0; D],
        };
        for d in 0..D {
            let total = sums.along_x[d].mul_add(along_x_scale, sums.along_v[d] * along_v_scale);
            let velocity = source.component(columns.velocity, d, row.row).to_f64();
            let carried = 0.5 * density * velocity * drift_along;
            rates.acceleration[d] = total.sum().to_f64() + scale * (mean * push[d] + carried);
            if S::WITH_MOMENTS {
                let of_pairs = (sums.pressure_part[d] * along_x_scale).sum().to_f64();
                rates.pressure_part[d] = of_pairs + scale * mean * push[d];
            }
        }
        rates
    }

    /// Returns Σ x_ab × (acceleration by the pair), m²/s², of the sums of a loop with moments.
    #[inline(always)]
    pub(super) fn moment(&self, sums: &EdacSums<L, D>, row: usize) -> [f64; 3] {
        let density = self.settings.source.scalar(self.columns().density, row).to_f64();
        let scale = self.settings.gradient_scale;
        let (along_x_scale, along_v_scale) =
            (L::constant(-density * scale), L::constant(self.viscous_scales(density)[0]));
        let own_half = L::constant(0.5 * density * scale);
        let mut moment = [0.0; 3];
        for c in 0..3 {
            let of_pairs = sums.moments[0][c].mul_add(along_x_scale, sums.moments[1][c] * along_v_scale);
            let whole = sums.moments[2][c].mul_add(own_half, of_pairs);
            moment[c] = self.settings.pair().discretisation.smoothing_length * whole.sum().to_f64();
        }
        moment
    }

    /// Returns the factors of the viscous sums of velocity and pressure at a density, kg/m³.
    #[inline(always)]
    fn viscous_scales(&self, density: f64) -> [f64; 2] {
        let (scale, h) = (self.settings.gradient_scale, self.settings.pair().discretisation.smoothing_length);
        self.settings.viscosity.map(|nu| 2.0 * nu * density * scale / h)
    }
}
