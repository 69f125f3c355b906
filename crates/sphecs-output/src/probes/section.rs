//! Sample points of a plane section of the domain.
//!
//! The section is the connected part around a given point, so that a plane through one leg of a
//! bend omits the other leg.

use std::collections::HashSet;

use glam::DVec3;

/// Largest number of points of a section; it is exceeded where the domain is not closed.
const MAX_POINTS: usize = 4_000_000;

/// Returns the points of the section through `at` with normal `normal` and their areas, m² (lengths
/// in m in 2D).
///
/// Empty if `at` is outside. `distance` is the signed distance of the domain, m; `step` the wanted
/// spacing, m.
pub(super) fn points(
    distance: &impl Fn(DVec3) -> f64,
    at: DVec3,
    normal: DVec3,
    dimensions: usize,
    step: f64,
) -> Vec<(DVec3, f64)> {
    if !distance(at).is_sign_negative() || normal == DVec3::ZERO {
        return Vec::new();
    }
    if dimensions == 2 {
        line(distance, at, DVec3::new(-normal.y, normal.x, 0.0), step)
    } else {
        plane(distance, at, normal, step)
    }
}

/// Returns the midpoints of equal parts of the chord through `at` along the unit vector `along`.
fn line(distance: &impl Fn(DVec3) -> f64, at: DVec3, along: DVec3, step: f64) -> Vec<(DVec3, f64)> {
    let up = reach(distance, at, along, step);
    let down = reach(distance, at, -along, step);
    let length = up + down;
    let count = (length / step).ceil().max(1.0);
    let part = length / count;
    (0..count as usize).map(|k| (at + along * (part * (k as f64 + 0.5) - down), part)).collect()
}

/// Returns the distance from `at` to the surface along a unit vector, m.
///
/// Marches in steps, which cannot pass a wall thicker than a step, and then bisects.
fn reach(distance: &impl Fn(DVec3) -> f64, at: DVec3, along: DVec3, step: f64) -> f64 {
    let inside = |s: f64| distance(at + along * s) < 0.0;
    let mut low = 0.0;
    for _ in 0..MAX_POINTS {
        let high = low + step;
        if inside(high) {
            low = high;
            continue;
        }
        let mut high = high;
        // 60 bisections reach the last digit of a double.
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            if inside(middle) {
                low = middle;
            } else {
                high = middle;
            }
        }
        break;
    }
    low
}

/// Returns the square cells of the section connected to `at` with their areas, m².
///
/// A cell at the boundary is replaced by its inner part, sampled at the centre of that part.
fn plane(distance: &impl Fn(DVec3) -> f64, at: DVec3, normal: DVec3, step: f64) -> Vec<(DVec3, f64)> {
    let across = normal.any_orthonormal_vector();
    let over = normal.cross(across);
    let place = |i: f64, j: f64| at + (across * i + over * j) * step;
    let mut seen = HashSet::from([(0_i32, 0_i32)]);
    let mut open = vec![(0, 0)];
    let mut result = Vec::new();
    while let Some((i, j)) = open.pop() {
        let centre = place(f64::from(i), f64::from(j));
        let Some((point, share)) = inner_part(distance, &place, (i, j), centre, step) else {
            continue;
        };
        result.push((point, share * step * step));
        if result.len() >= MAX_POINTS {
            break;
        }
        for next in [(i + 1, j), (i - 1, j), (i, j + 1), (i, j - 1)] {
            if seen.insert(next) {
                open.push(next);
            }
        }
    }
    result
}

/// Returns centre and area fraction of the part of a cell that is inside; None without such a part.
fn inner_part(
    distance: &impl Fn(DVec3) -> f64,
    place: &impl Fn(f64, f64) -> DVec3,
    (i, j): (i32, i32),
    centre: DVec3,
    step: f64,
) -> Option<(DVec3, f64)> {
    let from_surface = distance(centre);
    // The cell's corners are 0.71 steps from its centre.
    if from_surface < -0.71 * step {
        return Some((centre, 1.0));
    }
    if from_surface > 0.71 * step {
        return None;
    }
    const PARTS: i32 = 8;
    let mut sum = DVec3::ZERO;
    let mut count = 0.0;
    for a in 0..PARTS {
        for b in 0..PARTS {
            let offset = |k: i32| (f64::from(k) + 0.5) / f64::from(PARTS) - 0.5;
            let point = place(f64::from(i) + offset(a), f64::from(j) + offset(b));
            if distance(point) < 0.0 {
                sum += point;
                count += 1.0;
            }
        }
    }
    (count > 0.0).then(|| (sum / count, count / f64::from(PARTS * PARTS)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn chord_ends_at_the_walls() {
        // The chord across an oblique channel of width 1 has length 1 for any step.
        let normal = DVec3::new(0.8, 0.6, 0.0);
        let across = DVec3::new(-0.6, 0.8, 0.0);
        let distance = |p: DVec3| p.dot(across).abs() - 0.5;
        let parts = points(&distance, across * 0.2, normal, 2, 0.03);
        let length: f64 = parts.iter().map(|&(_, part)| part).sum();
        assert!((length - 1.0).abs() < 1e-12, "{length}");
        assert!(parts.iter().all(|&(p, _)| distance(p) < 0.0));
    }

    #[test]
    fn other_leg_is_omitted() {
        let distance = |p: DVec3| ((p.y.abs() - 1.0).abs() - 0.25).max(-10.0);
        let length: f64 = points(&distance, DVec3::Y, DVec3::X, 2, 0.02).iter().map(|&(_, part)| part).sum();
        assert!((length - 0.5).abs() < 1e-12, "{length}");
    }

    #[test]
    fn round_section_has_its_area() {
        let distance = |p: DVec3| p.truncate().length() - 0.5;
        let parts = points(&distance, DVec3::new(0.1, 0.0, 0.3), DVec3::Z, 3, 0.025);
        let area: f64 = parts.iter().map(|&(_, part)| part).sum();
        let exact = std::f64::consts::PI / 4.0;
        // 126 boundary cells of 64 parts each with random errors of half a part: about 1e-4 of the
        // area.
        assert!((area / exact - 1.0).abs() < 1e-3, "{area} m² for {exact} m²");
        assert!(parts.iter().all(|&(p, _)| distance(p) < 1e-3));
    }

    #[test]
    fn point_outside_has_no_section() {
        assert!(points(&|p: DVec3| p.length() - 1.0, DVec3::X * 2.0, DVec3::X, 3, 0.1).is_empty());
    }
}
