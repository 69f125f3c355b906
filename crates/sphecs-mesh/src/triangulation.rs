//! Indexed triangles with groups, on which repair and queries work.

use glam::DVec3;

/// Triangles of a surface, in one unit of length.
#[derive(Clone, Debug, Default)]
pub(crate) struct Triangulation {
    /// Positions, m.
    pub vertices: Vec<DVec3>,
    /// Indices into `vertices`.
    pub triangles: Vec<[u32; 3]>,
    /// Index of the group of each triangle.
    pub groups: Vec<u16>,
}

impl Triangulation {
    /// Returns the corners of a triangle, m.
    pub(crate) fn corners(&self, triangle: usize) -> [DVec3; 3] {
        let [a, b, c] = self.triangles[triangle];
        [self.vertices[a as usize], self.vertices[b as usize], self.vertices[c as usize]]
    }

    /// Returns the area of a triangle times its unit normal, m².
    pub(crate) fn area_vector(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        0.5 * (b - a).cross(c - a)
    }

    /// Returns the lower and the upper corner of the box around all vertices, m.
    pub(crate) fn bounds(&self) -> (DVec3, DVec3) {
        let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        self.vertices.iter().fold(start, |(low, high), vertex| (low.min(*vertex), high.max(*vertex)))
    }

    /// Returns the length of the diagonal of the box, m; 0 without vertices.
    pub(crate) fn diagonal(&self) -> f64 {
        let (low, high) = self.bounds();
        if self.vertices.is_empty() { 0.0 } else { low.distance(high) }
    }

    /// Keeps the triangles for which `keep`, called with their numbers, is true.
    pub(crate) fn retain(&mut self, keep: impl Fn(usize) -> bool) {
        let mut kept = 0;
        for triangle in (0..self.triangles.len()).filter(|triangle| keep(*triangle)) {
            self.triangles[kept] = self.triangles[triangle];
            self.groups[kept] = self.groups[triangle];
            kept += 1;
        }
        self.triangles.truncate(kept);
        self.groups.truncate(kept);
    }

    /// Drops the vertices that no triangle has; the order of the others stays.
    pub(crate) fn drop_unused_vertices(&mut self) {
        let mut is_used = vec![false; self.vertices.len()];
        for vertex in self.triangles.iter().flatten() {
            is_used[*vertex as usize] = true;
        }
        let mut numbers = vec![0_u32; self.vertices.len()];
        let mut kept = 0;
        for (vertex, _) in is_used.iter().enumerate().filter(|(_, is_used)| **is_used) {
            numbers[vertex] = kept;
            self.vertices[kept as usize] = self.vertices[vertex];
            kept += 1;
        }
        self.vertices.truncate(kept as usize);
        for vertex in self.triangles.iter_mut().flatten() {
            *vertex = numbers[*vertex as usize];
        }
    }
}
