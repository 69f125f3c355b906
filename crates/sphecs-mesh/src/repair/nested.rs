//! Closed components inside others.

use glam::DVec3;

use super::orient::Component;
use crate::surface::bvh::Bvh;
use crate::surface::winding;
use crate::triangulation::Triangulation;

/// Components with the largest boxes that are examined as containers of others, so that the time
/// does not grow with the square of the number of components.
const CONTAINERS: usize = 256;

/// Returns of each component whether it is closed and inside an odd number of other closed ones.
pub(crate) fn cavities(mesh: &Triangulation, components: &[Component]) -> Vec<bool> {
    let boxes: Vec<(DVec3, DVec3)> =
        components.iter().map(|component| bounds(mesh, &component.triangles)).collect();
    let size = |index: usize| boxes[index].0.distance_squared(boxes[index].1);
    let mut containers: Vec<usize> = (0..components.len()).filter(|i| components[*i].is_closed).collect();
    let closed = containers.clone();
    containers.sort_by(|a, b| size(*b).total_cmp(&size(*a)).then(a.cmp(b)));
    containers.truncate(CONTAINERS);
    let mut is_cavity = vec![false; components.len()];
    for container in containers {
        let (low, high) = boxes[container];
        let mut bvh = None;
        for &inner in &closed {
            let fits = low.cmple(boxes[inner].0).all() && high.cmpge(boxes[inner].1).all();
            if inner == container || !fits {
                continue;
            }
            let triangles = &components[container].triangles;
            let bvh = bvh.get_or_insert_with(|| Bvh::new(mesh, triangles.iter().copied()));
            // The orientation is not known yet: the sign does not count.
            let is_inside = |point| winding::winding(bvh, mesh, point).abs() > 0.5;
            is_cavity[inner] ^= samples(mesh, &components[inner].triangles).into_iter().all(is_inside);
        }
    }
    is_cavity
}

/// Returns a few vertices of a component: all inside another means that they do not cross.
fn samples(mesh: &Triangulation, triangles: &[u32]) -> [DVec3; 3] {
    let last = triangles.len() - 1;
    [0, last / 2, last].map(|index| mesh.corners(triangles[index] as usize)[0])
}

fn bounds(mesh: &Triangulation, triangles: &[u32]) -> (DVec3, DVec3) {
    let corners = triangles.iter().flat_map(|triangle| mesh.corners(*triangle as usize));
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    corners.fold(start, |(low, high), corner| (low.min(corner), high.max(corner)))
}
