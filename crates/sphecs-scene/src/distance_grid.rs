//! Curves of equal distance from a surface in a plane, by marching squares.
//!
//! The squares are those of Lorensen & Cline (1987) in two dimensions.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::iter::{IntoParallelIterator, ParallelIterator};

/// Signed distances on the nodes of a grid in a plane, m.
pub struct DistanceGrid {
    low: DVec3,
    cell: f64,
    counts: [usize; 2],
    distances: Vec<f64>,
}

/// An edge of the grid: its first node and its direction, 0 along x and 1 along y.
type Edge = ([usize; 2], usize);

impl DistanceGrid {
    /// Evaluates a signed distance, m, on a grid with cells of a size from one corner to another.
    pub fn new(low: DVec3, high: DVec3, cell: f64, distance: impl Fn(DVec3) -> f64 + Sync) -> Self {
        let counts = [0, 1].map(|axis| ((high[axis] - low[axis]) / cell).ceil() as usize + 1);
        let node = |index: usize| {
            low + cell * DVec3::new((index % counts[0]) as f64, (index / counts[0]) as f64, 0.0)
        };
        let nodes = (0..counts[0] * counts[1]).into_par_iter();
        let distances = nodes.map(|index| distance(node(index))).collect();
        Self { low, cell, counts, distances }
    }

    fn distance(&self, node: [usize; 2]) -> f64 {
        self.distances[node[0] + node[1] * self.counts[0]]
    }

    /// Returns the point of an edge at which the distance is `level`.
    fn crossing(&self, (node, axis): Edge, level: f64) -> DVec3 {
        let mut end = node;
        end[axis] += 1;
        let (from, to) = (self.distance(node) - level, self.distance(end) - level);
        let mut place = DVec3::new(node[0] as f64, node[1] as f64, 0.0);
        place[axis] += from / (from - to);
        self.low + self.cell * place
    }

    /// Returns the curves on which the distance is `level`, m; a closed curve ends at its first
    /// point.
    pub fn curves(&self, level: f64) -> Vec<Vec<DVec3>> {
        let mut links: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
        for y in 0..self.counts[1] - 1 {
            for x in 0..self.counts[0] - 1 {
                for (from, to) in self.segments([x, y], level).into_iter().flatten() {
                    links.entry(from).or_default().push(to);
                    links.entry(to).or_default().push(from);
                }
            }
        }
        let mut curves = Vec::new();
        // Open curves begin at an edge with one link; what remains is closed.
        while let Some(start) = links
            .iter()
            .find(|(_, to)| to.len() == 1)
            .or_else(|| links.iter().find(|(_, to)| !to.is_empty()))
            .map(|(edge, _)| *edge)
        {
            let mut curve = vec![self.crossing(start, level)];
            let mut at = start;
            while let Some(next) = links.get_mut(&at).and_then(Vec::pop) {
                if let Some(back) = links.get_mut(&next) {
                    back.retain(|edge| *edge != at);
                }
                curve.push(self.crossing(next, level));
                at = next;
            }
            links.retain(|_, to| !to.is_empty());
            curves.push(curve);
        }
        curves
    }

    /// Returns the segments of a curve in a cell, between its edges.
    fn segments(&self, [x, y]: [usize; 2], level: f64) -> [Option<(Edge, Edge)>; 2] {
        let corners = [[x, y], [x + 1, y], [x + 1, y + 1], [x, y + 1]];
        let inside = corners.map(|node| self.distance(node) < level);
        let edges = [([x, y], 0), ([x + 1, y], 1), ([x, y + 1], 0), ([x, y], 1)];
        let crossed: Vec<Edge> =
            (0..4).filter(|side| inside[*side] != inside[(side + 1) % 4]).map(|side| edges[side]).collect();
        match crossed[..] {
            [a, b] => [Some((a, b)), None],
            [a, b, c, d] => {
                let middle = corners.iter().map(|node| self.distance(*node)).sum::<f64>() / 4.0;
                // The middle joins the pair of corners on its own side.
                if (middle < level) == inside[0] {
                    [Some((a, b)), Some((c, d))]
                } else {
                    [Some((d, a)), Some((b, c))]
                }
            }
            _ => [None, None],
        }
    }
}

/// Returns points at equal distances of about `spacing` along a curve, m.
pub fn spread(curve: &[DVec3], spacing: f64) -> Vec<DVec3> {
    let lengths = curve.windows(2).map(|pair| pair[0].distance(pair[1]));
    let total: f64 = lengths.clone().sum();
    let count = (total / spacing).round().max(1.0);
    let step = total / count;
    let mut points = Vec::new();
    let (mut passed, mut next) = (0.0, 0.5 * step);
    for (pair, length) in curve.windows(2).zip(lengths) {
        while next <= passed + length && points.len() < count as usize {
            points.push(pair[0].lerp(pair[1], (next - passed) / length.max(f64::MIN_POSITIVE)));
            next += step;
        }
        passed += length;
    }
    points
}
