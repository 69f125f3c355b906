//! Large flat parts of a surface, to which a lattice of particles is fitted.

use std::collections::VecDeque;

use glam::DVec3;

use super::Surface;

/// Distance of vertices from their plane as a share of the diagonal: files in f32 round by 1e-7.
const FLATNESS: f64 = 1e-6;

/// Cosine of the largest angle between a facet and its plane. Slender facets of files in f32 have
/// inaccurate normals.
const ALIGNED: f64 = 0.999;

/// Cosine of the largest angle at which two facets are parts of a curved surface, 30°: with twelve
/// facets a round pipe is one.
const SMOOTH: f64 = 0.866;

/// Share of the area of the surface below which a flat part is not listed.
const SMALLEST_SHARE: f64 = 1e-3;

/// Flat part of a surface: the points x with n·x = d.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal n, outward.
    pub normal: DVec3,
    /// Offset d along the normal from the origin, m.
    pub offset: f64,
    /// Area of the triangles in the plane, m².
    pub area: f64,
}

impl Surface {
    /// Returns the planes of adjacent triangles in one plane, the largest area first.
    ///
    /// Parts with the same plane are one. Parts below a thousandth of the area are left out, as
    /// are the facets of curved parts, most of whose border continues within 30°.
    pub fn planes(&self) -> Vec<Plane> {
        let count = self.mesh.triangles.len();
        let areas: Vec<f64> = (0..count).map(|triangle| self.mesh.area_vector(triangle).length()).collect();
        let mut seeds: Vec<u32> = (0..count as u32).collect();
        seeds.sort_by(|a, b| areas[*b as usize].total_cmp(&areas[*a as usize]).then(a.cmp(b)));
        let mut is_taken = vec![false; count];
        let mut planes: Vec<Plane> = Vec::new();
        for seed in seeds {
            if is_taken[seed as usize] || areas[seed as usize] == 0.0 {
                continue;
            }
            let (plane, is_facet_of_curve) = self.grow(seed, &mut is_taken);
            if plane.area >= SMALLEST_SHARE * self.area && !is_facet_of_curve {
                self.add(&mut planes, plane);
            }
        }
        planes.sort_by(|a, b| b.area.total_cmp(&a.area));
        planes
    }

    /// Collects the triangles around a first one that are in its plane; true beside it if most of
    /// its border continues smoothly, as that of a facet of a round wall does.
    fn grow(&self, seed: u32, is_taken: &mut [bool]) -> (Plane, bool) {
        let (low, high) = self.bounds;
        let tolerance = FLATNESS * low.distance(high);
        let normal = self.normal(seed);
        let origin = self.mesh.corners(seed as usize)[0];
        let is_flat = |triangle: u32| {
            let corners = self.mesh.corners(triangle as usize);
            let own = self.normal(triangle);
            corners.iter().all(|corner| (*corner - origin).dot(normal).abs() <= tolerance)
                && (own == DVec3::ZERO || own.dot(normal) > ALIGNED)
        };
        let mut queue = VecDeque::from([seed]);
        is_taken[seed as usize] = true;
        let (mut sum, mut moment) = (DVec3::ZERO, 0.0);
        let (mut border, mut smooth) = (0.0, 0.0);
        while let Some(triangle) = queue.pop_front() {
            let [a, b, c] = self.mesh.corners(triangle as usize);
            let vector = self.mesh.area_vector(triangle as usize);
            sum += vector;
            // Relative to the first corner, which keeps digits far from the origin.
            moment += vector.length() * ((a + b + c) / 3.0 - origin).dot(normal);
            let vertices = self.mesh.triangles[triangle as usize];
            for corner in 0..3 {
                let ends = [vertices[corner], vertices[(corner + 1) % 3]];
                let length = [a, b, c][corner].distance([a, b, c][(corner + 1) % 3]);
                for next in self.around.edge(&self.mesh, ends) {
                    if next != triangle && !is_flat(next) {
                        border += length;
                        smooth += if self.normal(next).dot(normal) > SMOOTH { length } else { 0.0 };
                    }
                    if !is_taken[next as usize] && is_flat(next) {
                        is_taken[next as usize] = true;
                        queue.push_back(next);
                    }
                }
            }
        }
        let area = sum.length();
        let mean = sum / area;
        let plane = Plane { normal: mean, offset: mean.dot(origin) + moment / area, area };
        (plane, smooth > 0.5 * border)
    }

    /// Adds a plane to the one it equals, or to the list.
    fn add(&self, planes: &mut Vec<Plane>, plane: Plane) {
        let (low, high) = self.bounds;
        let tolerance = FLATNESS * low.distance(high);
        let centre = 0.5 * (low + high);
        let height = |plane: &Plane| plane.offset - plane.normal.dot(centre);
        let same = planes.iter_mut().find(|known| {
            known.normal.dot(plane.normal) > 1.0 - FLATNESS * FLATNESS * 0.5
                && (height(known) - height(&plane)).abs() <= tolerance
        });
        match same {
            Some(known) => known.area += plane.area,
            None => planes.push(plane),
        }
    }
}
