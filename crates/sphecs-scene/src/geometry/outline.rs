//! Closed polylines in 2D: the region inside of an odd number of them.

use glam::DVec2;

use super::edge_tree::{self, EdgeTree};
use super::polygon;

/// Most edges that are all candidates for straight walls; of more it is the longest stretches.
const MOST_STRAIGHT: usize = 1000;

/// Distance from a line, as a share of the diagonal, within which edges are one straight stretch.
const STRAIGHTNESS: f64 = 1e-9;

/// Distance from a line, as a share of the diagonal, within which a polyline has no area.
const FLATNESS: f64 = 1e-12;

/// The region inside of an odd number of closed polylines.
#[derive(Clone, Debug)]
pub struct Outline {
    loops: Vec<Vec<DVec2>>,
    tree: EdgeTree,
    straight: Vec<(DVec2, DVec2)>,
}

impl Outline {
    /// Returns the region of closed polylines, at least one, each of at least three points, m. The
    /// last point of each is followed by its first, and no point by an equal one.
    pub fn new(loops: Vec<Vec<DVec2>>) -> Self {
        let tree = EdgeTree::new(&loops);
        let straight = straight(&loops);
        Self { loops, tree, straight }
    }

    /// Returns the signed distance, m; exact on both sides.
    pub fn signed_distance(&self, point: DVec2) -> f64 {
        self.tree.signed_distance(point)
    }

    /// Returns the corners of the bounding box, m.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        self.tree.bounds()
    }

    /// Returns the polylines, m.
    pub fn loops(&self) -> &[Vec<DVec2>] {
        &self.loops
    }

    /// Returns both ends of the straight stretches that may be walls, m. Of more than a thousand
    /// edges these are the stretches of at least a thousandth of the perimeter.
    pub fn straight(&self) -> &[(DVec2, DVec2)] {
        &self.straight
    }

    /// Returns for each polyline whether the region is outside of it, as at a hole.
    pub fn holes(&self) -> Vec<bool> {
        let boxes: Vec<_> =
            self.loops.iter().map(|points| edge_tree::bounds_of(points.iter().copied())).collect();
        let is_inside = |point: DVec2, other: usize| {
            let (low, high) = boxes[other];
            (low.cmple(point) & point.cmple(high)).all() && polygon::polygon(point, &self.loops[other]) < 0.0
        };
        let depth = |index: usize| {
            let point = self.loops[index][0];
            (0..self.loops.len()).filter(|other| *other != index && is_inside(point, *other)).count()
        };
        (0..self.loops.len()).map(|index| depth(index) % 2 == 1).collect()
    }

    /// Returns the area, m².
    pub fn area(&self) -> f64 {
        let part = |(points, is_hole): (&Vec<DVec2>, bool)| {
            let area = polygon::signed_area(points).abs();
            if is_hole { -area } else { area }
        };
        self.loops.iter().zip(self.holes()).map(part).sum()
    }

    /// Returns up to `most` pairs of edges that cross, touch without being neighbours or lie on
    /// each other. Edges are numbered through all polylines, from 0.
    pub fn crossings(&self, most: usize) -> Vec<(usize, usize)> {
        let mut crossings = Vec::new();
        let mut number = 0;
        for points in &self.loops {
            let first = number;
            for index in 0..points.len() {
                let edge = edge_of(points, index);
                let next = first + (index + 1) % points.len();
                let previous = first + (index + points.len() - 1) % points.len();
                let mut found = Vec::new();
                if folds_back(edge, edge_of(points, index + 1)) {
                    found.push((number.min(next), number.max(next)));
                }
                self.tree.each_near((edge.0.min(edge.1), edge.0.max(edge.1)), &mut |other| {
                    let is_pair = other > number && other != next && other != previous;
                    if is_pair && polygon::edges_touch(edge, self.edge(other)) {
                        found.push((number, other));
                    }
                });
                found.sort_unstable();
                crossings.extend(found);
                if crossings.len() >= most {
                    crossings.truncate(most);
                    return crossings;
                }
                number += 1;
            }
        }
        crossings
    }

    /// Returns polyline and place in it of an edge.
    pub fn place(&self, mut edge: usize) -> (usize, usize) {
        for (number, points) in self.loops.iter().enumerate() {
            if edge < points.len() {
                return (number, edge);
            }
            edge -= points.len();
        }
        (0, 0)
    }

    fn edge(&self, number: usize) -> (DVec2, DVec2) {
        let (polyline, index) = self.place(number);
        edge_of(&self.loops[polyline], index)
    }
}

/// Returns true if all points are on a line.
pub fn is_flat(points: &[DVec2]) -> bool {
    let (low, high) = edge_tree::bounds_of(points.iter().copied());
    let far = |from: DVec2| {
        points.iter().copied().max_by(|a, b| from.distance(*a).total_cmp(&from.distance(*b))).unwrap_or(from)
    };
    let (from, to) = (points[0], far(points[0]));
    let along = (to - from).normalize_or_zero();
    points.iter().all(|point| along.perp_dot(*point - from).abs() <= FLATNESS * low.distance(high))
}

fn edge_of(points: &[DVec2], index: usize) -> (DVec2, DVec2) {
    (points[index % points.len()], points[(index + 1) % points.len()])
}

/// Returns true if an edge lies on the one before it.
fn folds_back((a, b): (DVec2, DVec2), (_, c): (DVec2, DVec2)) -> bool {
    (b - a).perp_dot(c - b) == 0.0 && (b - a).dot(c - b) < 0.0
}

/// Returns all edges of few; of many the stretches on a line that are at least a thousandth of the
/// perimeter.
fn straight(loops: &[Vec<DVec2>]) -> Vec<(DVec2, DVec2)> {
    let edges = loops.iter().flat_map(|points| (0..points.len()).map(|index| edge_of(points, index)));
    let edges: Vec<(DVec2, DVec2)> = edges.collect();
    if edges.len() <= MOST_STRAIGHT {
        return edges;
    }
    let (low, high) = edge_tree::bounds_of(edges.iter().map(|edge| edge.0));
    let tolerance = STRAIGHTNESS * low.distance(high);
    let perimeter: f64 = edges.iter().map(|(a, b)| a.distance(*b)).sum();
    let mut stretches: Vec<(DVec2, DVec2)> = Vec::new();
    for (a, b) in edges {
        if let Some(last) = stretches.last_mut() {
            let along = (last.1 - last.0).normalize_or_zero();
            let is_straight = along.perp_dot(b - a).abs() <= tolerance && along.dot(b - a) > 0.0;
            if last.1 == a && is_straight {
                last.1 = b;
                continue;
            }
        }
        stretches.push((a, b));
    }
    stretches.retain(|(a, b)| a.distance(*b) * MOST_STRAIGHT as f64 >= perimeter);
    stretches
}
