//! Mean velocity that the prescribed inflow causes at an outlet.
//!
//! ```text
//! U(t) = s Q(t)/A                    Q volume flow of all inlets, A area of the outlet
//! s = ⟨q Q⟩/⟨Q²⟩                     share of the outlet, q its measured volume flow
//! ũ = D w,   w = 2 U − D ũ           D delays a slow signal by T = L/c0
//! D: 15 y + 15 T dy/dt + 6 T² d²y/dt² + T³ d³y/dt³ = 15 x
//! ```
//!
//! A nearly incompressible flow leaves as it enters, so that U is known before sound has brought
//! the message. With it the outlet tells the acceleration of the flow from sound. Let plane sound
//! travel through a duct of length L with the velocity U(t) at its inlet, and let the incoming wave
//! at its outlet be −½ ρ0 c0 ũ. Then the pressures are, for the frequency ω,
//!
//! ```text
//! p(outlet) = ρ0 c0 e^(−iωT) (U − ũ cos ωT)      0 for ũ = U/cos ωT
//! p(inlet)  = ρ0 c0 (U − ũ e^(−iωT))             then i ρ0 c0 U tan ωT = ρ0 L dU/dt + …
//! ```
//!
//! That is the response of a duct that ends at a given pressure. With an exact delay, ũ = D w would
//! be U/cos ωT, and resonate at a quarter wavelength. A Bessel filter of third order (Thomson 1949)
//! in its place is exact up to the terms with (ωT)², damps the resonance and suppresses what is
//! shorter than T: a pulse of the inlet is sound, which must pass. Without U the outlet answers with
//! the impedance of a long pipe, ρ0 c0, and the error is of the order of ρ0 L dU/dt.
//!
//! Of several outlets each has the share s that it has had, a regression whose means ⟨⟩ fade over
//! [`SHARE_PASSAGES`] of T. It begins with the share of the area.

use serde::{Deserialize, Serialize};

/// Time over which the share of an outlet is followed, in travel times of sound T.
const SHARE_PASSAGES: f64 = 40.0;

/// State of the prescribed flow at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedFlow {
    /// Delayed signals ũ = D w and D ũ, each with its first two derivatives, in m/s and units of T;
    /// None before the first step.
    pub delayed: Option<[[f64; 3]; 2]>,
    /// Means ⟨q Q⟩ and ⟨Q²⟩, m⁶/s² (m⁴/s² in 2D); None before the first flow.
    pub means: Option<[f64; 2]>,
}

/// Inflow of the domain and the flow of one of its outlets in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InflowStep {
    /// Prescribed volume flow Q of all inlets, m³/s (m²/s in 2D).
    pub inflow: f64,
    /// Measured mean velocity at the outlet, m/s.
    pub velocity: f64,
    /// Area A of the outlet, m² (m in 2D).
    pub area: f64,
    /// Area of the outlet over that of all outlets.
    pub area_share: f64,
    /// Travel time T of sound between the openings, s.
    pub passage: f64,
    /// Time step, s.
    pub time_step: f64,
}

/// Velocity ũ that the inflow causes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Prescribed {
    /// Velocity, m/s.
    pub velocity: f64,
    /// Rate of the velocity, m/s².
    pub acceleration: f64,
}

impl PrescribedFlow {
    /// Advances the flow by a step and returns the velocity ũ at the outlet with its rate.
    pub fn advance(&mut self, step: &InflowStep) -> Prescribed {
        let velocity = self.share(step) * step.inflow / step.area;
        // A flow already in motion is not a pulse.
        let delayed = self.delayed.get_or_insert([[velocity, 0.0, 0.0]; 2]);
        // The midpoint rule in time over T, in parts that are short against the filter.
        let time = step.time_step / step.passage;
        let parts = (time / LONGEST_PART).ceil().max(1.0);
        let part = time / parts;
        for _ in 0..parts as usize {
            let middle = moved(delayed, &rates(delayed, velocity), 0.5 * part);
            *delayed = moved(delayed, &rates(&middle, velocity), part);
        }
        Prescribed { velocity: delayed[0][0], acceleration: delayed[0][1] / step.passage }
    }

