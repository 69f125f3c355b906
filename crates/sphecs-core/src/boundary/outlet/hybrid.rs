//! The base flow is kept, sound leaves by its characteristic.
//!
//! ```text
//! f̄ ← f̄ + 2/(N+1) (f − f̄)   f = v_n, p of a fluid particle, while |p − p_s| < ½ ρ0 u²; else f̄ stays
//! J2 = ρ0 c0 (v_n − v̄_n) + (p − p̄)         over the fluid, Σ V_b J2,b W_ob / Σ V_b W_ob
//! v_o = v̄_n,o + J2/(2 ρ0 c0),   p_o = p̄_o + J2/2,   v̄_o, p̄_o those of the crossing
//! ```
//!
//! Negi et al. (2020), Eqs. 28–31. Their mean is that of the last N steps, N about what sound takes from one particle to the next (Eq. 29: 4,
//! they take 6); here it is the recursive one whose values are as old in the mean, (N − 1)/2 steps: one value a particle
//! instead of N. The threshold is that of the intensity p²/(2 ρ c), Eq. 30, about a pressure p_s of the scene's: a duct whose outlet
//! is not at zero would else be sound throughout. Velocities along the plane are not averaged.
//!
//! The fluid in reach of the outlet alone has means. What comes into reach has the sound of what is there already, so that a flow which is
//! never below the threshold, as one that starts at once, keeps the base that it began with; particles in the zone that see no fluid
//! take the mean J2 of those that do, in the same step. The authors switch the sound off for twenty steps at the start: nothing here
//! needs it, since the first mean is the flow itself.
//!
//! What a pressure below the threshold leaves behind is base flow and stays: a weak tail of a strong pulse becomes an offset that nothing
//! takes away.

use serde::{Deserialize, Serialize};

use super::characteristic::References;

/// Time mean of a particle's flow: what is not sound of it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Average {
    /// Normal velocity v̄_n, m/s.
    pub velocity: f64,
    /// Pressure p̄, Pa.
    pub pressure: f64,
}

/// Share by which a mean over `steps` follows in one step.
pub fn share(steps: f64) -> f64 {
    2.0 / (steps + 1.0)
}

/// Whether a pressure (Pa, less that about which sound swings) is that of sound: not below ½ ρ0 u², density in kg/m³, velocity in m/s.
pub fn is_sound(pressure: f64, density: f64, velocity: f64) -> bool {
    pressure.abs() >= 0.5 * density * velocity * velocity
}

impl Average {
    /// The characteristics about this mean.
    pub fn references(&self) -> References {
        References { velocity: self.velocity, pressure: self.pressure }
    }

    /// Takes up a normal velocity (m/s) and a pressure (Pa) by a [`share`].
    pub fn follow(&mut self, velocity: f64, pressure: f64, share: f64) {
        self.velocity += share * (velocity - self.velocity);
        self.pressure += share * (pressure - self.pressure);
    }

    /// The mean of a flow with a normal velocity (m/s) and a pressure (Pa) that has an outgoing sound J2 (Pa).
    pub fn without_sound(velocity: f64, pressure: f64, outgoing: f64, impedance: f64) -> Self {
        Self { velocity: velocity - 0.5 * outgoing / impedance, pressure: pressure - 0.5 * outgoing }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_mean_is_as_old_as_that_of_its_steps() {
        // Behind a ramp of one a step the mean of the last six lags by 2.5.
        let mut average = Average::default();
        for step in 0..200 {
            average.follow(f64::from(step), 2.0 * f64::from(step), share(6.0));
        }
        assert!((199.0 - average.velocity - 2.5).abs() < 1e-9, "{average:?}");
        assert!((398.0 - average.pressure - 5.0).abs() < 1e-9, "{average:?}");
    }

    #[test]
    fn the_threshold_is_the_dynamic_pressure() {
        assert!(is_sound(500.0, 1000.0, 1.0) && is_sound(-501.0, 1000.0, 1.0));
        assert!(!is_sound(499.0, 1000.0, 1.0) && !is_sound(-499.0, 1000.0, 1.0));
        assert!(is_sound(0.0, 1000.0, 0.0), "whatever swings about rest is sound");
    }

    #[test]
    fn a_wave_on_a_base_flow_goes_on_as_it_is() {
        let base = Average { velocity: 0.7, pressure: -40.0 };
        let (velocity, pressure) = (0.7 + 0.02, -40.0 + 200.0);
        let outgoing = base.references().outgoing(velocity, pressure, 1e4);
        let (v, p) = base.references().at(outgoing, 1e4);
        assert!((v - velocity).abs() < 1e-14 && (p - pressure).abs() < 1e-11, "{v} {p}");
        let found = Average::without_sound(velocity, pressure, outgoing, 1e4);
        assert!((found.velocity - 0.7).abs() < 1e-14 && (found.pressure + 40.0).abs() < 1e-11, "{found:?}");
    }
}
