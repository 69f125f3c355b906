//! Surface of the facets of one or several files.

use std::collections::HashSet;

use glam::DVec3;

use super::Surface;
use super::bvh::Bvh;
use super::normals::Around;
use crate::facets::{Facets, LARGEST_COORDINATE};
use crate::fault::{Fault, Place};
use crate::repair::orient::volume_and_area;
use crate::repair::repair;
use crate::report::Report;
use crate::triangulation::Triangulation;
use crate::weld::weld;

/// Diagonal of the smallest surface, m: the fifth power of shorter lengths is not accurate.
const SMALLEST: f64 = 1e-30;

/// Most triangles: a half-edge has a number of 32 bits.
const MOST_TRIANGLES: usize = u32::MAX as usize / 3;

/// Facets of one file with a name for those that have no group of their own.
#[derive(Clone, Debug)]
pub struct Part {
    /// Name of the file without folder and extension.
    pub name: String,
    /// Facets of the file.
    pub facets: Facets,
}

impl Surface {
    /// Makes one surface of the facets of all parts, scaled to m, and reports what was changed.
    ///
    /// A group is named as in the file; triangles without a group get the name of the part. Of
    /// several parts, one with a single group gets the name of the part, since CAD programs write
    /// the same name into every file; a name of two parts becomes `part:name` in the second.
    ///
    /// # Errors
    /// If no triangle with extent is left, if a part has wrong indices, or if coordinates or
    /// numbers of groups or triangles exceed their range.
    pub fn new(parts: Vec<Part>, scale: f64) -> Result<(Self, Report), Fault> {
        let names = parts.iter().map(|part| part.name.as_str()).collect::<Vec<_>>().join(", ");
        let fault = |message: String| Fault::new(&names, Place::Whole, message);
        if !(scale.is_finite() && scale > 0.0) {
            return Err(fault(format!("has a unit of {scale} m, must be above 0: give the unit in m")));
        }
        let (mut mesh, group_names) = joined(parts, scale, &fault)?;
        let mut report = Report { facets: mesh.triangles.len(), ..Report::default() };
        check_extent(&mesh).map_err(&fault)?;
        report.welded = weld(&mut mesh);
        repair(&mut mesh, &mut report);
        report.triangles = mesh.triangles.len();
        report.vertices = mesh.vertices.len();
        let has_area = (0..mesh.triangles.len()).any(|triangle| mesh.area_vector(triangle) != DVec3::ZERO);
        if !has_area {
            return Err(fault(format!(
                "has {} facets and none with an area, must be a closed surface: export it again",
                report.facets
            )));
        }
        let is_sound = report.is_closed() && report.non_manifold_edges + report.one_sided_edges == 0;
        let mut surface = Self::of(mesh, group_names);
        surface.is_embedded = is_sound && surface.intersections().pairs == 0;
        Ok((surface, report))
    }

    /// Makes a surface of triangles in m, counter-clockwise seen from outside, without repair.
    ///
    /// # Errors
    /// If there is no triangle, an index has no vertex, or a coordinate is not finite.
    pub fn from_triangles(vertices: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Result<Self, Fault> {
        let groups = vec![0; triangles.len()];
        let facets = Facets { vertices, triangles, groups, group_names: vec![String::new()] };
        let fault = |message: String| Fault::new("triangles", Place::Whole, message);
        let (mut mesh, names) = joined(vec![Part { name: "surface".to_owned(), facets }], 1.0, &fault)?;
        check_extent(&mesh).map_err(fault)?;
        mesh.drop_unused_vertices();
        Ok(Self::of(mesh, names))
    }

    fn of(mesh: Triangulation, group_names: Vec<String>) -> Self {
        let all: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let (volume, area) = volume_and_area(&mesh, &all);
        Self {
            group_names,
            bvh: Bvh::new(&mesh, all.into_iter()),
            around: Around::new(&mesh),
            bounds: mesh.bounds(),
            area,
            volume,
            is_embedded: false,
            mesh,
        }
    }
}

/// Joins the parts into one triangulation in m with the names of its groups.
fn joined(
    parts: Vec<Part>,
    scale: f64,
    fault: &impl Fn(String) -> Fault,
) -> Result<(Triangulation, Vec<String>), Fault> {
    let triangles: usize = parts.iter().map(|part| part.facets.triangles.len()).sum();
    let vertices: usize = parts.iter().map(|part| part.facets.vertices.len()).sum();
    if triangles > MOST_TRIANGLES || vertices >= u32::MAX as usize {
        return Err(fault(format!(
            "has {triangles} triangles and {vertices} vertices, must have below 1.4e9 and 4.2e9: reduce the mesh"
        )));
    }
    let mut mesh = Triangulation::default();
    let mut names: Vec<String> = Vec::new();
    let is_alone = parts.len() == 1;
    for part in parts {
        part.facets.check().map_err(|message| Fault::new(&part.name, Place::Whole, message))?;
        let first_vertex = mesh.vertices.len() as u32;
        let first_group = names.len();
        let mut taken: HashSet<String> = names.iter().cloned().collect();
        for name in &part.facets.group_names {
            let is_named = !name.is_empty() && (is_alone || part.facets.group_names.len() > 1);
            let name = if is_named { name } else { &part.name };
            let name = if taken.contains(name) { format!("{}:{name}", part.name) } else { name.clone() };
            taken.insert(name.clone());
            names.push(name);
        }
        if names.len() > usize::from(u16::MAX) + 1 {
            return Err(fault(format!(
                "has {} groups, must have at most 65 536: join groups in the CAD",
                names.len()
            )));
        }
        let facets = part.facets;
        mesh.vertices.extend(facets.vertices.iter().map(|vertex| *vertex * scale));
        mesh.triangles.extend(facets.triangles.iter().map(|triangle| triangle.map(|v| v + first_vertex)));
        mesh.groups.extend(facets.groups.iter().map(|group| first_group as u16 + group));
    }
    Ok((mesh, names))
}

/// Checks that there are triangles, and that their size and coordinates allow queries.
fn check_extent(mesh: &Triangulation) -> Result<(), String> {
    if mesh.triangles.is_empty() {
        return Err("has no triangles, must be a closed surface: export it again".to_owned());
    }
    let (low, high) = mesh.bounds();
    let largest = low.abs().max(high.abs()).max_element();
    if largest.is_nan() || largest > LARGEST_COORDINATE {
        return Err(format!(
            "has a coordinate of {largest:.2e} m, must be below {LARGEST_COORDINATE:.0e}: is the unit right?"
        ));
    }
    let diagonal = low.distance(high);
    if diagonal < SMALLEST {
        return Err(format!("is {diagonal:.2e} m large, must be above {SMALLEST:.0e} m: is the unit right?"));
    }
    Ok(())
}
