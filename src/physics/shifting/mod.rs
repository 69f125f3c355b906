//! Particle shifting: the door lists the rooms and holds the closed choice.
//!
//! ```text
//! Fickian: δx_a = −A h v_max Δt ∇C_a,   ∇C_a = Σ_b V_b ∇W
//! ```
//!
//! Lind et al. (2012): particles drift down the gradient of their concentration. The rate pass sums ∇C or, for
//! [`vacondio`], its repulsion; [`Shifting::displacement`] makes the step of it.

pub mod vacondio;

use serde::{Deserialize, Serialize};

/// How fluid particles are moved towards an even distribution after a step.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shifting {
    /// No shifting.
    Off,
    /// Lind et al. (2012): `δx = −coefficient h v_max Δt ∇C`.
    Fickian {
        /// Strength, dimensionless.
        #[serde(default = "fickian_coefficient")]
        coefficient: f64,
    },
    /// Vacondio et al. (2013) with the local mean spacing of Xu et al. (2009).
    Vacondio {
        /// Strength β, dimensionless.
        #[serde(default = "vacondio_coefficient")]
        beta: f64,
    },
}

fn fickian_coefficient() -> f64 {
    4.0
}

fn vacondio_coefficient() -> f64 {
    0.04
}

impl Default for Shifting {
    fn default() -> Self {
        Shifting::Fickian { coefficient: fickian_coefficient() }
    }
}

/// Longest shift in one step, over Δ.
const LONGEST: f64 = 0.1;

/// What a step's shift depends on beside the particle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShiftStep {
    /// Smoothing length h, m.
    pub smoothing_length: f64,
    /// Initial spacing Δ, m.
    pub spacing: f64,
    /// Largest speed of the fluid, m/s.
    pub largest_speed: f64,
    /// Time step, s.
    pub time_step: f64,
}

impl Shifting {
    /// Displacement of a particle, m, from the vector that the rate pass summed for it; never longer than 0.1 Δ.
    pub fn displacement<const D: usize>(&self, vector: [f64; D], step: ShiftStep) -> [f64; D] {
        let path = step.largest_speed * step.time_step;
        let scale = match *self {
            Shifting::Off => 0.0,
            Shifting::Fickian { coefficient } => -coefficient * step.smoothing_length * path,
            Shifting::Vacondio { beta } => beta * path,
        };
        let length = scale.abs() * vector.iter().map(|x| x * x).sum::<f64>().sqrt();
        let limit = LONGEST * step.spacing;
        let scale = if length > limit { scale * limit / length } else { scale };
        vector.map(|x| scale * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STEP: ShiftStep =
        ShiftStep { smoothing_length: 0.15, spacing: 0.1, largest_speed: 2.0, time_step: 1e-3 };

    #[test]
    fn particles_drift_down_the_concentration() {
        let [x, y] = Shifting::default().displacement([0.5, -1.0], STEP);
        assert!((x + 4.0 * 0.15 * 2e-3 * 0.5).abs() < 1e-15 && (y - 12e-4).abs() < 1e-15);
    }

    #[test]
    fn a_shift_is_never_longer_than_a_tenth_of_the_spacing() {
        for shifting in [Shifting::default(), Shifting::Vacondio { beta: 0.04 }] {
            let shift = shifting.displacement([3e9, -4e9, 0.0], STEP);
            assert!((shift.iter().map(|x| x * x).sum::<f64>().sqrt() - 0.01).abs() < 1e-12);
        }
        assert_eq!(Shifting::Off.displacement([1.0, 1.0], STEP), [0.0, 0.0]);
    }
}
