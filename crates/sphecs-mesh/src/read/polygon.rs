//! Division of polygons into triangles.

use glam::{DVec2, DVec3};

/// Most points that are compared with an ear, over all ears of a polygon. The time of clipping
/// grows with the square of the number of corners, and with its cube for a few polygons.
const MOST_COMPARED: usize = 20_000_000;

/// Checks the number of corners of a face against the vertices of its file.
///
/// A face with a hole, connected to its border by a cut, has vertices twice, but none more often.
pub(super) fn check_corners(corners: u64, vertices: usize) -> Result<(), String> {
    if corners < 3 {
        return Err(format!("{corners} corners, must have at least 3: export the file again"));
    }
    if corners > 2 * vertices as u64 {
        return Err(format!(
            "{corners} corners for {vertices} vertices: it is damaged, export the file again"
        ));
    }
    Ok(())
}

/// Divides a polygon, given by at least three indices of vertices, and calls `push` for each of
/// its n − 2 triangles.
///
/// A convex polygon becomes a fan around its first corner. A concave one is divided by clipping
/// ears in the plane of its mean normal; where it crosses itself or has very many corners, it
/// becomes a fan, whose winding number is right all the same.
pub(super) fn triangulate(corners: &[u32], vertices: &[DVec3], mut push: impl FnMut([u32; 3])) {
    if let [a, b, c] = *corners {
        push([a, b, c]);
        return;
    }
    let flat = flatten(corners, vertices);
    let count = corners.len();
    let is_convex = (0..count).all(|at| {
        let [a, b, c] = [0, 1, 2].map(|offset| flat[(at + offset) % count]);
        (b - a).perp_dot(c - b) >= 0.0
    });
    let ears = if is_convex { None } else { clip_ears(&flat) };
    match ears {
        Some(ears) => ears.into_iter().for_each(|ear| push(ear.map(|at| corners[at]))),
        None => {
            (1..count - 1).for_each(|at| push([corners[0], corners[at], corners[at + 1]]));
        }
    }
}

/// Projects the corners along their mean normal, seen from its tip: counter-clockwise as a whole.
fn flatten(corners: &[u32], vertices: &[DVec3]) -> Vec<DVec2> {
    let points: Vec<DVec3> = corners.iter().map(|corner| vertices[*corner as usize]).collect();
    let origin = points[0];
    // Newell's normal.
    let normal: DVec3 = (1..points.len() - 1)
        .map(|at| (points[at] - origin).cross(points[at + 1] - origin))
        .sum::<DVec3>()
        .try_normalize()
        .unwrap_or(DVec3::Z);
    let (u, v) = normal.any_orthonormal_pair();
    let (u, v) = if u.cross(v).dot(normal) < 0.0 { (v, u) } else { (u, v) };
    points.iter().map(|point| DVec2::new((*point - origin).dot(u), (*point - origin).dot(v))).collect()
}

/// Cuts off corner after corner with no other corner in its triangle; None if there is none left.
fn clip_ears(flat: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let mut rest: Vec<usize> = (0..flat.len()).collect();
    let mut ears = Vec::with_capacity(flat.len() - 2);
    let mut at = 0;
    let mut refused = 0;
    let mut compared = 0;
    while rest.len() > 3 {
        let count = rest.len();
        compared += count;
        if compared > MOST_COMPARED {
            return None;
        }
        let ear = [rest[(at + count - 1) % count], rest[at % count], rest[(at + 1) % count]];
        if is_ear(ear, &rest, flat) {
            ears.push(ear);
            rest.remove(at % count);
            refused = 0;
            // The next corner, so that no slender fan arises around one.
            at = at % count % rest.len();
        } else {
            refused += 1;
            if refused > count {
                return None;
            }
            at = (at + 1) % count;
        }
    }
    ears.push([rest[0], rest[1], rest[2]]);
    Some(ears)
}

fn is_ear(ear: [usize; 3], rest: &[usize], flat: &[DVec2]) -> bool {
    let [a, b, c] = ear.map(|at| flat[at]);
    let side = |from: DVec2, to: DVec2, point: DVec2| (to - from).perp_dot(point - from);
    if side(a, b, c) <= 0.0 {
        return false;
    }
    let mut others = rest.iter().filter(|at| !ear.contains(at)).map(|at| flat[*at]);
    !others.any(|point| {
        let is_corner = point == a || point == b || point == c;
        !is_corner && side(a, b, point) >= 0.0 && side(b, c, point) >= 0.0 && side(c, a, point) >= 0.0
    })
}
