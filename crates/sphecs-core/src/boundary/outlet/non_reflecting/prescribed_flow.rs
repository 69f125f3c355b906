//! Mean velocity that the prescribed inflow causes at an outlet.
//!
//! ```text
//! ũ(t) = s Q̃(t)/A     Q̃ slow part of the volume flow of all inlets, A area of the outlet
//! s = ⟨q Q̃⟩/⟨Q̃²⟩      share of the outlet, q its measured volume flow
//! ```
//!
//! A nearly incompressible flow leaves as it enters, so that its velocity is known before sound has
//! brought the message. With it the outlet tells the acceleration of the flow from sound. Let plane
//! sound travel through a duct of length L with the velocity U(t) at its inlet in T = L/c0, and let
//! the incoming wave at its outlet be −½ ρ0 c0 ũ. Then the pressures are, for the frequency ω,
//!
//! ```text
//! p(outlet) = ρ0 c0 e^(−iωT) (U − ũ cos ωT)      0 for ũ = U/cos ωT
//! p(inlet)  = ρ0 c0 (U − ũ e^(−iωT))             then i ρ0 c0 U tan ωT = ρ0 L dU/dt + …
//! ```
//!
//! That is the response of a duct that ends at a given pressure, and the [slow
//! part](crate::boundary::slow_part) has ũ = U/cos ωT. Without it the outlet answers with the
//! impedance of a long pipe, ρ0 c0, and the error is of the order of ρ0 L dU/dt. A pulse of the
//! inlet that is shorter than T is sound, which must pass: it has nearly no slow part. The first
//! attempts, filters of the past, are in docs/notebook/2026-11-26-openings.md.
//!
//! Of several outlets each has the share s that it has had, a regression whose means ⟨⟩ fade over
//! 40 T. It begins with the share of the area.

use serde::{Deserialize, Serialize};

/// Time over which the share of an outlet is followed, in travel times of sound T.
const SHARE_PASSAGES: f64 = 40.0;

/// State of the prescribed flow at an outlet.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PrescribedFlow {
    /// Means ⟨q Q̃⟩ and ⟨Q̃²⟩, m⁶/s² (m⁴/s² in 2D); None before the first flow.
    pub means: Option<[f64; 2]>,
}

/// Inflow of the domain and the flow of one of its outlets in a step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct InflowStep {
    /// Slow part of the prescribed volume flow of all inlets.
    pub inflow: Inflow,
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

/// Slow part of the volume flow that all inlets prescribe.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Inflow {
    /// Volume flow Q̃, m³/s (m²/s in 2D).
    pub rate: f64,
    /// Its rate of change, m³/s² (m²/s² in 2D).
    pub acceleration: f64,
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
        let scale = self.share(step) / step.area;
        Prescribed { velocity: scale * step.inflow.rate, acceleration: scale * step.inflow.acceleration }
    }

    /// Follows and returns the share of the outlet in the inflow.
    fn share(&mut self, step: &InflowStep) -> f64 {
        if step.area_share >= 1.0 {
            return 1.0;
        }
        let (inflow, outflow) = (step.inflow.rate, step.velocity * step.area);
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

    const STEP: InflowStep = InflowStep {
        inflow: Inflow { rate: 0.0, acceleration: 0.0 },
        velocity: 0.0,
        area: 0.5,
        area_share: 1.0,
        passage: 0.1,
        time_step: 1e-3,
    };

    #[test]
    fn single_outlet_takes_the_whole_inflow() {
        let inflow = Inflow { rate: 0.1, acceleration: 0.4 };
        let found = PrescribedFlow::default().advance(&InflowStep { inflow, ..STEP });
        assert_eq!(found, Prescribed { velocity: 0.2, acceleration: 0.8 });
    }

    #[test]
    fn share_of_two_outlets_follows_the_flow() {
        let mut flow = PrescribedFlow::default();
        let mut found = 0.0;
        for step in 0..40_000 {
            let rate = 0.2 * (TAU * f64::from(step) * 1e-3 / 4.0).sin();
            let velocity = 0.3 * rate / 0.5;
            let inflow = Inflow { rate, acceleration: 0.0 };
            found = flow.advance(&InflowStep { inflow, velocity, area_share: 0.5, ..STEP }).velocity;
        }
        let [product, square] = flow.means.expect("means");
        assert!((product / square - 0.3).abs() < 0.01, "share {}", product / square);
        assert!(found.abs() < 0.01);
    }
}
