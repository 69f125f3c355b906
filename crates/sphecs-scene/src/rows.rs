//! Wall-fitted rows for a channel along x in 2D whose walls slant or curve.
//!
//! Row j stands at the fraction (j + ½)/n of the width w(x) at every x; the columns are as far
//! apart as gives every particle the same area, n Δ² between two columns:
//!
//! ```text
//! y_j(x) = lower + (j + ½)/n · w,   ∫ w dx from column k to column k + 1 = n Δ²
//! ```
//!
//! Rows outside 0 … n − 1 continue into the walls. Where w differs much from n Δ the cells are no
//! squares, and the density sum of such an arrangement is not that of the lattice: `WallFitted` is
//! for channels whose width varies little.

use glam::DVec3;

use super::expression::Expression;
use super::model::Scene;

/// All points of the rows over the confines, `reach` (m) into the walls.
pub fn points(scene: &Scene, lower: &Expression, upper: &Expression, rows: usize, reach: f64) -> Vec<DVec3> {
    let (low, high) = scene.layout.confines.bounds();
    let (start, end) = ends(scene, low.x, high.x);
    // Beyond the domain the walls extend straight, as the zones do.
    let walls = |x: f64| {
        let x = x.clamp(start, end);
        (lower.value(x, 0.0, 0.0, 0.0), upper.value(x, 0.0, 0.0, 0.0))
    };
    let cell = rows as f64 * scene.spacing * scene.spacing;
    let mut points = Vec::new();
    let width = |x: f64| walls(x).1 - walls(x).0;
    let mut columns = march(width, start, high.x + reach, cell, 1.0);
    columns.extend(march(width, start, low.x - reach, cell, -1.0));
    columns.sort_by(f64::total_cmp);
    for x in columns {
        let (bottom, top) = walls(x);
        let step = (top - bottom) / rows as f64;
        let outside = (reach / step).ceil() as i64 + 1;
        for row in -outside..rows as i64 + outside {
            points.push(DVec3::new(x, bottom + (row as f64 + 0.5) * step, 0.0));
        }
    }
    points
}

/// Returns the extent of the domain along x without zones, m.
fn ends(scene: &Scene, low: f64, high: f64) -> (f64, f64) {
    let (domain_low, domain_high) = scene.domain.bounds();
    (domain_low.x.max(low), domain_high.x.min(high))
}

/// Columns from `start` to `end`: the first half a cell from the start, then a cell each.
fn march(width: impl Fn(f64) -> f64, start: f64, end: f64, cell: f64, direction: f64) -> Vec<f64> {
    let mut columns = Vec::new();
    let (mut x, mut area) = (start, 0.5 * cell);
    while (end - x) * direction > 0.0 {
        // ∫ w dx = area by the midpoint rule, its step found by fixed-point iteration.
        let mut step = area / width(x);
        for _ in 0..20 {
            step = area / width(x + 0.5 * direction * step);
        }
        x += direction * step;
        area = cell;
        columns.push(x);
    }
    columns
}
