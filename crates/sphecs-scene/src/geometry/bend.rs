//! A section swept along an arc, as the elbow of a pipe.
//!
//! In the arc's own coordinates (distance ρ from its axis, height ζ along it, angle θ) the section
//! is a circle or rectangle about ρ = R, ζ = 0. Between the ends the nearest point has the same θ,
//! beyond them it lies on the nearer end: exact outside for arcs of up to 180°.

use glam::DVec3;

use super::primitives::corner;

/// Section of a bend, relative to the centre line of the arc.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BendSection {
    /// Circle of a radius, m.
    Circular(f64),
    /// Rectangle with its half width along the radius of the arc and its half height along the
    /// axis, m.
    Rectangular(f64, f64),
}

impl BendSection {
    /// Returns the signed distance in the plane of the section, m.
    fn signed_distance(self, radial: f64, height: f64) -> f64 {
        match self {
            BendSection::Circular(radius) => radial.hypot(height) - radius,
            BendSection::Rectangular(half_width, half_height) => {
                corner(radial.abs() - half_width, height.abs() - half_height)
            }
        }
    }

    /// Returns half the width along the radius of the arc, m.
    pub fn half_width(self) -> f64 {
        match self {
            BendSection::Circular(radius) => radius,
            BendSection::Rectangular(half_width, _) => half_width,
        }
    }

    /// Returns half the height along the axis of the arc, m.
    pub fn half_height(self) -> f64 {
        match self {
            BendSection::Circular(radius) => radius,
            BendSection::Rectangular(_, half_height) => half_height,
        }
    }
}

/// A section swept along an arc.
#[derive(Clone, Debug)]
pub struct Bend {
    /// Centre of the arc, m.
    pub center: DVec3,
    /// Unit vector from the centre to the beginning of the arc.
    pub outwards: DVec3,
    /// Unit vector along the pipe at the beginning.
    pub direction: DVec3,
    /// Radius of the arc, m.
    pub radius: f64,
    /// Angle turned through, rad, in (0, π].
    pub angle: f64,
    /// Section.
    pub section: BendSection,
}

impl Bend {
    /// Returns the signed distance, m.
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        let offset = point - self.center;
        let axis = self.outwards.cross(self.direction);
        let height = offset.dot(axis);
        let (x, y) = (offset.dot(self.outwards), offset.dot(self.direction));
        let (sin, cos) = self.angle.sin_cos();
        // Distances beyond the two end planes, and radial distances measured in those planes.
        let (before, at_start) = (-y, x);
        let (after, at_end) = (y * cos - x * sin, x * cos + y * sin);
        let angle = y.atan2(x);
        let within = if angle < -1e-12 && self.angle < std::f64::consts::PI {
            false
        } else {
            (-1e-12..=self.angle).contains(&angle)
        };
        if within {
            let section = self.section.signed_distance(x.hypot(y) - self.radius, height);
            let end = |beyond: f64, in_plane: f64| {
                if in_plane > 0.0 { beyond } else { f64::NEG_INFINITY }
            };
            let ends = end(before, at_start).max(end(after, at_end));
            return if section > 0.0 { section } else { section.max(ends) };
        }
        let beyond = |beyond: f64, in_plane: f64| {
            let section = self.section.signed_distance(in_plane - self.radius, height);
            beyond.abs().hypot(section.max(0.0))
        };
        beyond(before, at_start).min(beyond(after, at_end))
    }

    /// Returns the corners of a bounding box, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let axis = self.outwards.cross(self.direction);
        let (across, along) = (self.radius + self.section.half_width(), self.section.half_height());
        // The disc of the full circle, and the height on its axis.
        let reach = axis.to_array().map(|a| across * (1.0 - a * a).max(0.0).sqrt() + along * a.abs());
        let reach = DVec3::from(reach);
        (self.center - reach, self.center + reach)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_of_an_oblique_bend_are_tight() {
        let outwards = DVec3::new(1.0, 2.0, -0.5).normalize();
        let bend = Bend {
            center: DVec3::new(0.3, -0.2, 0.1),
            outwards,
            direction: outwards.cross(DVec3::new(0.2, 0.1, 1.0)).normalize(),
            radius: 0.5,
            angle: 3.0,
            section: BendSection::Rectangular(0.1, 0.04),
        };
        let (min, max) = bend.bounds();
        let axis = bend.outwards.cross(bend.direction);
        for step in 0..=30 {
            let (sin, cos) = (0.1 * f64::from(step)).sin_cos();
            for (radial, height) in [(0.6, 0.04), (0.6, -0.04), (0.4, 0.04)] {
                let point =
                    bend.center + radial * (cos * bend.outwards + sin * bend.direction) + height * axis;
                assert!(
                    (point - min).min_element() > -1e-12 && (max - point).min_element() > -1e-12,
                    "{point}"
                );
            }
        }
        assert!((max - min).max_element() <= 2.0 * 0.602);
    }
}
