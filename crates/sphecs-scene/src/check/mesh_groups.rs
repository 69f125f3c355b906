//! Planes of openings that are flat groups of facets of a mesh.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::checker::Checker;
use super::patches::Site;
use crate::faults::{Fault, advice};
use crate::geometry::Shape;
use crate::model::Scene;
use crate::movers::Wall;
use crate::schema::Text;
use sphecs_core::format::{point, significant};
use sphecs_mesh::Surface;

/// Largest distance of a group from its plane, in spacings.
const FLAT: f64 = 0.05;

/// A mesh in the domain or in a mover, and its place at the start: x = R X s + o.
pub struct PlacedMesh<'a> {
    /// Wall that its surface is of.
    pub wall: Wall,
    surface: &'a Arc<Surface>,
    rotation: DMat3,
    scale: f64,
    origin: DVec3,
}

/// Plane of an opening.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// A point of the group, m.
    pub at: DVec3,
    /// Unit normal, out of the domain.
    pub outwards: DVec3,
}

/// Returns the plane of a group of facets of a mesh in the domain; None if it has a fault.
pub fn plane_of_group(name: &Text, site: &Site<'_>, check: &mut Checker<'_>) -> Option<Plane> {
    if name.is_placeholder() {
        check.note_placeholder(name.span);
        return None;
    }
    if !site.is_valid {
        return None;
    }
    let mut meshes = Vec::new();
    collect(site.domain, (Wall::Casing, Holes::Omitted), Place::IDENTITY, &mut meshes);
    let found = meshes.iter().find_map(|mesh| Some((mesh, mesh.surface.group(&name.value)?)));
    let Some((mesh, group)) = found else {
        let known = meshes.iter().flat_map(|mesh| mesh.surface.group_names());
        let label = "must be the name of a solid, a group or a file of a mesh in the domain";
        let title = format!("no mesh of the domain has a group `{}`", name.value);
        let help = match meshes.is_empty() {
            true => "the domain has no mesh: give the opening its plane by `at` and `towards`".to_owned(),
            false => advice(&name.value, known.map(String::as_str)),
        };
        check.report(Fault::new(title, name.span, label).help(help));
        return None;
    };
    let plane = mesh.plane(group, site);
    if plane.is_none() {
        let (off, place) = mesh.farthest(group);
        let label = format!(
            "has facets of several directions, or {} m off its mean plane near {} m; must be flat to {FLAT} spacings",
            significant(off),
            point(&place.to_array(), site.spacing)
        );
        let title = format!("the group `{}` is not flat", name.value);
        check.report(Fault::new(title, name.span, label).help("end the mesh with a plane there"));
    }
    plane
}

/// Returns the meshes of the casing and of the movers of a scene, in their places at the start.
pub fn meshes_of(scene: &Scene) -> Vec<PlacedMesh<'_>> {
    let mut found = Vec::new();
    collect(&scene.layout.casing.domain, (Wall::Casing, Holes::Taken), Place::IDENTITY, &mut found);
    for (index, mover) in scene.movers.iter().enumerate() {
        let place = Place { rotation: mover.start.rotation, scale: 1.0, origin: mover.start.origin };
        collect(&mover.shape, (Wall::Mover(index), Holes::Taken), place, &mut found);
    }
    found
}

/// Treatment of the meshes that a shape takes out.
#[derive(Clone, Copy, PartialEq)]
enum Holes {
    /// Openings are ends of what is filled.
    Omitted,
    Taken,
}

/// A place x = R X s + o.
#[derive(Clone, Copy)]
struct Place {
    rotation: DMat3,
    scale: f64,
    origin: DVec3,
}

impl Place {
    const IDENTITY: Self = Self { rotation: DMat3::IDENTITY, scale: 1.0, origin: DVec3::ZERO };
}

