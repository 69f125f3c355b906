//! Tree of boxes around the edges of closed polylines: nearest edge and crossing number.
//!
//! A node holds a stretch of one polyline, halved down to the leaves, or several whole polylines.
//! The ray from a point to +x crosses a stretch on its right an odd number of times exactly if the
//! ends of the stretch are on either side of the ray, so that such a node needs no descent.
//!
//! Distance and sign of each edge are those of [`polygon`], and boxes are left out only beyond
//! rounding: the results are bitwise those of a search through all edges.

use glam::DVec2;

use super::polygon;

/// Most edges that are searched without a tree.
const SMALL: usize = 64;

/// Most edges of a leaf of a tree.
const LEAF: usize = 8;

/// Share of the lengths by which rounding may move a distance or a crossing.
const ROUNDING: f64 = 1e-14;

/// Edges with a tree of boxes.
#[derive(Clone, Debug)]
pub struct EdgeTree {
    /// Both ends of each edge, m, in the order of the leaves.
    edges: Vec<(DVec2, DVec2)>,
    /// Numbers of the edges as given: those of the first polyline, then those of the next.
    numbers: Vec<usize>,
    /// Nodes, the root first, each before its children.
    nodes: Vec<Node>,
    /// Largest rounding of a distance beside its share of the distance, m.
    distance_margin: f64,
    /// Largest rounding of a crossing, m.
    crossing_margin: f64,
}

/// Node: a leaf with edges, or a node with two children, of which the first follows it.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Lower corner of the box, m.
    low: DVec2,
    /// Upper corner of the box, m.
    high: DVec2,
    /// y at both ends of a stretch, m; equal for whole polylines.
    ends: [f64; 2],
    /// First edge of a leaf, otherwise the second child.
    first: usize,
    /// Number of edges of a leaf, otherwise 0.
    count: usize,
}

/// A polyline with the number of its first edge.
type Numbered<'a> = (usize, &'a [DVec2]);

impl EdgeTree {
    /// Builds the tree of closed polylines, at least one, each of at least one point.
    pub fn new(loops: &[Vec<DVec2>]) -> Self {
        let count = loops.iter().map(Vec::len).sum();
        let mut tree = Self {
            edges: Vec::with_capacity(count),
            numbers: Vec::with_capacity(count),
            nodes: Vec::new(),
            distance_margin: 0.0,
            crossing_margin: 0.0,
        };
        let mut first = 0;
        let mut numbered: Vec<Numbered<'_>> = Vec::new();
        for points in loops {
            numbered.push((first, points));
            first += points.len();
        }
        if count <= SMALL {
            numbered.iter().for_each(|polyline| tree.add_edges(polyline));
            tree.add_leaf(0, count, [0.0; 2]);
        } else {
            tree.add_polylines(&mut numbered);
        }
        let (low, high) = tree.bounds();
        tree.distance_margin = ROUNDING * low.distance(high);
        tree.crossing_margin = ROUNDING * low.x.abs().max(high.x.abs());
        tree
    }

    /// Returns the corners of the box around all edges, m.
    pub fn bounds(&self) -> (DVec2, DVec2) {
        (self.nodes[0].low, self.nodes[0].high)
    }

    /// Returns the signed distance by the even-odd rule, m: inside of an odd number of polylines it
    /// is negative.
    pub fn signed_distance(&self, point: DVec2) -> f64 {
        let mut nearest = f64::INFINITY;
        self.search(0, point, &mut nearest);
        let distance = nearest.sqrt();
        if self.is_crossed(0, point) { -distance } else { distance }
    }

    /// Calls a function with the number of each edge whose box meets a box.
    pub fn each_near(&self, (low, high): (DVec2, DVec2), found: &mut impl FnMut(usize)) {
        let mut open = vec![0];
        while let Some(index) = open.pop() {
            let node = self.nodes[index];
            if !(node.low.cmple(high) & low.cmple(node.high)).all() {
                continue;
            }
            if node.count == 0 {
                open.extend([node.first, index + 1]);
            }
            for at in node.edges() {
                let (a, b) = self.edges[at];
                if (a.min(b).cmple(high) & low.cmple(a.max(b))).all() {
                    found(self.numbers[at]);
                }
            }
        }
    }

