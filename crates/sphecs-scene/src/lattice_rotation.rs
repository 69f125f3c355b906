//! Rotation of the lattice to the directions of the walls.
//!
//! Walls oblique to the lattice are stairs of wall particles, which roughen them. Where one frame
//! serves the walls, the lattice is turned to it and the flow is that of walls along the axes:
//!
//! ```text
//! R = arg max Σ A_k over the walls k that lie along a column of R, by at least 3/4 of Σ A_k
//! ```
//!
//! A_k is the area of a plane wall or of the side of a cylinder, openings left out. A scene keeps
//! the lattice along the axes if any plane wall lies along them, if no frame reaches three
//! quarters, or if a periodic direction would be turned.

use glam::{DMat3, DVec3};

use super::geometry::Shape;
use super::geometry::directions::{Direction, clean};
use super::lattice::{exposed_area, rotated_patch};
use super::model::Patch;

/// Largest cosine of perpendicular directions, and 1 − cosine of parallel ones.
const ALIKE: f64 = 1e-9;

/// Smallest share of the walls that a frame must serve.
const LEAST_SHARE: f64 = 0.75;

/// Samples of a plane along each axis, in 2D and in 3D.
const SAMPLES: [usize; 2] = [500, 48];

/// Returns the rotation from the axes to the frame of the walls, the identity without such a frame.
pub fn rotation_to_walls(
    domain: &Shape,
    patches: &[&Patch],
    periodic: &[Option<(f64, f64)>; 3],
    spacing: f64,
    dimensions: usize,
) -> DMat3 {
    if dimensions == 2 && periodic.iter().any(Option::is_some) {
        return DMat3::IDENTITY;
    }
    let walls = wall_directions(domain, patches, spacing, dimensions);
    let total: f64 = walls.iter().map(|wall| wall.1).sum();
    let Some(&(first, _)) = walls.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
        return DMat3::IDENTITY;
    };
    // The direction of a round pipe leaves its roll open: its rows are those of its opening.
    let across = patches.iter().map(|patch| (patch.across[0], 0.0));
    let second = (walls.iter().copied().chain(across))
        .filter(|(direction, _)| direction.dot(first).abs() < ALIKE)
        .reduce(|best, other| if other.1 > best.1 { other } else { best });
    let rotation = match (dimensions, second) {
        (2, _) => plane_frame(first),
        (_, None) => nearest_frame(first),
        (_, Some((second, _))) => frame(first, second),
    };
    let serves = |direction: DVec3| (rotation.transpose() * direction).abs().max_element() > 1.0 - ALIKE;
    let served: f64 = walls.iter().filter(|wall| serves(wall.0)).map(|wall| wall.1).sum();
    let keeps_periods =
        (0..3).all(|axis| periodic[axis].is_none() || rotation.col(axis) == DVec3::AXES[axis]);
    if served >= LEAST_SHARE * total && keeps_periods { rotation } else { DMat3::IDENTITY }
}

/// Returns the directions of the plane walls and of the sides of cylinders with their areas, m².
pub fn wall_directions(
    domain: &Shape,
    patches: &[&Patch],
    spacing: f64,
    dimensions: usize,
) -> Vec<(DVec3, f64)> {
    let mut directions = Vec::new();
    domain.directions(&mut directions);
    let mut planes: Vec<(DVec3, f64)> = Vec::new();
    let mut walls = Vec::new();
    for direction in directions {
        match direction {
            Direction::Side { axis, area } if dimensions == 3 => walls.push((axis, area)),
            Direction::Side { .. } => {}
            Direction::Plane { normal, offset } => {
                let lies_in_plane = dimensions == 3 || normal.z == 0.0;
                let is_known = planes.iter().any(|(other, at)| {
                    let cosine = other.dot(normal);
                    cosine.abs() > 1.0 - ALIKE && (at * cosine.signum() - offset).abs() < 1e-6 * spacing
                });
                if lies_in_plane && offset.is_finite() && normal != DVec3::ZERO && !is_known {
                    planes.push((normal, offset));
                }
            }
        }
    }
    for (normal, offset) in planes {
        let seen = nearest_frame(normal);
        // The normal lies along the axis of the frame that it is nearest to.
        let axis = (0..3).find(|axis| seen.col(*axis).dot(normal).abs() > 1.0 - ALIKE).unwrap_or(0);
        let back = seen.transpose();
        let turned: Vec<Patch> = patches.iter().map(|patch| rotated_patch(patch, back)).collect();
        let turned: Vec<&Patch> = turned.iter().collect();
        let coordinate = offset * seen.col(axis).dot(normal).signum();
        let place = (axis, coordinate);
        let area = exposed_area(&domain.rotated(back), &turned, place, spacing, dimensions, SAMPLES);
        if area > 0.0 {
            walls.push((normal, area));
        }
    }
    walls
}

/// Returns the rotation about z by at most 45° that takes an axis to a direction in the plane.
fn plane_frame(direction: DVec3) -> DMat3 {
    let (mut c, mut s) = (direction.x, direction.y);
    for _ in 0..4 {
        if c >= s.abs() - ALIKE && s > -c + ALIKE {
            break;
        }
        (c, s) = (-s, c);
    }
    clean(DMat3::from_cols(DVec3::new(c, s, 0.0), DVec3::new(-s, c, 0.0), DVec3::Z))
}

/// Returns the smallest rotation that takes the nearest axis to a direction or its opposite.
fn nearest_frame(direction: DVec3) -> DMat3 {
    let (axis, direction) = nearest_axis(direction, None);
    clean(DMat3::from_quat(glam::DQuat::from_rotation_arc(DVec3::AXES[axis], direction)))
}

/// Returns the rotation whose columns are two perpendicular directions, each up to its sign at the
/// axis that it is nearest to.
fn frame(first: DVec3, second: DVec3) -> DMat3 {
    let (one, first) = nearest_axis(first, None);
    let (two, second) = nearest_axis(second, Some(one));
    let three = 3 - one - two;
    let mut columns = [DVec3::ZERO; 3];
    (columns[one], columns[two]) = (first, second);
    let is_cyclic = (one + 1) % 3 == two;
    columns[three] = if is_cyclic { first.cross(second) } else { second.cross(first) };
    clean(DMat3::from_cols(columns[0], columns[1], columns[2]))
}

/// Returns the axis that a direction is nearest to, and the direction with the sign of that axis.
/// Of axes that are equally near it is the first.
fn nearest_axis(direction: DVec3, taken: Option<usize>) -> (usize, DVec3) {
    let share = |axis: usize| if Some(axis) == taken { -1.0 } else { direction[axis].abs() };
    let most = (0..3).map(share).fold(0.0, f64::max);
    let axis = (0..3).find(|axis| share(*axis) >= most - ALIKE).unwrap_or(0);
    (axis, direction * direction[axis].signum())
}
