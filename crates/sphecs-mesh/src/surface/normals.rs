//! Normals of triangles, and of the surface at edges and vertices.

use glam::DVec3;

use super::{Feature, Nearest, Surface};
use crate::triangulation::Triangulation;

/// Share of the size of the surface below which a distance has no direction.
const ON_SURFACE: f64 = 1e-9;

/// Triangles around each vertex.
#[derive(Clone, Debug)]
pub(crate) struct Around {
    /// Index into `triangles` of the first of each vertex, and the end.
    starts: Vec<u32>,
    triangles: Vec<u32>,
}

impl Around {
    /// Lists the triangles around each vertex in ascending order.
    pub(crate) fn new(mesh: &Triangulation) -> Self {
        let mut starts = vec![0_u32; mesh.vertices.len() + 1];
        for vertex in mesh.triangles.iter().flatten() {
            starts[*vertex as usize + 1] += 1;
        }
        for vertex in 1..starts.len() {
            starts[vertex] += starts[vertex - 1];
        }
        let mut next = starts.clone();
        let mut triangles = vec![0; 3 * mesh.triangles.len()];
        for (number, triangle) in mesh.triangles.iter().enumerate() {
            for vertex in triangle {
                let place = &mut next[*vertex as usize];
                triangles[*place as usize] = number as u32;
                *place += 1;
            }
        }
        Self { starts, triangles }
    }

    /// Returns the triangles around a vertex.
    pub(crate) fn vertex(&self, vertex: u32) -> &[u32] {
        let vertex = vertex as usize;
        &self.triangles[self.starts[vertex] as usize..self.starts[vertex + 1] as usize]
    }

    /// Returns the triangles that have both vertices.
    pub(crate) fn edge<'a>(
        &'a self,
        mesh: &'a Triangulation,
        ends: [u32; 2],
    ) -> impl Iterator<Item = u32> + 'a {
        // The apex of a fan may have very many triangles, the other end has few.
        let [a, b] =
            if self.vertex(ends[0]).len() <= self.vertex(ends[1]).len() { ends } else { [ends[1], ends[0]] };
        let has_both = move |triangle: &u32| mesh.triangles[*triangle as usize].contains(&b);
        self.vertex(a).iter().copied().filter(has_both)
    }
}

impl Surface {
    /// Returns the unit normal of a triangle, outward; zero for one without area.
    ///
    /// # Panics
    /// If there is no such triangle.
    pub fn normal(&self, triangle: u32) -> DVec3 {
        self.mesh.area_vector(triangle as usize).normalize_or_zero()
    }

    /// Returns the unit normal at the nearest point of `query`, outward.
    ///
    /// It is the direction between the two points, the gradient of the distance; on the surface
    /// itself, the pseudonormal of Bærentzen & Aanæs (2005): the mean of the normals around,
    /// weighted by the angles of the facets there.
    pub fn smooth_normal_at(&self, query: DVec3, nearest: &Nearest) -> DVec3 {
        let pseudonormal = self.pseudonormal(nearest);
        let away = query - nearest.point;
        let (low, high) = self.bounds;
        if nearest.distance <= ON_SURFACE * low.distance(high) {
            return pseudonormal;
        }
        let outward = if away.dot(pseudonormal) < 0.0 { -away } else { away };
        outward.normalize_or_zero()
    }

    /// Returns the mean of the unit normals at a nearest point, weighted by the angles of the
    /// facets there: the pseudonormal.
    pub(super) fn pseudonormal(&self, nearest: &Nearest) -> DVec3 {
        let corners = self.mesh.triangles[nearest.triangle as usize];
        let sum: DVec3 = match nearest.feature {
            Feature::Face => return self.normal(nearest.triangle),
            Feature::Edge(edge) => {
                let ends = [corners[usize::from(edge)], corners[(usize::from(edge) + 1) % 3]];
                self.around.edge(&self.mesh, ends).map(|triangle| self.normal(triangle)).sum()
            }
            Feature::Vertex(corner) => {
                let vertex = corners[usize::from(corner)];
                let weighted = |triangle: &u32| self.angle(*triangle, vertex) * self.normal(*triangle);
                self.around.vertex(vertex).iter().map(weighted).sum()
            }
        };
        // Opposite facets, as at the border of a sheet folded back, have no mean.
        sum.try_normalize().unwrap_or_else(|| self.normal(nearest.triangle))
    }

    /// Returns the angle of a triangle at one of its vertices, rad.
    fn angle(&self, triangle: u32, vertex: u32) -> f64 {
        let vertices = self.mesh.triangles[triangle as usize];
        let corner = vertices.iter().position(|other| *other == vertex).unwrap_or_default();
        let place = |offset: usize| self.mesh.vertices[vertices[(corner + offset) % 3] as usize];
        (place(1) - place(0)).angle_between(place(2) - place(0))
    }
}
