//! Raster of the section of an opening that is no rectangle: membership and distance in its plane.

/// A section as cells of its plane, with the distance of each cell from it.
#[derive(Clone, Debug, PartialEq)]
pub struct SectionRaster {
    /// Width of a cell, m.
    cell: f64,
    /// Numbers of cells along both directions of the plane; the second is 1 in 2D.
    counts: [usize; 2],
    /// Distances of the middles of the cells from the nearest one in the section, m.
    distances: Vec<f32>,
}

impl SectionRaster {
    /// Returns the raster of `cells`, the first direction running fastest, whose common middle is
    /// the centre of the section. True marks cells of the section; `cell` is their width, m.
    pub fn new(cell: f64, counts: [usize; 2], cells: &[bool]) -> Self {
        let columns = along_columns(counts, cells);
        let row = |index: usize| &columns[index * counts[0]..][..counts[0]];
        let distances = (0..cells.len()).map(|index| {
            let (i, row) = (index % counts[0], row(index / counts[0]));
            // The nearest cell of the section is not further away than the one in the column.
            let mut least = row[i] * row[i];
            for step in 1..counts[0] {
                let aside = (step * step) as f64;
                if aside >= least {
                    break;
                }
                for other in [i.checked_sub(step), Some(i + step).filter(|at| *at < counts[0])] {
                    least = other.map_or(least, |at| least.min(aside + row[at] * row[at]));
                }
            }
            (least.sqrt() * cell) as f32
        });
        Self { cell, counts, distances: distances.collect() }
    }

    /// Returns the distance of a point of the plane from the section, m: 0 inside, exact to half a
    /// cell in the bounding rectangle, at most the distance beyond it. `offset` is its offset from
    /// the centre of the section, m.
    pub fn distance(&self, offset: [f64; 2]) -> f64 {
        let mut index = [0; 2];
        let mut beyond = 0.0_f64;
        for axis in 0..2 {
            let last = self.counts[axis] as f64 - 1.0;
            let place = offset[axis] / self.cell + 0.5 * last;
            let inside = place.clamp(0.0, last);
            // Half a cell belongs to the cell at the edge.
            beyond = beyond.hypot(((place - inside).abs() - 0.5).max(0.0));
            index[axis] = inside.round() as usize;
        }
        let (distance, beyond) =
            (f64::from(self.distances[index[0] + self.counts[0] * index[1]]), beyond * self.cell);
        // On a line both add up. In a plane the section lies at a right angle at least from the way
        // to the rectangle: their sum would cut off walls beside the corners of a turned square.
        if self.counts[1] == 1 { distance + beyond } else { distance.hypot(beyond) }
    }

    /// Returns the width of a cell, m.
    pub fn cell(&self) -> f64 {
        self.cell
    }
}

/// Returns, in cells, the distance of each cell from the nearest one of the section in its column
/// (along the second direction); infinite in a column without any.
fn along_columns(counts: [usize; 2], cells: &[bool]) -> Vec<f64> {
    let mut found = vec![f64::INFINITY; cells.len()];
    for i in 0..counts[0] {
        let mut sweep = |rows: &mut dyn Iterator<Item = usize>| {
            let mut distance = f64::INFINITY;
            for j in rows {
                let at = i + counts[0] * j;
                distance = if cells[at] { 0.0 } else { distance + 1.0 };
                found[at] = found[at].min(distance);
            }
        };
        sweep(&mut (0..counts[1]));
        sweep(&mut (0..counts[1]).rev());
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distances from a ring agree with the exact ones to a cell.
    #[test]
    fn distance_from_a_ring_is_exact_to_a_cell() {
        let (count, cell) = (81, 0.05);
        let place = |index: usize| (index as f64 - 40.0) * cell;
        let ring = |x: f64, y: f64| (x.hypot(y) - 1.1).abs() - 0.4;
        let cells: Vec<bool> =
            (0..count * count).map(|at| ring(place(at % count), place(at / count)) <= 0.0).collect();
        let raster = SectionRaster::new(cell, [count, count], &cells);
        let mut state = 1_u32;
        let mut random = || {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            f64::from(state) / f64::from(u32::MAX) * 4.0 - 2.0
        };
        for _ in 0..2000 {
            let (x, y) = (random(), random());
            let exact = ring(x, y).max(0.0);
            let found = raster.distance([x, y]);
            assert!((found - exact).abs() < 1.5 * cell, "at ({x}, {y}): {found}, exact {exact}");
        }
        assert_eq!(raster.distance([1.1, 0.0]), 0.0);
        assert!(raster.distance([0.0, 0.0]) > 0.6);
    }

    /// A square turned by 45° reaches its bounding rectangle at four points only.
    #[test]
    fn distance_beyond_the_rectangle_is_not_more_than_the_exact_one() {
        let (count, cell) = (81, 0.025);
        let place = |index: usize| (index as f64 - 40.0) * cell;
        let diamond = |x: f64, y: f64| (x.abs() + y.abs() - 1.0) / 2.0_f64.sqrt();
        let cells: Vec<bool> =
            (0..count * count).map(|at| diamond(place(at % count), place(at / count)) <= 0.0).collect();
        let raster = SectionRaster::new(cell, [count, count], &cells);
        for at in 0..40 {
            // Beside an edge, where the nearest point lies within it.
            let along = 0.2 + 0.015 * f64::from(at);
            for depth in [0.3, 0.6, 0.9] {
                let [x, y] = [along, 1.0 - along].map(|edge| edge + depth / 2.0_f64.sqrt());
                let found = raster.distance([x, y]);
                assert!(found < depth + 1.5 * cell, "at ({x}, {y}): {found}, exact {depth}");
                assert!(found > 0.7 * depth, "at ({x}, {y}): {found}, exact {depth}");
            }
        }
    }

    #[test]
    fn line_has_two_segments() {
        // Cells 2 to 4 and 7 of ten, the middle between cells 4 and 5.
        let cells: Vec<bool> = (0..10).map(|at| (2..=4).contains(&at) || at == 7).collect();
        let raster = SectionRaster::new(1.0, [10, 1], &cells);
        let distances: Vec<f64> = (0..10).map(|at| raster.distance([f64::from(at) - 4.5, 0.0])).collect();
        assert_eq!(distances, [2.0, 1.0, 0.0, 0.0, 0.0, 1.0, 1.0, 0.0, 1.0, 2.0]);
        assert_eq!(raster.distance([8.5, 0.0]), 5.5);
    }
}
