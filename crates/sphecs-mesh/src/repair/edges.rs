//! Edges of a triangulation with the triangles at each.

use rayon::slice::ParallelSliceMut;

use crate::triangulation::Triangulation;

/// No triangle at the other side of an edge.
pub(crate) const NONE: u32 = u32::MAX;

/// Half-edges sorted by their edge. Half-edge 3 t + k goes from corner k of triangle t to the next.
#[derive(Clone, Debug)]
pub(crate) struct Edges {
    sorted: Vec<(u64, u32)>,
}

impl Edges {
    /// Sorts the half-edges of a triangulation.
    pub(crate) fn new(mesh: &Triangulation) -> Self {
        let mut sorted: Vec<(u64, u32)> = (0..3 * mesh.triangles.len() as u32)
            .map(|half| {
                let [from, to] = ends(mesh, half);
                (u64::from(from.min(to)) << 32 | u64::from(from.max(to)), half)
            })
            .collect();
        sorted.par_sort_unstable();
        Self { sorted }
    }

    /// Returns the half-edges of each edge, in the order of their numbers.
    pub(crate) fn edges(&self) -> impl Iterator<Item = &[(u64, u32)]> {
        self.sorted.chunk_by(|a, b| a.0 == b.0)
    }

    /// Returns for each half-edge the other one of its edge; [`NONE`] unless there are two.
    pub(crate) fn mates(&self) -> Vec<u32> {
        let mut mates = vec![NONE; self.sorted.len()];
        for edge in self.edges() {
            if let [(_, a), (_, b)] = edge {
                mates[*a as usize] = *b;
                mates[*b as usize] = *a;
            }
        }
        mates
    }
}

/// Returns the vertices where a half-edge begins and ends.
pub(crate) fn ends(mesh: &Triangulation, half: u32) -> [u32; 2] {
    let triangle = mesh.triangles[half as usize / 3];
    let corner = half as usize % 3;
    [triangle[corner], triangle[(corner + 1) % 3]]
}
