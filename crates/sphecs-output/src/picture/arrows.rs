//! Velocity arrows on a regular grid of the picture.
//!
//! The longest arrow is as long as the arrows are apart; all others are in proportion to their
//! speed. An arrow has its middle at its node.

use super::plane_grid::PlaneGrid;

/// Length of the longest arrow over the distance of the arrows.
pub(super) const LONGEST: f64 = 0.95;

/// Length below which an arrow would be a dot, over the longest one.
const SHORTEST: f64 = 0.03;

/// Arrow from its tail to its tip, m.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Arrow {
    pub(super) tail: [f64; 2],
    pub(super) tip: [f64; 2],
}

/// Returns the arrows between two corners, `across` of them to the right; the largest speed, m/s,
/// has the longest one.
pub(super) fn arrows(
    grid: &PlaneGrid,
    [low, high]: [[f64; 2]; 2],
    across: u32,
    largest_speed: f64,
) -> Vec<Arrow> {
    let distance = (high[0] - low[0]) / f64::from(across);
    let rows = ((high[1] - low[1]) / distance).round().max(1.0) as u32;
    let mut found = Vec::new();
    if largest_speed <= 0.0 {
        return found;
    }
    for index in 0..across * rows {
        let place = [
            low[0] + (f64::from(index % across) + 0.5) * distance,
            low[1] + (f64::from(index / across) + 0.5) * (high[1] - low[1]) / f64::from(rows),
        ];
        let Some(velocity) = grid.velocity_at(place) else { continue };
        if velocity[0].hypot(velocity[1]) < SHORTEST * largest_speed {
            continue;
        }
        let half = velocity.map(|component| 0.5 * LONGEST * distance * component / largest_speed);
        found.push(Arrow {
            tail: [place[0] - half[0], place[1] - half[1]],
            tip: [place[0] + half[0], place[1] + half[1]],
        });
    }
    found
}

/// Returns the triangle of the head of an arrow that points along a vector, in the same units.
pub(super) fn head(tip: [f64; 2], along: [f64; 2], length: f64) -> Vec<[f64; 2]> {
    let size = along[0].hypot(along[1]).max(f64::MIN_POSITIVE);
    let [x, y] = along.map(|part| part / size * length);
    let back = [tip[0] - x, tip[1] - y];
    vec![tip, [back[0] - 0.4 * y, back[1] + 0.4 * x], [back[0] + 0.4 * y, back[1] - 0.4 * x]]
}

#[cfg(test)]
mod tests {
    use super::super::plane_grid::tests::grid;
    use super::*;

    #[test]
    fn arrows_are_in_proportion_to_the_speed() {
        let grid = grid(21, |[_, y]| ([1.0 - y * y, 0.0], 0.0));
        let found = arrows(&grid, [[-1.0; 2], [1.0; 2]], 10, 1.0);
        assert!(!found.is_empty());
        for Arrow { tail, tip } in found {
            let y = tail[1];
            // Bilinear interpolation of the parabola on 21 nodes: step²/8 times the curvature.
            assert!((tip[0] - tail[0] - 0.19 * (1.0 - y * y)).abs() < 0.19 * 2.6e-3);
            assert_eq!(tip[1], y);
        }
    }

    #[test]
    fn slow_fluid_and_walls_have_none() {
        let half = |[x, _]: [f64; 2]| ([if x < 0.0 { f64::NAN } else { 1.0 }, 0.0], 0.0);
        assert_eq!(arrows(&grid(41, half), [[-1.0; 2], [1.0; 2]], 10, 1.0).len(), 50);
        let still = grid(5, |_| ([1e-3, 0.0], 0.0));
        assert!(arrows(&still, [[-1.0; 2], [1.0; 2]], 10, 1.0).is_empty());
    }

    #[test]
    fn head_points_along_the_arrow() {
        let points = head([1.0, 0.0], [5.0, 0.0], 0.5);
        assert_eq!(points, [[1.0, 0.0], [0.5, 0.2], [0.5, -0.2]]);
    }
}
