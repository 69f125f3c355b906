//! Welding of vertices at the same place.
//!
//! Vertices with equal coordinates become one, then vertices within 1e-6 of the diagonal of the
//! bounding box: CAD programs round a shared corner differently in neighbouring patches. A vertex
//! joins the nearest earlier vertex that stays, the first of several, so that no chain of short
//! steps pulls distant vertices together and the result does not depend on a hash function.

use std::collections::HashMap;
use std::hash::{BuildHasherDefault, Hasher};

use glam::DVec3;

use crate::triangulation::Triangulation;

/// Tolerance of welding as a share of the diagonal of the bounding box.
pub(crate) const TOLERANCE: f64 = 1e-6;

/// Edge of a cell of the search in tolerances: small enough for few vertices in a cell, large
/// enough for few cells around a vertex.
const CELL: f64 = 8.0;

/// End of the list of a cell.
const NONE: u32 = u32::MAX;

/// Welds the vertices and returns the number of those that were near another but not equal to it.
pub(crate) fn weld(mesh: &mut Triangulation) -> usize {
    mesh.drop_unused_vertices();
    merge_equal(mesh);
    merge_near(mesh)
}

/// Merges vertices with equal coordinates.
fn merge_equal(mesh: &mut Triangulation) {
    let mut first: HashMap<[u64; 3], u32, Mixing> = HashMap::default();
    let mut kept = Vec::new();
    // Adding 0 turns −0 into 0.
    let key = |vertex: &DVec3| vertex.to_array().map(|x| (x + 0.0).to_bits());
    let numbers = renumber(&mesh.vertices, |vertex| {
        *first.entry(key(vertex)).or_insert_with(|| {
            kept.push(*vertex);
            kept.len() as u32 - 1
        })
    });
    apply(mesh, kept, &numbers);
}

/// Merges vertices within the tolerance and returns their number.
fn merge_near(mesh: &mut Triangulation) -> usize {
    let tolerance = TOLERANCE * mesh.diagonal();
    let (low, _) = mesh.bounds();
    let before = mesh.vertices.len();
    let mut kept: Vec<DVec3> = Vec::new();
    // The last vertex of each cell, and of each vertex the one before it in its cell.
    let mut last: HashMap<[u32; 3], u32, Mixing> = HashMap::default();
    let mut previous: Vec<u32> = Vec::new();
    // At most 1.8e6 cells along an axis.
    let cell = |point: DVec3| ((point - low) / (CELL * tolerance)).to_array().map(|x| x.max(0.0) as u32);
    let numbers = renumber(&mesh.vertices, |vertex| {
        let (from, to) = (cell(*vertex - tolerance), cell(*vertex + tolerance));
        let mut nearest = (tolerance * tolerance, NONE);
        for x in from[0]..=to[0] {
            for y in from[1]..=to[1] {
                for z in from[2]..=to[2] {
                    let mut other = last.get(&[x, y, z]).copied().unwrap_or(NONE);
                    while other != NONE {
                        let candidate = (kept[other as usize].distance_squared(*vertex), other);
                        nearest = if candidate < nearest { candidate } else { nearest };
                        other = previous[other as usize];
                    }
                }
            }
        }
        if nearest.1 != NONE {
            return nearest.1;
        }
        let number = kept.len() as u32;
        kept.push(*vertex);
        previous.push(last.insert(cell(*vertex), number).unwrap_or(NONE));
        number
    });
    apply(mesh, kept, &numbers);
    before - mesh.vertices.len()
}

fn renumber(vertices: &[DVec3], number: impl FnMut(&DVec3) -> u32) -> Vec<u32> {
    vertices.iter().map(number).collect()
}

fn apply(mesh: &mut Triangulation, kept: Vec<DVec3>, numbers: &[u32]) {
    mesh.vertices = kept;
    for vertex in mesh.triangles.iter_mut().flatten() {
        *vertex = numbers[*vertex as usize];
    }
}

type Mixing = BuildHasherDefault<Mixer>;

/// Hash of a few integers. The default of the standard library took half of the time of welding.
#[derive(Default)]
struct Mixer(u64);

impl Hasher for Mixer {
    fn finish(&self) -> u64 {
        // The table uses the upper and the lower bits.
        self.0 ^ (self.0 >> 32)
    }

    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.write_u64(u64::from_le_bytes(word));
        }
    }

    fn write_u64(&mut self, word: u64) {
        self.0 = (self.0.rotate_left(29) ^ word).wrapping_mul(0x9e37_79b9_7f4a_7c15);
        self.0 ^= self.0 >> 31;
    }

    fn write_u32(&mut self, word: u32) {
        self.write_u64(u64::from(word));
    }
}
