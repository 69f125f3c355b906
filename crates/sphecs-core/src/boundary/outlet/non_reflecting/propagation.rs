//! A zone that carries a wave of sound on.
//!
//! ```text
//! ∂f/∂t + c0 ∂f/∂s = 0,   f = p_o, v̄_n,   s = depth in the zone
//! ```
//!
//! The pressure and the convective velocity that an outlet finds at its plane belong to the wave that is there now; deeper in the zone is
//! what came before. A zone that has the present values everywhere moves as a rigid body: it is not compressed with the
//! wave, and the density of the last rows of fluid, which is summed over it, lacks part of the wave.

use serde::{Deserialize, Serialize};

/// Pressure and velocity at the nodes of a zone, one layer of points behind the other.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Continuation {
    /// Pressure, Pa: all points of the first layer, then those of the second and so on.
    pub pressure: Vec<f64>,
    /// Convective velocity, m/s, in the same order.
    pub velocity: Vec<f64>,
}

impl Continuation {
    /// Carries the fields on by `courant` = c0 Δt/Δs layers, in parts of at most one.
    pub fn advance(&mut self, layers: usize, pressure: &[f64], velocity: &[f64], courant: f64) {
        for (field, entering) in [(&mut self.pressure, pressure), (&mut self.velocity, velocity)] {
            let points = entering.len();
            if field.len() != layers * points {
                field.clear();
                field.extend((0..layers).flat_map(|_| entering));
            }
            let parts = courant.ceil().max(1.0);
            for layer in (0..parts as usize).flat_map(|_| (0..layers).rev()) {
                for point in 0..points {
                    let before =
                        if layer == 0 { entering[point] } else { field[(layer - 1) * points + point] };
                    let here = &mut field[layer * points + point];
                    *here += courant / parts * (before - *here);
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_enters_is_a_layer_further_every_layer_of_time() {
        let mut zone = Continuation::default();
        let courant = 0.4;
        let ramp = |step: i32| courant * f64::from(step);
        for step in 0..200 {
            zone.advance(6, &[ramp(step), 7.0], &[2.0 * ramp(step), 0.0], courant);
        }
        // Behind a ramp of slope 1 per layer each layer lags by one; the first by one step less.
        for layer in 0..6 {
            let expected = ramp(199) + courant - 1.0 - layer as f64;
            assert!((zone.pressure[2 * layer] - expected).abs() < 1e-9, "{:?}", zone.pressure);
            assert!((zone.velocity[2 * layer] - 2.0 * expected).abs() < 1e-9);
            assert_eq!(zone.pressure[2 * layer + 1], 7.0, "what is steady stays");
        }
    }
}