    /// Lowers the squared distance to that of the nearest edge of a node, m².
    fn search(&self, index: usize, point: DVec2, nearest: &mut f64) {
        let node = &self.nodes[index];
        for at in node.edges() {
            let (a, b) = self.edges[at];
            *nearest = nearest.min(polygon::squared_distance(point, a, b));
        }
        if node.count > 0 {
            return;
        }
        let children = [index + 1, node.first].map(|child| (self.nodes[child].distance(point), child));
        let [near, far] = if children[1].0 < children[0].0 { [1, 0] } else { [0, 1] };
        for (distance, child) in [children[near], children[far]] {
            let least = distance * (1.0 - ROUNDING) - self.distance_margin;
            if least <= 0.0 || least * least <= *nearest {
                self.search(child, point, nearest);
            }
        }
    }

    /// Returns true if the ray from a point to +x crosses an odd number of edges of a node.
    fn is_crossed(&self, index: usize, point: DVec2) -> bool {
        let node = &self.nodes[index];
        if point.y < node.low.y || point.y >= node.high.y || point.x > node.high.x + self.crossing_margin {
            return false;
        }
        if point.x < node.low.x - self.crossing_margin {
            return (node.ends[0] > point.y) != (node.ends[1] > point.y);
        }
        if node.count == 0 {
            return self.is_crossed(index + 1, point) != self.is_crossed(node.first, point);
        }
        let crossed = |at: &usize| polygon::crosses_ray(point, self.edges[*at].0, self.edges[*at].1);
        node.edges().filter(crossed).count() % 2 == 1
    }

    fn add_edges(&mut self, (first, points): &Numbered<'_>) {
        let edge = |index: usize| (points[index], points[(index + 1) % points.len()]);
        self.edges.extend((0..points.len()).map(edge));
        self.numbers.extend(*first..first + points.len());
    }

    /// Adds a node of polylines. Their order is that of their centres along the longer axis.
    fn add_polylines(&mut self, polylines: &mut [Numbered<'_>]) {
        if let [polyline] = polylines {
            let from = self.edges.len();
            self.add_edges(polyline);
            self.add_stretch(from, self.edges.len());
            return;
        }
        let centre = |(_, points): &Numbered<'_>| {
            let (low, high) = bounds_of(points.iter().copied());
            low + high
        };
        let (low, high) = bounds_of(polylines.iter().map(centre));
        let axis = (high - low).max_position();
        polylines.sort_by(|a, b| centre(a)[axis].total_cmp(&centre(b)[axis]));
        let parent = self.add_parent([0.0; 2]);
        let (left, right) = polylines.split_at_mut(polylines.len() / 2);
        self.add_polylines(left);
        self.nodes[parent].first = self.nodes.len();
        self.add_polylines(right);
        self.enclose(parent);
    }

    /// Adds a node of the edges `from..to` of one polyline.
    fn add_stretch(&mut self, from: usize, to: usize) {
        let ends = [self.edges[from].0.y, self.edges[to - 1].1.y];
        if to - from <= LEAF {
            self.add_leaf(from, to, ends);
            return;
        }
        let parent = self.add_parent(ends);
        let middle = usize::midpoint(from, to);
        self.add_stretch(from, middle);
        self.nodes[parent].first = self.nodes.len();
        self.add_stretch(middle, to);
        self.enclose(parent);
    }

    fn add_leaf(&mut self, from: usize, to: usize, ends: [f64; 2]) {
        let (low, high) = bounds_of(self.edges[from..to].iter().flat_map(|(a, b)| [*a, *b]));
        self.nodes.push(Node { low, high, ends, first: from, count: to - from });
    }

    /// Adds a node whose children and box follow.
    fn add_parent(&mut self, ends: [f64; 2]) -> usize {
        self.nodes.push(Node { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, ends, first: 0, count: 0 });
        self.nodes.len() - 1
    }

    /// Sets the box of a node to that of its children.
    fn enclose(&mut self, parent: usize) {
        let [a, b] = [parent + 1, self.nodes[parent].first].map(|child| self.nodes[child]);
        let node = &mut self.nodes[parent];
        (node.low, node.high) = (a.low.min(b.low), a.high.max(b.high));
    }
}

impl Node {
    /// Returns the edges of a leaf; none of another node.
    fn edges(&self) -> std::ops::Range<usize> {
        if self.count == 0 { 0..0 } else { self.first..self.first + self.count }
    }

    /// Returns the distance to the box, m; 0 inside.
    fn distance(&self, point: DVec2) -> f64 {
        (self.low - point).max(point - self.high).max(DVec2::ZERO).length()
    }
}

/// Returns the corners of the box around points, m.
pub fn bounds_of(points: impl Iterator<Item = DVec2>) -> (DVec2, DVec2) {
    let start = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    points.fold(start, |(low, high), point| (low.min(point), high.max(point)))
}

