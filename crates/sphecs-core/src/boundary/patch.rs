//! Plane openings of the domain.

use std::sync::Arc;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use super::section_raster::SectionRaster;

/// Parts of the domain's end that belong to an opening.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub enum Extent {
    /// The connected part that contains `at`. Take it unless one opening has several parts.
    #[default]
    Connected,
    /// All parts of the end in the plane. Take it where a plate, a body or a wall divides the
    /// opening.
    Whole,
}

/// A plane opening of the domain with its zone of inflow or outflow particles.
#[derive(Clone, Debug)]
pub struct Patch {
    /// Name for outputs and messages.
    pub name: String,
    /// Centre of the bounding rectangle of the section, m; outside the section of a ring.
    pub at: DVec3,
    /// Unit normal in the direction of the flow (into the domain for an inlet, out of it for an
    /// outlet).
    pub towards: DVec3,
    /// Unit vectors that span the plane; the second is zero in 2D.
    pub across: [DVec3; 2],
    /// Half extents along `across` of the bounding rectangle of the section about `at`, m.
    pub half_extent: [f64; 2],
    /// Length of its zone, m, ≥ the kernel's support.
    pub depth: f64,
    /// Area of the section, m² (length in m in 2D).
    pub area: f64,
    /// Wetted perimeter of the section, m; in 2D the number of its edges at walls.
    pub perimeter: f64,
    /// Section in its bounding rectangle; None if it is the whole rectangle.
    pub raster: Option<Arc<SectionRaster>>,
}

impl Patch {
    /// Returns the signed distance of a point from the plane along the flow, m.
    pub fn along(&self, point: DVec3) -> f64 {
        (point - self.at).dot(self.towards)
    }

    /// Returns the mirror image of a point (m) in the plane, m.
    pub fn mirrored(&self, point: DVec3) -> DVec3 {
        point - self.towards * (2.0 * self.along(point))
    }

    /// Returns true if the projection of a point onto the plane lies in the section widened by
    /// `margin`, m.
    pub fn covers(&self, point: DVec3, margin: f64) -> bool {
        let offset = self.across.map(|across| (point - self.at).dot(across));
        let is_in_rectangle = (0..2).all(|side| offset[side].abs() <= self.half_extent[side] + margin);
        is_in_rectangle && self.raster.as_ref().is_none_or(|raster| raster.distance(offset) <= margin)
    }

    /// Returns four times the area over the wetted perimeter, m: the diameter of a disc, twice the
    /// distance of plates.
    pub fn hydraulic_diameter(&self) -> f64 {
        4.0 * self.area / self.perimeter
    }
}

/// Returns a patch of a channel, 0.162 m wide and rotated by an angle, for tests.
#[cfg(test)]
pub(super) fn turned_patch(angle: f64) -> Patch {
    let (s, c) = angle.sin_cos();
    Patch {
        name: "inlet".to_owned(),
        at: DVec3::new(0.3, -0.2, 0.0),
        towards: DVec3::new(c, s, 0.0),
        across: [DVec3::new(-s, c, 0.0), DVec3::ZERO],
        half_extent: [0.081, 0.0],
        depth: 0.05,
        area: 0.162,
        perimeter: 2.0,
        raster: None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mirror_image_is_at_the_same_distance_on_the_other_side() {
        let patch = turned_patch(0.3);
        let point = patch.at + patch.towards * 0.02 + patch.across[0] * 0.01;
        let image = patch.mirrored(point);
        assert!((patch.along(image) + 0.02).abs() < 1e-15);
        assert!(image.distance(patch.at - patch.towards * 0.02 + patch.across[0] * 0.01) < 1e-15);
    }
}
