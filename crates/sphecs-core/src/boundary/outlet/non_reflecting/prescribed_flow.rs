//! Mean velocity that the prescribed inflow causes at an outlet.
//!
//! ```text
//! U(t) = s Q(t)/A                    Q volume flow of all inlets, A area of the outlet
//! s = ⟨q Q⟩/⟨Q²⟩                     share of the outlet, q its measured volume flow
//! ũ = 2 e − f,   de/dt = (U − e)/τ,  df/dt = (e − f)/τ,  τ = T/√2
//! ```
//!
//! A nearly incompressible flow leaves as it enters, so that U is known before sound has brought
//! the message. With it the outlet tells the acceleration of the flow from sound. Let plane sound
//! travel through a duct of length L with the velocity U(t) at its inlet in T = L/c0, and let the
//! incoming wave at its outlet be −½ ρ0 c0 ũ. Then the pressures are, for the frequency ω,
//!
//! ```text
//! p(outlet) = ρ0 c0 e^(−iωT) (U − ũ cos ωT)      0 for ũ = U/cos ωT
//! p(inlet)  = ρ0 c0 (U − ũ e^(−iωT))             then i ρ0 c0 U tan ωT = ρ0 L dU/dt + …
//! ```
//!
//! That is the response of a duct that ends at a given pressure. The filter has ũ = U/cos ωT up to
//! terms of the order of (ωT)³, with which p(outlet) is 0.7 (ωT)³ ρ0 c0 U. Without U the outlet
//! answers with the impedance of a long pipe, ρ0 c0, and the error is of the order of ρ0 L dU/dt.
//!
//! A pulse of the inlet that is shorter than T is sound, which must pass: the filter suppresses it.
//! It has no resonance. A filter that follows 1/cos ωT further towards its pole at a quarter
//! wavelength rings there after every start (docs/notebook/2026-11-26-openings.md).
//!
//! Of several outlets each has the share s that it has had, a regression whose means ⟨⟩ fade over
//! [`SHARE_PASSAGES`] of T. It begins with the share of the area.

use serde::{Deserialize, Serialize};

/// Time constant τ of the filter, in T.
const FILTER: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// Time over which the share of an outlet is followed, in travel times of sound T.
const SHARE_PASSAGES: f64 = 40.0;

/// State of the prescribed flow at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedFlow {
    /// Stages e and f of the filter, m/s; None before the first step.
    pub stages: Option<[f64; 2]>,
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
        let [first, second] = self.stages.get_or_insert([velocity; 2]);
        let time = FILTER * step.passage;
        let share = -(-step.time_step / time).exp_m1();
        *first += share * (velocity - *first);
        *second += share * (*first - *second);
        let acceleration = (2.0 * (velocity - *first) - (*first - *second)) / time;
        Prescribed { velocity: 2.0 * *first - *second, acceleration }
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
            // A period of 10 passages: 0.7 (ωT)³ is 0.17.
            let phase = TAU * f64::from(step) * 1e-3;
            let velocity = 0.3 + 0.1 * phase.sin();
            let found = flow.advance(&InflowStep { inflow: velocity * 0.5, ..STEP }).velocity;
            if step > 10_000 {
                let exact = 0.3 + 0.1 * phase.sin() / (TAU * 0.1).cos();
                worst = worst.max((found - exact).abs());
                largest = largest.max(found);
            }
        }
        assert!(worst < 0.02, "{worst} m/s off");
        assert!((largest - 0.4236).abs() < 0.015, "{largest} m/s");
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
