//! Surface of a wall inside a region as triangles, in 3D.
//!
//! The box around both is divided into cubes, which are left out where the signed distance is
//! larger than they are, down to a quarter of a spacing. Each is cut into six tetrahedra, in which
//! the surface is a triangle or two: marching tetrahedra, Payne & Toga (1990). The corners are
//! found on the edges by bisection, and the region cuts the triangles. A triangle across an edge of
//! the wall is replaced by its projections on the faces beside it, which end at the edge. Crates
//! for isosurfaces work on dense grids, round the edges off, and none cuts at a region.

use glam::{DVec3, IVec3};

/// Corners of the six tetrahedra of a cube, along its diagonal; bit k of a corner is its place on
/// axis k.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

/// Place of the box in the grid, in cells: surfaces at round coordinates do not pass through nodes.
const SHIFT: DVec3 = DVec3::new(0.317, 0.271, 0.353);

/// Cosine of the largest angle between the normals at the corners of a triangle on one face.
const SMOOTH: f64 = 0.9;

/// Depth in the region that a triangle must reach, in cells: what lies on the border is not in it.
const INSIDE: f64 = 4e-3;

/// Step of the differences for a normal, in cells.
const STEP: f64 = 1e-3;

/// A signed distance, m.
pub type Distance<'a> = &'a (dyn Fn(DVec3) -> f64 + Sync);

/// Surface and region of a contour.
pub struct Contour<'a> {
    /// Signed distance whose zero is the surface, m.
    pub surface: Distance<'a>,
    /// Signed distance of the region, negative inside, m.
    pub region: Distance<'a>,
    /// Lower corner of a box around the surface in the region, m.
    pub low: DVec3,
    /// Size of the smallest cubes, m.
    pub cell: f64,
}

