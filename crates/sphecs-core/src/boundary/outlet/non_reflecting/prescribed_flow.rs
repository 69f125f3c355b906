//! Mean velocity that the prescribed inflow causes at an outlet.
//!
//! ```text
//! U(t) = s Q(t)/A                            Q volume flow of all inlets, A area of the outlet
//! s = ⟨q Q⟩/⟨Q²⟩                             share of the outlet, q its measured volume flow
//! ũ = 2 e − f,   de/dt = (U − e)/τ,  df/dt = (e − f)/τ
//! ```
//!
//! A nearly incompressible flow leaves as it enters, so that U is known before sound has brought
//! the message. With it the outlet tells the acceleration of the flow from sound. In a duct of
//! length L with the velocity U(t) at its inlet, plane sound and no incoming wave about U(t) at its
//! outlet, the pressures are exactly, with T = L/c0,
//!
//! ```text
//! p(outlet) = ρ0 c0 (U(t − T) − ½ U(t − 2T) − ½ U(t)) = −½ ρ0 L T d²U/dt² + …
//! p(inlet)  = ρ0 c0 (U(t) − U(t − T))                 = ρ0 L dU/dt − …
//! ```
//!
//! The first vanishes and the second is the incompressible one for all flows that are slow against
//! T. Without U the outlet answers with the impedance of a long pipe, ρ0 c0, and the error is of
//! the order of ρ0 L dU/dt.
//!
//! A pulse of the inlet that is shorter than T is sound, which must pass. The filter ũ of second
//! order with τ = T/2 suppresses it, and neither delays a slow flow nor changes its rate.
//!
//! Of several outlets each has the share s that it has had, a regression whose means ⟨⟩ fade over
//! [`SHARE_PASSAGES`] of T. It begins with the share of the area.

use serde::{Deserialize, Serialize};

/// Time constant τ of the filter, in travel times of sound T.
const FILTER_PASSAGES: f64 = 0.5;

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

impl PrescribedFlow {
    /// Advances the flow by a step and returns the filtered velocity ũ at the outlet, m/s.
    pub fn advance(&mut self, step: &InflowStep) -> f64 {
        let velocity = self.share(step) * step.inflow / step.area;
        // A flow already in motion is not a pulse.
        let [first, second] = self.stages.get_or_insert([velocity; 2]);
        let share = -(-step.time_step / (FILTER_PASSAGES * step.passage)).exp_m1();
        *first += share * (velocity - *first);
        *second += share * (*first - *second);
        2.0 * *first - *second
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

    const STEP: InflowStep = InflowStep {
        inflow: 0.0,
        velocity: 0.0,
        area: 0.5,
        area_share: 1.0,
        passage: 0.1,
        time_step: 1e-3,
    };

    #[test]
    fn slow_flow_passes_the_filter_and_a_pulse_does_not() {
        let mut flow = PrescribedFlow::default();
        let mut worst = 0.0_f64;
        for step in 0..20_000 {
            // A period of 40 passages.
            let velocity = 0.3 + 0.1 * (TAU * f64::from(step) * 1e-3 / 4.0).sin();
            let found = flow.advance(&InflowStep { inflow: velocity * 0.5, ..STEP });
            worst = worst.max((found - velocity).abs());
        }
        assert!(worst < 0.0012, "{worst} m/s off");
        let mut flow = PrescribedFlow::default();
        let pulse = |step: i32| if (100..110).contains(&step) { 0.5 } else { 0.0 };
        let peak = (0..1000)
            .map(|step| flow.advance(&InflowStep { inflow: pulse(step) * 0.5, ..STEP }))
            .fold(0.0, f64::max);
        assert!((0.1..0.2).contains(&peak), "{peak} m/s of a pulse of 0.5 m/s and a tenth of a passage");
    }

    #[test]
    fn share_of_two_outlets_follows_the_flow() {
        let mut flow = PrescribedFlow::default();
        let mut found = 0.0;
        for step in 0..40_000 {
            let inflow = 0.2 * (TAU * f64::from(step) * 1e-3 / 4.0).sin();
            let velocity = 0.3 * inflow / 0.5;
            found = flow.advance(&InflowStep { inflow, velocity, area_share: 0.5, ..STEP });
        }
        let [product, square] = flow.means.expect("means");
        assert!((product / square - 0.3).abs() < 0.01, "share {}", product / square);
        assert!(found.abs() < 0.01);
    }
}
