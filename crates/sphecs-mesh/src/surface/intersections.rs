//! Places where a surface crosses itself, and parts that overlap.

use std::collections::BTreeSet;

use glam::DVec3;
use rayon::iter::{IntoParallelRefIterator, ParallelIterator};

use super::Surface;
use super::bvh::{Node, STACK};
use super::crossing::{Corner, cross};
use crate::report::counted;

/// Crossings of the triangles of a surface.
///
/// Overlapping closed parts are a union for the inside test. Triangles that touch or lie in one
/// plane are not counted.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Intersections {
    /// Pairs of triangles that cross.
    pub pairs: usize,
    /// Numbers of the first pair.
    pub first: Option<[u32; 2]>,
    /// Position near the crossing of the first pair, m.
    pub place: Option<DVec3>,
    /// Pairs of connected parts that cross each other.
    pub parts: usize,
    /// Pairs of triangles that cross within one connected part.
    pub within_parts: usize,
}

impl Intersections {
    /// Returns a sentence with number and place; None without crossings.
    pub fn line(&self) -> Option<String> {
        let [x, y, z] = self.place?.to_array();
        let near = format!("near ({x:.3e}, {y:.3e}, {z:.3e}) m");
        Some(if self.within_parts > 0 {
            format!(
                "crosses itself at {}, the first {near}: repair it in the CAD, the inside is not certain there",
                counted(self.pairs, "pair of facets", "pairs of facets")
            )
        } else {
            format!(
                "has {} that overlap, the first {near}: they are taken as one solid",
                counted(self.parts, "pair of parts", "pairs of parts")
            )
        })
    }
}

impl Surface {
    /// Finds the triangles that cross others; about 4 µs of computing for each triangle.
    pub fn intersections(&self) -> Intersections {
        let leaves = self.bvh.nodes.par_iter().filter(|node| node.count > 0);
        let mut pairs: Vec<[u32; 2]> = leaves.flat_map_iter(|leaf| self.crossing(leaf)).collect();
        pairs.sort_unstable();
        let Some(first) = pairs.first().copied() else { return Intersections::default() };
        let part = self.parts();
        let mut parts = BTreeSet::new();
        let mut within_parts = 0;
        for [a, b] in &pairs {
            let (a, b) = (part[*a as usize], part[*b as usize]);
            within_parts += usize::from(a == b);
            if a != b {
                parts.insert((a.min(b), a.max(b)));
            }
        }
        Intersections {
            pairs: pairs.len(),
            first: Some(first),
            place: Some(self.place(first)),
            parts: parts.len(),
            within_parts,
        }
    }

    /// Returns the pairs that cross of the triangles of a leaf and those of this and later leaves.
    fn crossing(&self, leaf: &Node) -> Vec<[u32; 2]> {
        let own: Vec<Boxed> = self.bvh.leaf(leaf).iter().map(|triangle| self.boxed(*triangle)).collect();
        let mut found = Vec::new();
        let mut stack = [0_u32; STACK];
        let mut held = 1;
        while held > 0 {
            held -= 1;
            let index = stack[held];
            let node = &self.bvh.nodes[index as usize];
            if !overlap((node.low, node.high), (leaf.low, leaf.high)) {
                continue;
            }
            if node.count == 0 {
                stack[held] = index + 1;
                stack[held + 1] = node.first;
                held += 2;
            } else if node.first >= leaf.first {
                for other in self.bvh.leaf(node).iter().map(|triangle| self.boxed(*triangle)) {
                    // Within the leaf itself, each pair once.
                    let is_pair = |own: &&Boxed| node.first > leaf.first || own.number < other.number;
                    let crossing = own
                        .iter()
                        .filter(is_pair)
                        .filter(|own| overlap(own.bounds, other.bounds) && cross(own.corners, other.corners));
                    found.extend(
                        crossing.map(|own| [own.number.min(other.number), own.number.max(other.number)]),
                    );
                }
            }
        }
        found
    }

    fn boxed(&self, number: u32) -> Boxed {
        let corners =
            self.mesh.triangles[number as usize].map(|vertex| (vertex, self.mesh.vertices[vertex as usize]));
        Boxed { number, corners, bounds: bounds(corners.map(|(_, place)| place)) }
    }

    /// Returns the middle of the box that two triangles have in common, m.
    fn place(&self, [a, b]: [u32; 2]) -> DVec3 {
        let (low_a, high_a) = bounds(self.mesh.corners(a as usize));
        let (low_b, high_b) = bounds(self.mesh.corners(b as usize));
        0.5 * (low_a.max(low_b) + high_a.min(high_b))
    }

    /// Returns the number of the connected part of each triangle.
    fn parts(&self) -> Vec<u32> {
        let count = self.mesh.triangles.len();
        let mut part = vec![u32::MAX; count];
        let mut parts = 0;
        let mut reached = Vec::new();
        for seed in 0..count as u32 {
            if part[seed as usize] != u32::MAX {
                continue;
            }
            part[seed as usize] = parts;
            reached.push(seed);
            while let Some(triangle) = reached.pop() {
                let [a, b, c] = self.mesh.triangles[triangle as usize];
                for ends in [[a, b], [b, c], [c, a]] {
                    let mut around = self.around.edge(&self.mesh, ends);
                    // Parts that touch at an edge are not connected by it.
                    let pair = [around.next(), around.next(), around.next()];
                    let [Some(x), Some(y), None] = pair else { continue };
                    for next in [x, y] {
                        if part[next as usize] == u32::MAX {
                            part[next as usize] = parts;
                            reached.push(next);
                        }
                    }
                }
            }
            parts += 1;
        }
        part
    }
}

/// Triangle with its box.
struct Boxed {
    number: u32,
    corners: [Corner; 3],
    bounds: (DVec3, DVec3),
}

fn overlap((low, high): (DVec3, DVec3), (other_low, other_high): (DVec3, DVec3)) -> bool {
    low.cmple(other_high).all() && high.cmpge(other_low).all()
}

fn bounds([a, b, c]: [DVec3; 3]) -> (DVec3, DVec3) {
    (a.min(b).min(c), a.max(b).max(c))
}
