//! Shapes as signed distances: negative inside, positive outside, m.
//!
//! * [`primitives`]: box, ball, cylinder
//! * [`polygon`]: polygon and its extrusion
//! * [`outline`], [`edge_tree`]: closed polylines of many edges
//! * [`bend`]: a section swept along an arc
//! * [`measure`]: bounds, gradient, nearest surface point
//! * [`directions`]: directions of plane and straight surfaces, rotation
//!
//! A mesh is a [`Surface`] of triangles, with an exact distance on both sides.
//!
//! Outside, the distance to a primitive and to a union is exact. Inside a union and on either side
//! of an intersection or difference it is a lower bound in size; its sign is correct everywhere. To
//! add a shape: a module with its distance, a variant and an arm here, a variant in the schema.

use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use sphecs_core::boundary::section_raster::SectionRaster;
use sphecs_mesh::Surface;

pub mod bend;
pub mod directions;
pub mod edge_tree;
pub mod measure;
pub mod outline;
pub mod polygon;
pub mod primitives;

use bend::Bend;
use outline::Outline;

/// A region of space: negative inside, positive outside, m.
#[derive(Clone, Debug)]
pub enum Shape {
    /// Axis-aligned box; in 2D its z reaches from −∞ to ∞.
    Box {
        /// Lower corner, m.
        min: DVec3,
        /// Upper corner, m.
        max: DVec3,
    },
    /// Circle or sphere.
    Ball {
        /// Centre, m.
        center: DVec3,
        /// Radius, m.
        radius: f64,
    },
    /// Cylinder with flat ends.
    Cylinder {
        /// Middle of one end, m.
        from: DVec3,
        /// Middle of the other end, m.
        to: DVec3,
        /// Radius, m.
        radius: f64,
    },
    /// Polygon in x and y, extruded along z from `from` to `to` (±∞ in 2D).
    Prism {
        /// Corners in order, m.
        points: Vec<DVec2>,
        /// Lower end, z in m.
        from: f64,
        /// Upper end, z in m.
        to: f64,
    },
    /// The inside of closed polylines in x and y; in 2D its z reaches from −∞ to ∞.
    Outline(Arc<Outline>),
    /// A section swept along an arc.
    Bend(Bend),
    /// The inside of a surface of triangles.
    Mesh(Arc<Surface>),
    /// Union of all of them.
    Union(Vec<Shape>),
    /// Intersection of all of them.
    Intersection(Vec<Shape>),
    /// Difference: points in the first shape and not in the second.
    Difference(std::boxed::Box<Shape>, std::boxed::Box<Shape>),
    /// Rotated, scaled and moved: a point of the shape goes to `rotation · point · scale + origin`.
    Placed {
        /// Shape that is placed.
        shape: std::boxed::Box<Shape>,
        /// Rotation.
        rotation: DMat3,
        /// Scale factor.
        scale: f64,
        /// Position of the shape's origin, m.
        origin: DVec3,
    },
    /// Section of a shape by a plane, extruded along the normal of the plane.
    Extension {
        /// The shape.
        shape: std::boxed::Box<Shape>,
        /// A point of the plane, m.
        at: DVec3,
        /// Unit normal of the plane, out of the shape.
        outwards: DVec3,
        /// Length of the extension, m.
        length: f64,
        /// Distance inside the shape at which the section is taken, m.
        inset: f64,
        /// Parts of the section that are extruded; None for all of them.
        clip: Option<Clip>,
    },
}

/// Parts of a section about a point of its plane.
#[derive(Clone, Debug)]
pub struct Clip {
    /// The parts.
    pub raster: Arc<SectionRaster>,
    /// Unit vectors that span the plane.
    pub across: [DVec3; 2],
}

impl Clip {
    /// Returns a distance from the section, m, raised to that from its extruded parts; `offset` is
    /// the offset from the point of the plane, m.
    fn raised(&self, lateral: f64, offset: DVec3) -> f64 {
        let distance = self.raster.distance(self.across.map(|across| offset.dot(across)));
        // The raster is exact to half a cell, the distance from a section of one part is exact.
        let bound = distance - self.raster.cell();
        if bound > 0.0 { lateral.max(bound) } else { lateral }
    }
}

