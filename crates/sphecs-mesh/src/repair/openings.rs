//! Edges at which a surface is open or meets itself.

use std::collections::BTreeMap;

use glam::DVec3;

use super::edges::{Edges, ends};
use crate::report::{OpenLoop, Report};
use crate::triangulation::Triangulation;

/// Counts the edges with more than two facets and measures the loops of those with one.
pub(crate) fn find_openings(mesh: &Triangulation, report: &mut Report) {
    let mut open = Vec::new();
    for edge in Edges::new(mesh).edges() {
        match edge {
            [(_, half)] => open.push(ends(mesh, *half)),
            [_, _] => {}
            _ => report.non_manifold_edges += 1,
        }
    }
    report.open_loops = loops(mesh, &open);
}

/// Joins open edges that share vertices, and measures each set; the longest first.
fn loops(mesh: &Triangulation, open: &[[u32; 2]]) -> Vec<OpenLoop> {
    let mut sets = Sets { parents: BTreeMap::new() };
    for [from, to] in open {
        sets.join(*from, *to);
    }
    let mut edges_of: BTreeMap<u32, Vec<[DVec3; 2]>> = BTreeMap::new();
    for edge in open {
        let set = sets.first(edge[0]);
        edges_of.entry(set).or_default().push(edge.map(|vertex| mesh.vertices[vertex as usize]));
    }
    let mut loops: Vec<OpenLoop> = edges_of.values().map(|edges| measure(edges)).collect();
    loops.sort_by(|a, b| b.length.total_cmp(&a.length));
    loops
}

fn measure(edges: &[[DVec3; 2]]) -> OpenLoop {
    let length: f64 = edges.iter().map(|[from, to]| from.distance(*to)).sum();
    let moment: DVec3 = edges.iter().map(|[from, to]| from.distance(*to) * 0.5 * (*from + *to)).sum();
    let centre = if length > 0.0 { moment / length } else { edges[0][0] };
    // Facets agree in orientation, so the edges go around one way.
    let area: DVec3 = edges.iter().map(|[from, to]| 0.5 * (*from - centre).cross(*to - centre)).sum();
    OpenLoop { length, area: area.length(), centre, edges: edges.len() }
}

/// Sets of vertices, each named by its smallest.
struct Sets {
    parents: BTreeMap<u32, u32>,
}

impl Sets {
    fn first(&mut self, vertex: u32) -> u32 {
        let mut first = vertex;
        while let Some(parent) = self.parents.get(&first).filter(|parent| **parent != first) {
            first = *parent;
        }
        // Shortens the path for later calls.
        let mut at = vertex;
        while at != first {
            at = self.parents.insert(at, first).unwrap_or(first);
        }
        first
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.first(a), self.first(b));
        self.parents.insert(a.max(b), a.min(b));
        self.parents.entry(a.min(b)).or_insert(a.min(b));
    }
}