impl Contour<'_> {
    /// Returns the triangles of the surface up to the corner `high` of the box, m.
    pub fn triangles(&self, high: DVec3) -> Vec<[DVec3; 3]> {
        let cells = ((high - self.low) / self.cell).max_element().max(1.0);
        let size = (cells.ceil() as u32 + 1).next_power_of_two() as i32;
        let mut found = Vec::new();
        self.divide((IVec3::ZERO, size), high, &mut found);
        found
    }

    fn point(&self, corner: IVec3) -> DVec3 {
        self.low + self.cell * (corner.as_dvec3() - SHIFT)
    }

    /// Adds the triangles in a cube of `size` cells at a corner.
    fn divide(&self, (corner, size): (IVec3, i32), high: DVec3, found: &mut Vec<[DVec3; 3]>) {
        let low = self.point(corner);
        if low.cmpgt(high).any() {
            return;
        }
        let half = 0.5 * self.cell * f64::from(size);
        let middle = low + DVec3::splat(half);
        // Distances are exact or too small, so a cube that is left out has no surface.
        let reach = 1.001 * half * 3.0_f64.sqrt();
        if (self.surface)(middle).abs() > reach || (self.region)(middle) > reach {
            return;
        }
        if size == 1 {
            self.march(corner, found);
            return;
        }
        for index in 0..8 {
            let step = IVec3::new(index & 1, index >> 1 & 1, index >> 2) * (size / 2);
            self.divide((corner + step, size / 2), high, found);
        }
    }

    /// Adds the triangles in the tetrahedra of a cell.
    fn march(&self, corner: IVec3, found: &mut Vec<[DVec3; 3]>) {
        let corners: [DVec3; 8] = std::array::from_fn(|at| {
            self.point(corner + IVec3::new(at as i32 & 1, at as i32 >> 1 & 1, at as i32 >> 2))
        });
        let is_inside = corners.map(|corner| (self.surface)(corner) < 0.0);
        for tetrahedron in TETRAHEDRA {
            let (inside, outside): (Vec<usize>, Vec<usize>) =
                tetrahedron.into_iter().partition(|corner| is_inside[*corner]);
            let cross = |a: usize, b: usize| self.crossing(corners[a], corners[b]);
            match (&inside[..], &outside[..]) {
                (&[a], &[b, c, d]) | (&[b, c, d], &[a]) => {
                    self.add([cross(a, b), cross(a, c), cross(a, d)], found);
                }
                (&[a, b], &[c, d]) => {
                    let [ac, ad, bc, bd] = [cross(a, c), cross(a, d), cross(b, c), cross(b, d)];
                    self.add([ac, ad, bd], found);
                    self.add([ac, bd, bc], found);
                }
                _ => {}
            }
        }
    }

    /// Returns the point of the surface between two points on different sides of it, m.
    fn crossing(&self, a: DVec3, b: DVec3) -> DVec3 {
        let side = (self.surface)(a) < 0.0;
        let (mut low, mut high) = (0.0, 1.0);
        for _ in 0..40 {
            let middle = 0.5 * (low + high);
            if ((self.surface)(a.lerp(b, middle)) < 0.0) == side {
                low = middle;
            } else {
                high = middle;
            }
        }
        a.lerp(b, 0.5 * (low + high))
    }

    /// Returns the normal at a point of the surface.
    fn normal(&self, point: DVec3) -> DVec3 {
        let step = STEP * self.cell;
        let slope = |axis: DVec3| (self.surface)(point + step * axis) - (self.surface)(point - step * axis);
        DVec3::from(DVec3::AXES.map(slope)).normalize_or_zero()
    }

    /// Adds a triangle, or its projections on the faces beside an edge.
    fn add(&self, triangle: [DVec3; 3], found: &mut Vec<[DVec3; 3]>) {
        let normals = triangle.map(|corner| self.normal(corner));
        let mut faces: Vec<(DVec3, DVec3)> = Vec::with_capacity(3);
        for (corner, normal) in triangle.into_iter().zip(normals) {
            if faces.iter().all(|(_, other)| other.dot(normal) < SMOOTH) {
                faces.push((corner, normal));
            }
        }
        if faces.len() == 1 {
            self.clip(triangle, found);
            return;
        }
        for (at, normal) in faces {
            self.clip(triangle.map(|corner| corner - normal * (corner - at).dot(normal)), found);
        }
    }

    /// Adds the part of a triangle in the region.
    fn clip(&self, triangle: [DVec3; 3], found: &mut Vec<[DVec3; 3]>) {
        let beyond = triangle.map(|corner| (self.region)(corner));
        let mut kept: Vec<DVec3> = Vec::with_capacity(4);
        for at in 0..3 {
            let next = (at + 1) % 3;
            if beyond[at] <= 0.0 {
                kept.push(triangle[at]);
            }
            if (beyond[at] <= 0.0) != (beyond[next] <= 0.0) {
                let share = beyond[at] / (beyond[at] - beyond[next]);
                kept.push(triangle[at].lerp(triangle[next], share));
            }
        }
        for at in 2..kept.len() {
            let part = [kept[0], kept[at - 1], kept[at]];
            if (self.region)((part[0] + part[1] + part[2]) / 3.0) < -INSIDE * self.cell {
                found.push(part);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use std::f64::consts::PI;

    use super::*;

    fn area(triangles: &[[DVec3; 3]]) -> f64 {
        triangles.iter().map(|[a, b, c]| 0.5 * (*b - *a).cross(*c - *a).length()).sum()
    }

    #[test]
    fn a_cap_has_its_area() {
        let sphere = |point: DVec3| point.length() - 1.0;
        for cut in [-1.1, -0.3, 0.0, 0.42, 0.8] {
            let above = |point: DVec3| cut - point.z;
            let contour =
                Contour { surface: &sphere, region: &above, low: DVec3::new(-1.1, -1.1, -1.2), cell: 0.05 };
            let found = area(&contour.triangles(DVec3::splat(1.1)));
            let expected = 2.0 * PI * (1.0 - f64::max(cut, -1.0));
            assert!((found / expected - 1.0).abs() < 2e-3, "{found} for {expected} at {cut}");
        }
    }

    #[test]
    fn a_plane_has_the_area_of_the_region_in_it() {
        let plane = |point: DVec3| point.x - 0.0437;
        let disc = |point: DVec3| point.y.hypot(point.z) - 0.31;
        let contour = Contour { surface: &plane, region: &disc, low: DVec3::splat(-0.5), cell: 0.02 };
        let found = area(&contour.triangles(DVec3::splat(0.5)));
        assert!((found / (PI * 0.31 * 0.31) - 1.0).abs() < 1e-3, "{found}");
    }

    /// A face ends at its edges, and those beside it are on the border of the region.
    #[test]
    fn a_face_of_a_box_has_its_area() {
        let half = DVec3::new(0.313, 0.2, 0.1);
        let solid = |point: DVec3| {
            let beyond = point.abs() - half;
            beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
        };
        let slab = |point: DVec3| {
            let beyond = (point - DVec3::new(0.0, 0.0, 0.1)).abs() - DVec3::new(0.313, 0.2, 0.05);
            beyond.max_element()
        };
        let contour = Contour { surface: &solid, region: &slab, low: DVec3::splat(-0.5), cell: 0.02 };
        let found = area(&contour.triangles(DVec3::splat(0.5)));
        assert!((found / (4.0 * 0.313 * 0.2) - 1.0).abs() < 5e-3, "{found}");
    }
}
