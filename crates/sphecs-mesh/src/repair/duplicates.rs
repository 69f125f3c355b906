//! Facets without extent and facets that occur more than once.

use rayon::slice::ParallelSliceMut;

use super::edges::Edges;
use crate::report::Report;
use crate::triangulation::Triangulation;

/// Drops the triangles of which two corners are the same vertex, and counts them.
///
/// Triangles with three different vertices on a line stay: without them their neighbours would
/// have open edges.
pub(crate) fn drop_degenerate(mesh: &mut Triangulation, report: &mut Report) {
    let before = mesh.triangles.len();
    let is_degenerate: Vec<bool> =
        mesh.triangles.iter().map(|[a, b, c]| a == b || b == c || c == a).collect();
    mesh.retain(|triangle| !is_degenerate[triangle]);
    report.degenerate = before - mesh.triangles.len();
}

/// Drops all but one of equal triangles, and both of two with opposite normals.
///
/// Two with opposite normals are the wall between two closed parts that touch, and cancel in the
/// winding number. Where their neighbours would be left with an open edge all around, one stays.
pub(crate) fn drop_duplicates(mesh: &mut Triangulation, report: &mut Report) {
    let sets = equal_sets(mesh);
    if sets.is_empty() {
        return;
    }
    let mut keep = vec![true; mesh.triangles.len()];
    let mut cancelled = Vec::new();
    for set in &sets {
        let (even, odd): (Vec<u32>, Vec<u32>) =
            set.iter().partition(|triangle| is_even(mesh.triangles[**triangle as usize]));
        let stays = match even.len().cmp(&odd.len()) {
            std::cmp::Ordering::Greater => Some(even[0]),
            std::cmp::Ordering::Less => Some(odd[0]),
            std::cmp::Ordering::Equal => None,
        };
        report.opposite += 2 * even.len().min(odd.len());
        report.duplicates += set.len() - 2 * even.len().min(odd.len()) - usize::from(stays.is_some());
        for triangle in set {
            keep[*triangle as usize] = stays == Some(*triangle);
        }
        if stays.is_none() {
            cancelled.push(set[0]);
        }
    }
    for triangle in needed(mesh, &keep, &cancelled) {
        keep[triangle as usize] = true;
        // One of the two is only a duplicate of the other.
        report.opposite -= 2;
        report.duplicates += 1;
    }
    mesh.retain(|triangle| keep[triangle]);
}

/// Returns the cancelled triangles whose three edges would be open without them.
fn needed(mesh: &Triangulation, keep: &[bool], cancelled: &[u32]) -> Vec<u32> {
    if cancelled.is_empty() {
        return Vec::new();
    }
    let mut is_cancelled = vec![false; keep.len()];
    for triangle in cancelled {
        is_cancelled[*triangle as usize] = true;
    }
    let mut open_edges = vec![0_u8; keep.len()];
    for edge in Edges::new(mesh).edges() {
        let facets = || edge.iter().map(|(_, half)| *half as usize / 3);
        if facets().filter(|facet| keep[*facet]).count() == 1 {
            for facet in facets().filter(|facet| is_cancelled[*facet]) {
                open_edges[facet] += 1;
            }
        }
    }
    cancelled.iter().copied().filter(|triangle| open_edges[*triangle as usize] == 3).collect()
}

/// Returns the sets of triangles with the same three vertices, each in ascending order.
fn equal_sets(mesh: &Triangulation) -> Vec<Vec<u32>> {
    let sorted = |triangle: u32| {
        let mut vertices = mesh.triangles[triangle as usize];
        vertices.sort_unstable();
        vertices
    };
    let mut order: Vec<([u32; 3], u32)> =
        (0..mesh.triangles.len() as u32).map(|triangle| (sorted(triangle), triangle)).collect();
    order.par_sort_unstable();
    order
        .chunk_by(|a, b| a.0 == b.0)
        .filter(|set| set.len() > 1)
        .map(|set| set.iter().map(|(_, triangle)| *triangle).collect())
        .collect()
}

/// Returns true if three different numbers are an even permutation of their ascending order.
fn is_even([a, b, c]: [u32; 3]) -> bool {
    (usize::from(a > b) + usize::from(b > c) + usize::from(a > c)).is_multiple_of(2)
}
