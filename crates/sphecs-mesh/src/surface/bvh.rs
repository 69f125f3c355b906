//! Tree of boxes around the triangles of a surface.
//!
//! Split at the median of the centroids along the longest axis of their box, ties by the number of
//! the triangle, so that the tree is the same on every machine and for any number of threads.

use glam::{DMat3, DVec3};

use crate::triangulation::Triangulation;

/// Most triangles of a leaf.
const LEAF: usize = 4;

/// Triangles below which a subtree is built by one thread, and the radius of a node is exact.
const SMALL: usize = 4096;

/// Nodes that a search holds at most. The tree is balanced: its depth is at most 32.
pub(crate) const STACK: usize = 64;

/// Node: a leaf with triangles, or a node with two children.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Node {
    /// Lower corner of the box, m.
    pub low: DVec3,
    /// Upper corner of the box, m.
    pub high: DVec3,
    /// Index into the order of the first triangle of a leaf; otherwise the second child. The first
    /// child follows its parent.
    pub first: u32,
    /// Number of triangles of a leaf, otherwise 0.
    pub count: u32,
}

/// Expansion of the solid angle of the triangles of a node.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Moments {
    /// Centroid p weighted by area, m.
    pub centre: DVec3,
    /// Largest distance of a vertex from the centroid, or a bound of it, m.
    pub radius: f64,
    /// Sum A of the area vectors, m².
    pub dipole: DVec3,
    /// Sum of (x − p) Aᵀ over the triangles, m³.
    pub first: DMat3,
    /// Area, m².
    pub area: f64,
}

/// Tree of boxes with the order of the triangles in its leaves.
#[derive(Clone, Debug)]
pub(crate) struct Bvh {
    /// Nodes, the root first, each before its children.
    pub nodes: Vec<Node>,
    /// Expansions of the nodes.
    pub moments: Vec<Moments>,
    /// Numbers of the triangles in the order of the leaves.
    pub order: Vec<u32>,
}

impl Bvh {
    /// Builds the tree of some triangles, at least one.
    pub(crate) fn new(mesh: &Triangulation, triangles: impl Iterator<Item = u32>) -> Self {
        let mut items: Vec<Item> = triangles
            .map(|number| {
                let [a, b, c] = mesh.corners(number as usize);
                Item { centroid: (a + b + c) / 3.0, number }
            })
            .collect();
        let count = node_count(items.len());
        let node = Node { low: DVec3::ZERO, high: DVec3::ZERO, first: 0, count: 0 };
        let moments =
            Moments { centre: DVec3::ZERO, radius: 0.0, dipole: DVec3::ZERO, first: DMat3::ZERO, area: 0.0 };
        let (mut nodes, mut moments) = (vec![node; count], vec![moments; count]);
        Subtree { nodes: &mut nodes, moments: &mut moments, node: 0, items: &mut items, first: 0 }
            .build(mesh);
        Self { nodes, moments, order: items.iter().map(|item| item.number).collect() }
    }

    /// Returns the numbers of the triangles of a leaf.
    pub(crate) fn leaf(&self, node: &Node) -> &[u32] {
        &self.order[node.first as usize..(node.first + node.count) as usize]
    }
}

#[derive(Clone, Copy)]
struct Item {
    centroid: DVec3,
    number: u32,
}

/// Returns the number of nodes of a tree of `count` triangles.
fn node_count(count: usize) -> usize {
    if count <= LEAF { 1 } else { 1 + node_count(count / 2) + node_count(count - count / 2) }
}

/// Part of a tree that is being built.
struct Subtree<'a> {
    nodes: &'a mut [Node],
    moments: &'a mut [Moments],
    /// Index of the first of `nodes` in the tree.
    node: usize,
    items: &'a mut [Item],
    /// Index of the first of `items` in the order of the tree.
    first: usize,
}

