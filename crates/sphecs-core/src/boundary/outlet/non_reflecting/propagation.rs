//! Propagation of an acoustic wave through an outflow zone.
//!
//! ```text
//! ∂f/∂t + c0 ∂f/∂s = 0,   f = p_o, v̄_n,   s = depth in the zone
//! ```
//!
//! Pressure and convective velocity at the plane belong to the present wave; deeper in the zone
//! they belong to earlier times. A zone with the present values everywhere would move as a rigid
//! body. The wave would not compress it, and the summed density of the last layers of fluid would
//! lack part of the wave.

use serde::{Deserialize, Serialize};

/// Pressure and velocity at the nodes of a zone, in layers of section points.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Propagation {
    /// Pressure, Pa, in the order of layers and, within a layer, of points.
    pub pressure: Vec<f64>,
    /// Convective velocity, m/s, in the same order.
    pub velocity: Vec<f64>,
}

impl Propagation {
    /// Advects the fields by `courant` = c0 Δt/Δs layers, in parts of at most one, from the values
    /// at the plane.
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
    fn a_wave_propagates_one_layer_per_travel_time() {
        let mut zone = Propagation::default();
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
            assert_eq!(zone.pressure[2 * layer + 1], 7.0, "a steady value stays");
        }
    }
}