/// Collects the meshes of a shape with their places.
fn collect<'a>(
    shape: &'a Shape,
    (wall, holes): (Wall, Holes),
    place: Place,
    found: &mut Vec<PlacedMesh<'a>>,
) {
    let Place { rotation, scale, origin } = place;
    match shape {
        Shape::Mesh(surface) => found.push(PlacedMesh { wall, surface, rotation, scale, origin }),
        Shape::Union(shapes) | Shape::Intersection(shapes) => {
            shapes.iter().for_each(|shape| collect(shape, (wall, holes), place, found));
        }
        Shape::Difference(shape, hole) => {
            collect(shape, (wall, holes), place, found);
            if holes == Holes::Taken {
                collect(hole, (wall, holes), place, found);
            }
        }
        Shape::Placed { shape, rotation: inner, scale: by, origin: at } => {
            let place = Place {
                rotation: rotation * *inner,
                scale: scale * by,
                origin: rotation * *at * scale + origin,
            };
            collect(shape, (wall, holes), place, found);
        }
        _ => {}
    }
}

impl PlacedMesh<'_> {
    /// Returns the index of the group of a name.
    pub fn group(&self, name: &str) -> Option<u16> {
        self.surface.group(name)
    }

    /// Returns the names of its groups.
    pub fn group_names(&self) -> impl Iterator<Item = &str> {
        self.surface.group_names().iter().map(String::as_str)
    }

    /// Returns the triangles of a group whose middles are in a region, m.
    pub fn triangles_in(&self, group: u16, region: impl Fn(DVec3) -> bool) -> Vec<[DVec3; 3]> {
        self.triangles(group).filter(|[a, b, c]| region((*a + *b + *c) / 3.0)).collect()
    }

    /// Returns the triangles of a group, m.
    fn triangles(&self, group: u16) -> impl Iterator<Item = [DVec3; 3]> + '_ {
        let all = self.surface.triangles().iter().zip(self.surface.groups());
        let place =
            |vertex: u32| self.rotation * self.surface.vertices()[vertex as usize] * self.scale + self.origin;
        all.filter(move |(_, of)| **of == group).map(move |(corners, _)| corners.map(place))
    }

    /// Returns area (m²), vector area (m²) and mean position (m) of a group.
    fn measures(&self, group: u16) -> (f64, DVec3, DVec3) {
        let (mut area, mut vector, mut moment) = (0.0, DVec3::ZERO, DVec3::ZERO);
        for [a, b, c] in self.triangles(group) {
            let own = 0.5 * (b - a).cross(c - a);
            area += own.length();
            vector += own;
            moment += own.length() * (a + b + c) / 3.0;
        }
        (area, vector, moment / area)
    }

    /// Returns the largest distance of a group from its mean plane, m, and where it is.
    fn farthest(&self, group: u16) -> (f64, DVec3) {
        let (_, vector, middle) = self.measures(group);
        let normal = vector.normalize_or_zero();
        let corners = self.triangles(group).flatten();
        let off = corners.map(|corner| ((corner - middle).dot(normal).abs(), corner));
        off.max_by(|a, b| a.0.total_cmp(&b.0)).unwrap_or_default()
    }

    /// Returns the plane of a group; None if it is not flat.
    fn plane(&self, group: u16, site: &Site<'_>) -> Option<Plane> {
        let (area, vector, middle) = self.measures(group);
        let (off, _) = self.farthest(group);
        if vector.length() < 0.999 * area || off > FLAT * site.spacing {
            return None;
        }
        let outwards = vector.normalize();
        // The middle of a ring is not a point of it.
        let is_inside = |at: DVec3| site.domain.contains(at - 0.1 * site.spacing * outwards, 0.0);
        let largest = self.triangles(group).max_by(|a, b| size(a).total_cmp(&size(b)));
        let at =
            if is_inside(middle) { middle } else { largest.map_or(middle, |[a, b, c]| (a + b + c) / 3.0) };
        Some(Plane { at, outwards })
    }
}

/// Returns twice the area of a triangle, m².
fn size([a, b, c]: &[DVec3; 3]) -> f64 {
    (*b - *a).cross(*c - *a).length()
}