impl Subtree<'_> {
    fn build(self, mesh: &Triangulation) {
        let count = self.items.len();
        let (root, nodes) = self.nodes.split_first_mut().expect("a tree has a node");
        let (root_moments, moments) = self.moments.split_first_mut().expect("a tree has a node");
        if count <= LEAF {
            self.items.sort_unstable_by_key(|item| item.number);
            *root = leaf(mesh, self.items, self.first);
            *root_moments = leaf_moments(mesh, self.items);
            root_moments.radius = radius(mesh, self.items, root_moments.centre);
            return;
        }
        let half = count / 2;
        split(self.items, half);
        let (left_items, right_items) = self.items.split_at_mut(half);
        let left_nodes = node_count(half);
        let (left, right) = nodes.split_at_mut(left_nodes);
        let (left_moments, right_moments) = moments.split_at_mut(left_nodes);
        let second = self.node + 1 + left_nodes;
        let left = Subtree {
            nodes: left,
            moments: left_moments,
            node: self.node + 1,
            items: left_items,
            first: self.first,
        };
        let right = Subtree {
            nodes: right,
            moments: right_moments,
            node: second,
            items: right_items,
            first: self.first + half,
        };
        if count <= SMALL {
            left.build(mesh);
            right.build(mesh);
        } else {
            rayon::join(|| left.build(mesh), || right.build(mesh));
        }
        let (a, b) = (&nodes[0], &nodes[left_nodes]);
        *root = Node { low: a.low.min(b.low), high: a.high.max(b.high), first: second as u32, count: 0 };
        *root_moments = joined(&moments[0], &moments[left_nodes]);
        if count <= SMALL {
            root_moments.radius = radius(mesh, self.items, root_moments.centre);
        } else {
            let centre = root_moments.centre;
            let corner = (centre - root.low).max(root.high - centre).length();
            root_moments.radius = root_moments.radius.min(corner);
        }
    }
}

/// Moves the `half` items with the smallest centroids along the longest axis to the front.
fn split(items: &mut [Item], half: usize) {
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) =
        items.iter().fold(start, |(low, high), item| (low.min(item.centroid), high.max(item.centroid)));
    let axis = (high - low).max_position();
    items.select_nth_unstable_by(half, |a, b| {
        a.centroid[axis].total_cmp(&b.centroid[axis]).then(a.number.cmp(&b.number))
    });
}

fn leaf(mesh: &Triangulation, items: &[Item], first: usize) -> Node {
    let corners = items.iter().flat_map(|item| mesh.corners(item.number as usize));
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = corners.fold(start, |(low, high), corner| (low.min(corner), high.max(corner)));
    Node { low, high, first: first as u32, count: items.len() as u32 }
}

fn leaf_moments(mesh: &Triangulation, items: &[Item]) -> Moments {
    let areas = items.iter().map(|item| (item.centroid, mesh.area_vector(item.number as usize)));
    let area: f64 = areas.clone().map(|(_, vector)| vector.length()).sum();
    let centre = if area > 0.0 {
        areas.clone().map(|(centroid, vector)| centroid * vector.length()).sum::<DVec3>() / area
    } else {
        items.iter().map(|item| item.centroid).sum::<DVec3>() / items.len() as f64
    };
    let dipole = areas.clone().map(|(_, vector)| vector).sum();
    let first = areas.map(|(centroid, vector)| outer(centroid - centre, vector)).sum();
    Moments { centre, radius: 0.0, dipole, first, area }
}

/// Returns the moments of two nodes about their common centroid, with a bound of the radius.
fn joined(a: &Moments, b: &Moments) -> Moments {
    let area = a.area + b.area;
    let share = if area > 0.0 { b.area / area } else { 0.5 };
    let centre = a.centre + share * (b.centre - a.centre);
    let shifted = |child: &Moments| child.first + outer(child.centre - centre, child.dipole);
    let reach = |child: &Moments| child.centre.distance(centre) + child.radius;
    Moments {
        centre,
        radius: reach(a).max(reach(b)),
        dipole: a.dipole + b.dipole,
        first: shifted(a) + shifted(b),
        area,
    }
}

/// Returns u vᵀ.
fn outer(u: DVec3, v: DVec3) -> DMat3 {
    DMat3::from_cols(u * v.x, u * v.y, u * v.z)
}

fn radius(mesh: &Triangulation, items: &[Item], centre: DVec3) -> f64 {
    let corners = items.iter().flat_map(|item| mesh.corners(item.number as usize));
    corners.map(|corner| corner.distance_squared(centre)).fold(0.0, f64::max).sqrt()
}