#[cfg(test)]
mod tests {
    use std::f64::consts::TAU;

    use super::*;

    /// Uniform numbers from 0 to 1, by shifts and exclusive or.
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        }
    }

    /// A star with a radius that varies at random by a share.
    fn star(random: &mut Random, (centre, radius): (DVec2, f64), count: usize, roughness: f64) -> Vec<DVec2> {
        let mut point = |index: usize| {
            let angle = TAU * index as f64 / count as f64;
            centre + radius * (1.0 - roughness * random.next()) * DVec2::from_angle(angle)
        };
        (0..count).map(&mut point).collect()
    }

    /// A comb with edges along the axes, whose teeth are long.
    fn comb(teeth: usize) -> Vec<DVec2> {
        let mut points = vec![DVec2::new(0.0, -1.0)];
        for tooth in 0..teeth {
            let x = tooth as f64;
            points.extend([[x, 0.0], [x, 30.0], [x + 0.5, 30.0], [x + 0.5, 0.0]].map(DVec2::from));
        }
        points.push(DVec2::new(teeth as f64 - 0.5, -1.0));
        points
    }

    /// Closed polylines of every kind: few and many points, holes, far from the origin.
    fn cases(random: &mut Random) -> Vec<Vec<Vec<DVec2>>> {
        let mut holes = vec![star(random, (DVec2::ZERO, 50.0), 300, 0.01)];
        for index in 0..100 {
            let centre = DVec2::new(f64::from(index % 10) - 4.5, f64::from(index / 10) - 4.5) * 6.0;
            holes.push(star(random, (centre, 2.5), 3 + index as usize % 40, 0.3));
        }
        vec![
            vec![star(random, (DVec2::ZERO, 1.0), 12, 0.5)],
            vec![star(random, (DVec2::ZERO, 1e-3), 1000, 0.0)],
            vec![star(random, (DVec2::new(-1e4, 3e3), 2.0), 997, 0.7)],
            vec![comb(60).into_iter().rev().collect()],
            holes,
        ]
    }

    /// Points about polylines: anywhere, on edges, level with corners, and in corners.
    fn queries(random: &mut Random, loops: &[Vec<DVec2>]) -> Vec<DVec2> {
        let (low, high) = bounds_of(loops.iter().flatten().copied());
        let (middle, size) = ((low + high) / 2.0, high - low);
        let mut found = Vec::new();
        for _ in 0..500 {
            let anywhere = middle + 2.0 * size * (DVec2::new(random.next(), random.next()) - 0.5);
            let points = &loops[(random.next() * loops.len() as f64) as usize];
            let at = (random.next() * points.len() as f64) as usize;
            let (a, b) = (points[at], points[(at + 1) % points.len()]);
            let on_edge = a.lerp(b, random.next());
            let beside = 1e-9 * size.length() * DVec2::from_angle(TAU * random.next());
            found.extend([anywhere, on_edge, on_edge + beside, a, DVec2::new(anywhere.x, a.y)]);
        }
        found
    }

    #[test]
    fn distance_and_sign_are_those_of_a_search_through_all_edges() {
        let mut random = Random(0x9e37_79b9_7f4a_7c15);
        for loops in cases(&mut random) {
            let tree = EdgeTree::new(&loops);
            for point in queries(&mut random, &loops) {
                let all = loops.iter().map(|points| polygon::polygon(point, points));
                let nearest = all.clone().map(f64::abs).fold(f64::INFINITY, f64::min);
                let is_inside = all.filter(|distance| distance.is_sign_negative()).count() % 2 == 1;
                let found = tree.signed_distance(point);
                assert_eq!(found.abs().to_bits(), nearest.to_bits(), "{found}, must be {nearest} at {point}");
                assert_eq!(found.is_sign_negative(), is_inside, "{found} at {point}");
            }
        }
    }

    #[test]
    fn few_edges_are_searched_of_many() {
        let mut random = Random(0x2545_f491_4f6c_dd1d);
        let tree = EdgeTree::new(&[star(&mut random, (DVec2::ZERO, 1.0), 100_000, 1e-5)]);
        for _ in 0..100 {
            let point = DVec2::from_angle(TAU * random.next()) * (0.9 + 0.2 * random.next());
            let reach = DVec2::splat(1e-3);
            let mut count = 0;
            tree.each_near((point - reach, point + reach), &mut |_| count += 1);
            assert!(count < 100, "{count} edges within 1e-3 of {point}");
        }
    }
}