    /// Follows and returns the share of the outlet in the inflow.
    fn share(&mut self, step: &InflowStep) -> f64 {
        if step.area_share >= 1.0 {
            return 1.0;
        }
        let (inflow, outflow) = (step.inflow, step.velocity * step.area);
        let square = inflow * inflow;
        if self.means.is_none() && square == 0.0 {
            return step.area_share;
        }
        let [product, of_square] = self.means.get_or_insert([step.area_share * square, square]);
        let fade = -(-step.time_step / (SHARE_PASSAGES * step.passage)).exp_m1();
        *product += fade * (outflow * inflow - *product);
        *of_square += fade * (square - *of_square);
        // A regression that is still uncertain may exceed what an outlet can take.
        if *of_square > 0.0 { (*product / *of_square).clamp(-1.0, 2.0) } else { step.area_share }
    }
}

/// Longest part of a step, in T: the fastest rate of the filters is about 3/T.
const LONGEST_PART: f64 = 0.1;

/// Returns the rates of the delayed signals for a velocity U, m/s, in units of T.
fn rates([own, fed_back]: &[[f64; 3]; 2], velocity: f64) -> [[f64; 3]; 2] {
    let filter = |[y, first, second]: &[f64; 3], input: f64| {
        [*first, *second, 15.0 * (input - y) - 15.0 * first - 6.0 * second]
    };
    [filter(own, 2.0 * velocity - fed_back[0]), filter(fed_back, own[0])]
}

/// Returns signals moved by their rates over a time in T.
fn moved(signals: &[[f64; 3]; 2], rates: &[[f64; 3]; 2], time: f64) -> [[f64; 3]; 2] {
    std::array::from_fn(|filter| std::array::from_fn(|at| signals[filter][at] + time * rates[filter][at]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    const STEP: InflowStep =
        InflowStep { inflow: 0.0, velocity: 0.0, area: 0.5, area_share: 1.0, passage: 0.1, time_step: 1e-3 };

    #[test]
    fn slow_flow_is_raised_as_in_a_duct_of_given_pressure() {
        let mut flow = PrescribedFlow::default();
        let (mut worst, mut largest) = (0.0_f64, 0.0_f64);
        for step in 0..20_000 {
            // A period of 10 passages.
            let phase = TAU * f64::from(step) * 1e-3;
            let velocity = 0.3 + 0.1 * phase.sin();
            let found = flow.advance(&InflowStep { inflow: velocity * 0.5, ..STEP }).velocity;
            if step > 10_000 {
                let exact = 0.3 + 0.1 * phase.sin() / (TAU * 0.1).cos();
                worst = worst.max((found - exact).abs());
                largest = largest.max(found);
            }
        }
        assert!(worst < 0.006, "{worst} m/s off");
        assert!((largest - 0.4236).abs() < 0.005, "{largest} m/s");
    }

    #[test]
    fn short_pulse_is_suppressed() {
        let mut flow = PrescribedFlow::default();
        let pulse = |step: i32| if (100..110).contains(&step) { 0.5 } else { 0.0 };
        let found: Vec<f64> = (0..5000)
            .map(|step| flow.advance(&InflowStep { inflow: pulse(step) * 0.5, ..STEP }).velocity)
            .collect();
        let peak = found.iter().copied().fold(0.0, f64::max);
        assert!((0.05..0.2).contains(&peak), "{peak} m/s of a pulse of 0.5 m/s and a tenth of a passage");
        assert!(found[4000..].iter().all(|velocity| velocity.abs() < 1e-3));
    }

    #[test]
    fn steady_flow_is_unchanged() {
        let mut flow = PrescribedFlow::default();
        let found = (0..100).map(|_| flow.advance(&InflowStep { inflow: 0.1, ..STEP }).velocity).last();
        assert_eq!(found, Some(0.2));
    }

    #[test]
    fn share_of_two_outlets_follows_the_flow() {
        let mut flow = PrescribedFlow::default();
        let mut found = 0.0;
        for step in 0..40_000 {
            let inflow = 0.2 * (TAU * f64::from(step) * 1e-3 / 4.0).sin();
            let velocity = 0.3 * inflow / 0.5;
            found = flow.advance(&InflowStep { inflow, velocity, area_share: 0.5, ..STEP }).velocity;
        }
        let [product, square] = flow.means.expect("means");
        assert!((product / square - 0.3).abs() < 0.01, "share {}", product / square);
        assert!(found.abs() < 0.01);
    }
}