impl Shape {
    /// Returns the signed distance to the surface, m; negative inside.
    pub fn signed_distance(&self, point: DVec3) -> f64 {
        match self {
            Shape::Box { min, max } => primitives::cuboid(point, *min, *max),
            Shape::Ball { center, radius } => point.distance(*center) - radius,
            Shape::Cylinder { from, to, radius } => primitives::cylinder(point, *from, *to, *radius),
            Shape::Prism { points, from, to } => polygon::prism(point, points, *from, *to),
            Shape::Outline(outline) => outline.signed_distance(point.truncate()),
            Shape::Bend(bend) => bend.signed_distance(point),
            Shape::Mesh(surface) => surface.signed_distance(point),
            Shape::Union(shapes) => union(shapes, point),
            Shape::Intersection(shapes) => {
                shapes.iter().map(|shape| shape.signed_distance(point)).fold(f64::NEG_INFINITY, f64::max)
            }
            Shape::Difference(shape, hole) => shape.signed_distance(point).max(-hole.signed_distance(point)),
            Shape::Placed { shape, rotation, scale, origin } => {
                let local = rotation.transpose() * (point - *origin) / *scale;
                shape.signed_distance(local) * scale
            }
            Shape::Extension { shape, at, outwards, length, inset, clip } => {
                let along = (point - *at).dot(*outwards);
                let projected = point - (along + inset) * *outwards;
                // The end of the extrusion limits the depth inside to `inset`; only the sign
                // matters.
                let lateral = shape.signed_distance(projected);
                let lateral = clip.as_ref().map_or(lateral, |clip| clip.raised(lateral, point - *at));
                let axial = (-along).max(along - length);
                primitives::corner(lateral, axial)
            }
        }
    }

    /// Returns a distance from a point, m, within which no part has a surface. Where meshes are
    /// part of the shape, it takes less time than the signed distance.
    pub fn clearance(&self, point: DVec3) -> f64 {
        let of_all = |shapes: &[Shape]| {
            shapes.iter().map(|shape| shape.clearance(point)).fold(f64::INFINITY, f64::min)
        };
        match self {
            Shape::Mesh(surface) => surface.clearance(point),
            Shape::Union(shapes) | Shape::Intersection(shapes) => of_all(shapes),
            Shape::Difference(shape, hole) => shape.clearance(point).min(hole.clearance(point)),
            Shape::Placed { shape, rotation, scale, origin } => {
                shape.clearance(rotation.transpose() * (point - *origin) / *scale) * scale
            }
            _ => self.signed_distance(point).abs(),
        }
    }

    /// Returns true if a point is inside or within `tolerance` (m) of the surface. On the seam of
    /// touching parts of a union the distance is zero up to rounding, so a tolerance makes it
    /// inside.
    pub fn contains(&self, point: DVec3, tolerance: f64) -> bool {
        self.signed_distance(point) <= tolerance
    }
}

/// Returns the distance to a union: exact outside, negative on the seams of touching parts.
fn union(shapes: &[Shape], point: DVec3) -> f64 {
    let nearest =
        |point: DVec3| shapes.iter().map(|shape| shape.signed_distance(point)).fold(f64::INFINITY, f64::min);
    let distance = nearest(point);
    // On a seam the distance is zero up to rounding; a point there is inside if its surroundings
    // are.
    let tolerance = 1e-12 * (1.0 + point.abs().max_element());
    if distance.abs() > tolerance {
        return distance;
    }
    let reach = 1e3 * tolerance;
    let surrounded =
        SURROUNDINGS.iter().all(|direction| nearest(point + reach * DVec3::from(*direction)) <= tolerance);
    if surrounded { -reach } else { distance }
}

/// Directions in which the surroundings of a seam are sampled: the 26 neighbours of a cell. A face,
/// edge or corner of the union leaves at least one of them outside.
const SURROUNDINGS: [[f64; 3]; 26] = {
    let mut directions = [[0.0; 3]; 26];
    let steps = [-1.0, 0.0, 1.0];
    let mut count = 0;
    let mut index = 0;
    while index < 27 {
        if index != 13 {
            directions[count] = [steps[index % 3], steps[index / 3 % 3], steps[index / 9]];
            count += 1;
        }
        index += 1;
    }
    directions
};
