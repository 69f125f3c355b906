//! Mirror image of the fluid in the plane of the outlet.
//!
//! ```text
//! x_k = x_o − 2 ((x_o − x_plane)·n) n,   f = v, p
//! Neumann   f_o = f_k                                zero gradient at the plane
//! Linear    f_o = f_k + (x_o − x_k)·∇f_k             Eq. 23, as Tafuni et al. (2018) extrapolate
//! Printed   f_o = f_k − (x_o − x_k)·∇f_k             Eq. 24
//! ```
//!
//! The equation numbers are those of Negi et al. (2020).
//!
//! f_k and ∇f_k are fitted to the fluid alone by a linear basis (`pass/fits.rs`). Negi et al.
//! (2020), Eq. 22, after Liu & Liu (2006), take W and ∇W as test functions, the fit takes W and (x
//! − x_k) W. Both are exact for a linear field wherever the support is cut, and the second matrix
//! is symmetric.
//!
//! Eq. 24 is meant to have no gradient at the plane, but has one. The field f = a + b s becomes a −
//! 3 b s beyond the plane, with the slope reversed and trebled (test
//! `a_linear_field_is_continued_by_each_variant`). `Neumann` has no gradient; `Linear` continues
//! the field and anchors nothing. A particle moves along the normal with the extrapolated normal
//! velocity, and takes the other components too. No variant anchors the pressure.

use std::iter::empty;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::do_nothing::frozen;
use super::method::{OutflowState, OutletMethod, OutletParameters};
use super::outflow_zone::OutflowZone;
use crate::pass::fits::{Image, PointFit};
use crate::pass::pair_real::PairReal;

/// Parameters of the condition.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Mirror {
    /// Continuation of value and slope at the image.
    #[serde(default)]
    pub variant: MirrorVariant,
}

/// Continuation of value and slope at the image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum MirrorVariant {
    /// The value of the fluid at the image. Take it unless variants are compared.
    #[default]
    Neumann,
    /// The value at the image, extrapolated by the slope. Take it to compare variants.
    Linear,
    /// The value at the image, extrapolated by the reversed slope, as published. Take it to compare
    /// with published results.
    Printed,
}

impl OutletParameters for Mirror {
    fn name(&self) -> &str {
        "Mirror"
    }
}

impl OutletMethod for Mirror {
    type Memory = ();

    /// Sets each particle from its image; one whose image is not in the fluid keeps its state.
    fn apply<R: PairReal<D>, const D: usize>(&self, zone: &mut OutflowZone<'_, R, D>, _memory: &mut ()) {
        let (normal, patch) = (zone.normal(), zone.patch);
        zone.fit_fluid(PointFit::Image { normal }, |point| patch.mirrored(point), empty());
        for (at, &row) in zone.rows.iter().enumerate() {
            let row = row as usize;
            let depth = patch.along(zone.position(row));
            let state = match zone.fitted()[at] {
                Some(flow) => self.variant.mirrored(flow.image, depth, normal),
                None => {
                    let (velocity, pressure) = zone.state(row);
                    frozen(velocity, pressure, normal)
                }
            };
            zone.set(row, state);
        }
    }
}

impl MirrorVariant {
    /// Returns the state of a particle `depth` m beyond a plane of unit normal `normal`, from the
    /// fields at its image.
    pub fn mirrored(self, image: Image, depth: f64, normal: DVec3) -> OutflowState {
        let way = 2.0
            * depth
            * match self {
                MirrorVariant::Neumann => 0.0,
                MirrorVariant::Linear => 1.0,
                MirrorVariant::Printed => -1.0,
            };
        let velocity = image.velocity + image.velocity_slope * way;
        OutflowState::moving(velocity, image.pressure + image.pressure_slope * way, normal)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_linear_field_is_continued_by_each_variant() {
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
            let state = variant.mirrored(image, 0.3, DVec3::Y);
            assert!((state.pressure - value).abs() < 1e-14, "{variant:?}: {}", state.pressure);
            assert!((state.speed - value).abs() < 1e-14, "{variant:?}: {}", state.speed);
            assert_eq!(state.velocity.x, 0.1);
        }
    }

    #[test]
    fn a_uniform_stream_is_its_own_image() {
        let image = Image { velocity: DVec3::X, pressure: -2.0, ..Image::default() };
        for variant in [MirrorVariant::Neumann, MirrorVariant::Linear, MirrorVariant::Printed] {
            let state = variant.mirrored(image, 0.7, DVec3::X);
            assert_eq!(state, OutflowState { velocity: DVec3::X, pressure: -2.0, speed: 1.0 });
        }
    }
}
