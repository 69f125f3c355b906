//! The fluid's mirror image in the plane of the outlet.
//!
//! ```text
//! x_k = x_o − 2 ((x_o − x_plane)·n) n,   f = v, p
//! Neumann   f_o = f_k                                zero gradient at the plane
//! Linear    f_o = f_k + (x_o − x_k)·∇f_k             Negi et al. (2020), Eq. 23, as Tafuni et al. (2018) extrapolate
//! Printed   f_o = f_k − (x_o − x_k)·∇f_k             Negi et al. (2020), Eq. 24
//! ```
//!
//! f_k and ∇f_k are fitted to the fluid alone by a linear basis (`pass/fits.rs`). Negi et al. (2020), Eq. 22, after Liu & Liu (2006),
//! take W and ∇W as test functions, the fit takes W and (x − x_k) W: both return a linear field exactly wherever the support is
//! cut, and the second matrix is symmetric.
//!
//! Eq. 24 is meant to give no gradient at the plane. It does not: f = a + b s becomes a − 3 b s beyond it, the slope turned round and
//! trebled (test `of_a_linear_field`). `Neumann` is what has none; `Linear` goes on as it is and holds nothing. The particle moves along the
//! normal with the normal velocity that it is given, and takes the other components too. No variant has an anchor for the pressure.

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::Outflow;

/// What is made of the value and the slope at the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum MirrorVariant {
    /// The value.
    #[default]
    Neumann,
    /// The value, carried on by the slope.
    Linear,
    /// The value, carried on by the slope with its sign turned.
    Printed,
}

/// Fields at an image and their slopes along the normal.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Image {
    /// Velocity, m/s.
    pub velocity: DVec3,
    /// ∂v/∂n, 1/s.
    pub velocity_slope: DVec3,
    /// Pressure, Pa.
    pub pressure: f64,
    /// ∂p/∂n, Pa/m.
    pub pressure_slope: f64,
}

impl MirrorVariant {
    /// The particle `depth` m beyond a plane of unit normal `normal`, from what is at its image.
    pub fn mirrored(self, image: Image, depth: f64, normal: DVec3) -> Outflow {
        let way = 2.0
            * depth
            * match self {
                MirrorVariant::Neumann => 0.0,
                MirrorVariant::Linear => 1.0,
                MirrorVariant::Printed => -1.0,
            };
        let velocity = image.velocity + image.velocity_slope * way;
        Outflow::moving(velocity, image.pressure + image.pressure_slope * way, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn of_a_linear_field() {
        // f = 5 + 2 s, s along the normal, at the image of s = 0.3.
        let image = Image {
            velocity: DVec3::new(0.1, 5.0 - 0.6, 0.0),
            velocity_slope: DVec3::new(0.0, 2.0, 0.0),
            pressure: 5.0 - 0.6,
            pressure_slope: 2.0,
        };
        let expected = [
            (MirrorVariant::Neumann, 5.0 - 0.6),
            (MirrorVariant::Linear, 5.0 + 0.6),
            (MirrorVariant::Printed, 5.0 - 3.0 * 0.6),
        ];
        for (variant, value) in expected {
            let outflow = variant.mirrored(image, 0.3, DVec3::Y);
            assert!((outflow.pressure - value).abs() < 1e-14, "{variant:?}: {}", outflow.pressure);
            assert!((outflow.speed - value).abs() < 1e-14, "{variant:?}: {}", outflow.speed);
            assert_eq!(outflow.velocity.x, 0.1);
        }
    }

    #[test]
    fn a_uniform_stream_is_its_own_image() {
        let image = Image { velocity: DVec3::X, pressure: -2.0, ..Image::default() };
        for variant in [MirrorVariant::Neumann, MirrorVariant::Linear, MirrorVariant::Printed] {
            let outflow = variant.mirrored(image, 0.7, DVec3::X);
            assert_eq!(outflow, Outflow { velocity: DVec3::X, pressure: -2.0, speed: 1.0 });
        }
    }
}
