//! Surface of triangles with exact distance and inside test.

mod build;
pub(crate) mod bvh;
pub(crate) mod crossing;
mod intersections;
pub(crate) mod nearest;
mod normals;
mod planes;
pub(crate) mod winding;

use glam::DVec3;

pub use build::Part;
use bvh::Bvh;
pub use intersections::Intersections;
pub use nearest::{Feature, Nearest};
pub use planes::Plane;

use crate::triangulation::Triangulation;
use normals::Around;

/// Winding number above which a point is inside.
const INSIDE: f64 = 0.5;

/// Least share of the distance along the pseudonormal at which its sign is certain.
const CERTAIN: f64 = 0.05;

/// Oriented triangles with groups, and a tree for queries. Lengths in m.
///
/// Immutable; queries may run on several threads and give the same result on each.
#[derive(Clone, Debug)]
pub struct Surface {
    pub(crate) mesh: Triangulation,
    group_names: Vec<String>,
    pub(crate) bvh: Bvh,
    around: Around,
    bounds: (DVec3, DVec3),
    area: f64,
    volume: f64,
    /// True if it is closed, oriented and does not cross itself: the normal of a facet then tells
    /// the sides of the points next to it.
    is_embedded: bool,
}

impl Surface {
    /// Returns the positions of the vertices, m.
    pub fn vertices(&self) -> &[DVec3] {
        &self.mesh.vertices
    }

    /// Returns the corners of the triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.mesh.triangles
    }

    /// Returns the index into [`Self::group_names`] of each triangle.
    pub fn groups(&self) -> &[u16] {
        &self.mesh.groups
    }

    /// Returns the names of the groups.
    pub fn group_names(&self) -> &[String] {
        &self.group_names
    }

    /// Returns the index of the group of a name.
    pub fn group(&self, name: &str) -> Option<u16> {
        self.group_names.iter().position(|known| known == name).map(|index| index as u16)
    }

    /// Returns the point of the surface that is nearest to a point, m.
    ///
    /// # Panics
    /// If the point is not finite.
    pub fn nearest(&self, point: DVec3) -> Nearest {
        let found = nearest::nearest_within(&self.bvh, &self.mesh, point, f64::INFINITY);
        found.expect("a surface has a triangle, and the point is finite")
    }

    /// Returns the nearest point within a distance in m; None if the surface is farther.
    pub fn nearest_within(&self, point: DVec3, bound: f64) -> Option<Nearest> {
        nearest::nearest_within(&self.bvh, &self.mesh, point, bound)
    }

    /// Returns the generalised winding number at a point: about 1 inside, about 0 outside, 2 where
    /// two closed parts overlap.
    pub fn winding(&self, point: DVec3) -> f64 {
        winding::winding(&self.bvh, &self.mesh, point)
    }

    /// Returns true for a point inside, where the winding number is above ½.
    pub fn is_inside(&self, point: DVec3) -> bool {
        self.winding(point) > INSIDE
    }

    /// Returns the distance of a point from the surface, m: negative inside.
    ///
    /// Of a surface that is closed and does not cross itself the pseudonormal at the nearest point
    /// decides on the side, Bærentzen & Aanæs (2005), which takes a fifth of the time. Where the
    /// point is nearly beside the surface, and for all other surfaces, the winding number does.
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        let nearest = self.nearest(point);
        let distance = nearest.distance;
        if distance == 0.0 {
            return distance;
        }
        if self.is_embedded {
            let height = (point - nearest.point).dot(self.pseudonormal(&nearest));
            if height.abs() > CERTAIN * distance {
                return distance.copysign(height);
            }
        }
        if self.is_inside(point) { -distance } else { distance }
    }

    /// Returns a distance from a point, m, within which there is no surface: between four fifths
    /// and all of that of the nearest point.
    pub fn clearance(&self, point: DVec3) -> f64 {
        nearest::clearance(&self.bvh, &self.mesh, point, 1.25)
    }

    /// Returns the lower and the upper corner of the bounding box, m.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        self.bounds
    }

    /// Returns the area, m².
    pub fn area(&self) -> f64 {
        self.area
    }

    /// Returns the enclosed volume, m³: the signed one, in which overlapping parts count twice.
    pub fn volume(&self) -> f64 {
        self.volume
    }

    /// Returns the area of a group, m².
    pub fn group_area(&self, group: u16) -> f64 {
        let of_group = (0..self.mesh.triangles.len()).filter(|triangle| self.mesh.groups[*triangle] == group);
        of_group.map(|triangle| self.mesh.area_vector(triangle).length()).sum()
    }
}
