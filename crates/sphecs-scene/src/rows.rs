//! Wall-fitted rows for a 2D channel along x with inclined or curved walls.
//!
//! Row j lies at the fraction (j + ½)/n of the width w(x) at every x. The columns are spaced so
//! that every particle has the same area, n Δ² between two columns:
//!
//! ```text
//! y_j(x) = lower + (j + ½)/n · w,   ∫ w dx from column k to column k + 1 = n Δ²
//! ```
//!
//! Rows outside 0 … n − 1 continue into the walls. Where w differs much from n Δ the cells are not
//! square and the density sum differs from that of the lattice. `WallFitted` is therefore for
//! channels of nearly constant width.

use glam::DVec3;

use super::expression::Expression;
use super::model::Scene;

/// Returns the points of the rows in the confines and up to `reach` (m) into the walls, m.
pub fn points(scene: &Scene, lower: &Expression, upper: &Expression, rows: usize, reach: f64) -> Vec<DVec3> {
    let (low, high) = scene.layout.confines.bounds();
    let (start, end) = domain_extent(scene, low.x, high.x);
    // Beyond the domain walls and zones extend straight.
    let walls = |x: f64| {
        let x = x.clamp(start, end);
        (lower.value(x, 0.0, 0.0, 0.0), upper.value(x, 0.0, 0.0, 0.0))
    };
    let cell = rows as f64 * scene.spacing * scene.spacing;
    let mut points = Vec::new();
    let width = |x: f64| walls(x).1 - walls(x).0;
    let mut columns = column_positions(width, start, high.x + reach, cell, 1.0);
    columns.extend(column_positions(width, start, low.x - reach, cell, -1.0));
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
fn domain_extent(scene: &Scene, low: f64, high: f64) -> (f64, f64) {
    let (domain_low, domain_high) = scene.domain.bounds();
    (domain_low.x.max(low), domain_high.x.min(high))
}

/// Returns the columns from `start` to `end`, the first half a cell from the start, then one cell
/// apart, m.
fn column_positions(width: impl Fn(f64) -> f64, start: f64, end: f64, cell: f64, direction: f64) -> Vec<f64> {
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
