//! Surface of a wall inside a region as triangles, in 3D.
//!
//! The box around both is divided into cubes, which are left out where the signed distance is larger
//! than they are, down to a quarter of a spacing. Each is cut into six tetrahedra, in which the
//! surface is a triangle or two: marching tetrahedra, Doi & Koide (1991). The corners are found on
//! the edges by bisection, and the region cuts the triangles. Crates for isosurfaces work on dense
//! grids, and none cuts at a region.

use glam::{DVec3, IVec3};

/// Corners of the six tetrahedra of a cube, along its diagonal; bit k of a corner is its place on
/// axis k.
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];

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
        let size = (cells.ceil() as u32).next_power_of_two() as i32;
        let mut found = Vec::new();
        self.divide((IVec3::ZERO, size), high, &mut found);
        found
    }

    fn point(&self, corner: IVec3) -> DVec3 {
        self.low + self.cell * corner.as_dvec3()
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
                    self.clip([cross(a, b), cross(a, c), cross(a, d)], found);
                }
                (&[a, b], &[c, d]) => {
                    let [ac, ad, bc, bd] = [cross(a, c), cross(a, d), cross(b, c), cross(b, d)];
                    self.clip([ac, ad, bd], found);
                    self.clip([ac, bd, bc], found);
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
            found.push([kept[0], kept[at - 1], kept[at]]);
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
            assert!((found / expected - 1.0).abs() < 1e-3, "{found} for {expected} at {cut}");
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
}
