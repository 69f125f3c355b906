//! Lines of equal value on a regular grid, by marching squares.
//!
//! In each cell of four nodes the line is straight between the points at which linear interpolation
//! along the edges has the value; the mean of the nodes decides between the two ways through a
//! saddle. A cell with a node without fluid has none, for which no crate was found.

use std::collections::BTreeMap;

use super::plane_grid::PlaneGrid;

/// Edge of a cell: its first node, and true for the edge upwards.
type Edge = (usize, bool);

/// Returns the lines of a level; a closed one ends with its first point.
pub(super) fn contours(grid: &PlaneGrid, level: f64) -> Vec<Vec<[f64; 2]>> {
    let mut next: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    let wide = grid.count[0];
    for row in 0..grid.count[1].saturating_sub(1) {
        for column in 0..wide.saturating_sub(1) {
            let first = row * wide + column;
            for [a, b] in segments(grid, first, level) {
                next.entry(a).or_default().push(b);
                next.entry(b).or_default().push(a);
            }
        }
    }
    let mut lines = Vec::new();
    // Open lines first: they begin at an edge with one neighbour.
    let ends: Vec<Edge> =
        next.iter().filter(|(_, others)| others.len() == 1).map(|(&edge, _)| edge).collect();
    let all: Vec<Edge> = next.keys().copied().collect();
    for start in ends.into_iter().chain(all) {
        let mut line = vec![start];
        let mut at = start;
        while let Some(following) = next.get_mut(&at).and_then(Vec::pop) {
            if let Some(back) = next.get_mut(&following) {
                back.iter().position(|&other| other == at).map(|index| back.swap_remove(index));
            }
            line.push(following);
            at = following;
        }
        if line.len() > 1 {
            lines.push(line.into_iter().map(|edge| crossing(grid, edge, level)).collect());
        }
    }
    lines
}

/// Returns the lines through a cell as pairs of its edges.
fn segments(grid: &PlaneGrid, first: usize, level: f64) -> Vec<[Edge; 2]> {
    let wide = grid.count[0];
    // Counterclockwise from the lower left node.
    let nodes = [first, first + 1, first + wide + 1, first + wide];
    let values = nodes.map(|node| grid.values[node]);
    if values.iter().any(|value| !value.is_finite()) {
        return Vec::new();
    }
    let edges = [(first, false), (first + 1, true), (first + wide, false), (first, true)];
    let above = values.map(|value| value >= level);
    let crossed: Vec<usize> = (0..4).filter(|&side| above[side] != above[(side + 1) % 4]).collect();
    match crossed[..] {
        [a, b] => vec![[edges[a], edges[b]]],
        [_, _, _, _] => {
            // The line turns around the nodes that the middle is not like.
            let is_middle_above = values.iter().sum::<f64>() / 4.0 >= level;
            if is_middle_above == above[0] {
                vec![[edges[0], edges[1]], [edges[2], edges[3]]]
            } else {
                vec![[edges[3], edges[0]], [edges[1], edges[2]]]
            }
        }
        _ => Vec::new(),
    }
}

/// Returns the point of an edge at which the field has the value.
fn crossing(grid: &PlaneGrid, (node, is_upward): Edge, level: f64) -> [f64; 2] {
    let wide = grid.count[0];
    let other = if is_upward { node + wide } else { node + 1 };
    let (a, b) = (grid.values[node], grid.values[other]);
    let share = ((level - a) / (b - a)).clamp(0.0, 1.0);
    let [x, y] = grid.node(node % wide, node / wide);
    if is_upward { [x, y + share * grid.step[1]] } else { [x + share * grid.step[0], y] }
}

#[cfg(test)]
mod tests {
    use super::super::plane_grid::tests::grid;
    use super::*;

    #[test]
    fn linear_field_has_a_straight_line() {
        let grid = grid(17, |[x, y]| ([0.0; 2], 2.0 * x - 3.0 * y));
        let lines = contours(&grid, 0.4);
        assert_eq!(lines.len(), 1);
        // Linear interpolation is exact up to rounding.
        let off = lines[0].iter().map(|[x, y]| (2.0 * x - 3.0 * y - 0.4).abs()).fold(0.0, f64::max);
        assert!(off < 1e-12, "{off}");
        let ends = [lines[0][0], lines[0][lines[0].len() - 1]];
        assert!(ends.iter().all(|end| end.iter().any(|x| (x.abs() - 1.0).abs() < 1e-12)), "{ends:?}");
    }

    #[test]
    fn cone_has_a_closed_circle() {
        let grid = grid(81, |[x, y]| ([0.0; 2], x.hypot(y)));
        let lines = contours(&grid, 0.5);
        assert_eq!(lines.len(), 1);
        assert_eq!(lines[0].first(), lines[0].last());
        // Second order: step²/8 over the radius, 1.6e-4.
        let off = lines[0].iter().map(|[x, y]| (x.hypot(*y) - 0.5).abs()).fold(0.0, f64::max);
        assert!(off < 2e-4, "{off}");
    }

    #[test]
    fn saddle_is_passed_and_walls_have_none() {
        let saddle = grid(2, |[x, y]| ([0.0; 2], x * y));
        assert_eq!(contours(&saddle, 0.0).len(), 2);
        let walls = grid(17, |[x, y]| ([0.0; 2], if x.abs() < 0.2 { f64::NAN } else { y }));
        let lines = contours(&walls, 0.05);
        assert_eq!(lines.len(), 2, "one on each side of the wall");
        assert!(contours(&walls, 3.0).is_empty());
    }
}
