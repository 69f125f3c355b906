//! Orientation of facets: the same within a component, outward from the solid for each component.
//!
//! Components are sets of triangles connected by edges with exactly two facets. A component with a
//! negative signed volume is turned. A closed component inside an odd number of others is a cavity,
//! whose normals point into it: its signed volume must be negative.

use glam::DVec3;

use super::edges::{Edges, NONE, ends};
use super::nested;
use crate::report::Report;
use crate::triangulation::Triangulation;

/// Signed volume over area^(3/2) below which an open component has no inside: a sheet.
const SHEET: f64 = 1e-3;

/// Connected triangles of a surface.
#[derive(Clone, Debug)]
pub(crate) struct Component {
    /// Numbers of the triangles, in the order in which they were reached.
    pub triangles: Vec<u32>,
    /// True if every edge has two facets, or another even number.
    pub is_closed: bool,
}

/// Orients all triangles and counts the changes.
pub(crate) fn orient(mesh: &mut Triangulation, report: &mut Report) {
    let edges = Edges::new(mesh);
    let mut flood = Flood::new(mesh, edges.mates());
    let mut components: Vec<Component> = Vec::new();
    for triangle in 0..mesh.triangles.len() as u32 {
        if flood.component[triangle as usize] == NONE {
            let triangles = flood.fill(mesh, triangle, components.len() as u32);
            components.push(Component { triangles, is_closed: true });
        }
    }
    report.components = components.len();
    // Each such edge is met from both sides.
    report.one_sided_edges = flood.contradictions / 2;
    for component in &components {
        report.flipped += flood.agree_with_majority(mesh, &component.triangles);
    }
    for edge in edges.edges().filter(|edge| edge.len() % 2 == 1) {
        for (_, half) in edge {
            components[flood.component[*half as usize / 3] as usize].is_closed = false;
        }
    }
    for (triangle, is_flipped) in flood.is_flipped.iter().enumerate() {
        if *is_flipped {
            mesh.triangles[triangle].swap(1, 2);
        }
    }
    turn_outwards(mesh, &mut components, report);
}

/// Turns the components whose signed volume has the wrong sign.
fn turn_outwards(mesh: &mut Triangulation, components: &mut [Component], report: &mut Report) {
    let is_cavity = nested::cavities(mesh, components);
    report.cavities = is_cavity.iter().filter(|is_cavity| **is_cavity).count();
    for (component, is_cavity) in components.iter_mut().zip(is_cavity) {
        let (volume, area) = volume_and_area(mesh, &component.triangles);
        let has_inside = component.is_closed || volume.abs() > SHEET * area.powf(1.5);
        if has_inside && if is_cavity { volume > 0.0 } else { volume < 0.0 } {
            report.turned_components += 1;
            for triangle in &component.triangles {
                mesh.triangles[*triangle as usize].swap(1, 2);
            }
        }
    }
}

/// Returns the signed volume, m³, and the area, m², of some triangles.
///
/// The volume of an open set is that of the cone from its mean vertex.
pub(crate) fn volume_and_area(mesh: &Triangulation, triangles: &[u32]) -> (f64, f64) {
    let corners = |triangle: &u32| mesh.corners(*triangle as usize);
    let sum: DVec3 = triangles.iter().flat_map(corners).sum();
    let centre = sum / (3 * triangles.len()).max(1) as f64;
    triangles.iter().fold((0.0, 0.0), |(volume, area), triangle| {
        let [a, b, c] = corners(triangle).map(|corner| corner - centre);
        let normal = (b - a).cross(c - a);
        (volume + a.dot(normal) / 6.0, area + 0.5 * normal.length())
    })
}

/// Spreads the orientation of a first triangle over manifold edges.
struct Flood {
    mates: Vec<u32>,
    /// Component of each triangle; [`NONE`] before it is reached.
    component: Vec<u32>,
    is_flipped: Vec<bool>,
    /// Half-edges across which the orientations do not fit, as on a Möbius strip.
    contradictions: usize,
}

impl Flood {
    fn new(mesh: &Triangulation, mates: Vec<u32>) -> Self {
        let count = mesh.triangles.len();
        Self { mates, component: vec![NONE; count], is_flipped: vec![false; count], contradictions: 0 }
    }

    /// Reaches all triangles connected to the first and returns them.
    fn fill(&mut self, mesh: &Triangulation, first: u32, component: u32) -> Vec<u32> {
        let mut reached = vec![first];
        self.component[first as usize] = component;
        let mut next = 0;
        while next < reached.len() {
            let triangle = reached[next];
            next += 1;
            for half in 3 * triangle..3 * triangle + 3 {
                let mate = self.mates[half as usize];
                if mate == NONE {
                    continue;
                }
                let (here, other) = (triangle as usize, mate as usize / 3);
                // Neighbours that agree pass their edge in opposite directions.
                let disagrees = ends(mesh, half) == ends(mesh, mate);
                let wanted = self.is_flipped[here] ^ disagrees;
                if self.component[other] == NONE {
                    self.component[other] = component;
                    self.is_flipped[other] = wanted;
                    reached.push(other as u32);
                } else if self.is_flipped[other] != wanted {
                    self.contradictions += 1;
                }
            }
        }
        reached
    }

    /// Flips the smaller area of a component instead of the larger, and returns the number of
    /// flipped triangles.
    fn agree_with_majority(&mut self, mesh: &Triangulation, triangles: &[u32]) -> usize {
        let (mut flipped, mut total) = (0.0, 0.0);
        for triangle in triangles {
            let area = mesh.area_vector(*triangle as usize).length();
            total += area;
            flipped += if self.is_flipped[*triangle as usize] { area } else { 0.0 };
        }
        let invert = flipped > 0.5 * total;
        let mut count = 0;
        for triangle in triangles {
            let is_flipped = &mut self.is_flipped[*triangle as usize];
            *is_flipped ^= invert;
            count += usize::from(*is_flipped);
        }
        count
    }
}
