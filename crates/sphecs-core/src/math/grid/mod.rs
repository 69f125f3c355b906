//! Cell grid over a box fixed by the scene, with the rows of the particles in each cell.
//!
//! Origin and cells never follow the particles, so the order of a sum does not depend on the
//! outermost particles. Cells are numbered with x fastest: consecutive cells in x are one
//! contiguous run of rows. In a periodic direction the cells divide the period exactly. Neighbours
//! are searched by *unwrapped* cell indices, each a wrapped cell plus a shift by whole periods. A
//! period of one cell, or one shorter than the support, is therefore not a special case: the cell
//! is visited once per image.

pub mod cell_set;
mod runs;
mod sort;

use std::ops::Range;

use cell_set::CellSet;
use sort::SortBuffers;

/// Uniform grid of cells in `D` dimensions, and the counting sort of particles into it.
#[derive(Debug)]
pub struct CellGrid<const D: usize> {
    lower: [f64; D],
    upper: [f64; D],
    periodic: [bool; D],
    support: f64,
    cells: [usize; D],
    cell_size: [f64; D],
    inverse_cell_size: [f64; D],
    reach: [i64; D],
    starts: Vec<u32>,
    /// Cells whose rows a sort keeps; None: all.
    held: Option<CellSet>,
    order: Vec<u32>,
    buffers: SortBuffers,
}

/// Fraction of the support at its edge within which pairs may be omitted.
///
/// There both kernels are below 1e-30 of their peak. The fraction keeps rounding from extending a
/// support of exactly one cell into a second one.
const REACH_TOLERANCE: f64 = 1e-9;

impl<const D: usize> CellGrid<D> {
    /// Creates a grid over the box from `lower` to `upper`, m, with cells of about `cell_size`, m,
    /// that finds all pairs within `support`, m.
    ///
    /// # Panics
    /// If the box is empty or not finite, or `support` or `cell_size` is not positive. The checks
    /// of a scene exclude both.
    pub fn new(lower: [f64; D], upper: [f64; D], periodic: [bool; D], support: f64, cell_size: f64) -> Self {
        assert!(support > 0.0 && cell_size > 0.0, "support and cell size must be positive");
        let mut cells = [1; D];
        let mut size = [cell_size; D];
        let mut reach = [1; D];
        for d in 0..D {
            let length = upper[d] - lower[d];
            assert!(length > 0.0 && length.is_finite(), "the box of a grid must have a volume");
            if periodic[d] {
                cells[d] = ((length / cell_size * (1.0 + REACH_TOLERANCE)) as usize).max(1);
                size[d] = length / cells[d] as f64;
            } else {
                cells[d] = ((length / cell_size).ceil() as usize).max(1);
            }
            reach[d] = (support / size[d] - REACH_TOLERANCE).ceil() as i64;
        }
        let count: usize = cells.iter().product();
        Self {
            lower,
            upper,
            periodic,
            support,
            cells,
            cell_size: size,
            inverse_cell_size: size.map(|s| 1.0 / s),
            reach,
            starts: vec![0; count + 1],
            held: None,
            order: Vec::new(),
            buffers: SortBuffers::default(),
        }
    }

    /// Returns the radius within which all pairs are found, m.
    pub fn support(&self) -> f64 {
        self.support
    }

    /// Returns the number of cells.
    pub fn len(&self) -> usize {
        self.starts.len() - 1
    }

    /// Returns true if there is no cell, which never happens.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Returns the number of cells along each axis.
    pub fn cells(&self) -> [usize; D] {
        self.cells
    }

    /// Returns the edge lengths of a cell, m.
    pub fn cell_size(&self) -> [f64; D] {
        self.cell_size
    }

    /// Returns the lower corner of the box, m.
    pub fn lower(&self) -> [f64; D] {
        self.lower
    }

    /// Returns the upper corner of the box, m.
    pub fn upper(&self) -> [f64; D] {
        self.upper
    }

    /// Returns true for each periodic direction.
    pub fn periodic(&self) -> [bool; D] {
        self.periodic
    }

    /// Returns the first row of each cell, followed by the number of rows.
    ///
    /// Cell `c` holds the rows `starts[c]..starts[c + 1]` once the particles are in the order of
    /// the last [`Self::build`].
    pub fn starts(&self) -> &[u32] {
        &self.starts
    }

    /// Sets the first row of each cell, followed by the number of rows, for rows in an order that
    /// another grid of the same cells has found.
    ///
    /// # Panics
    /// If there are not as many as cells, and one.
    pub fn set_starts(&mut self, starts: Vec<u32>) {
        assert_eq!(starts.len(), self.starts.len(), "starts of another grid");
        self.starts = starts;
    }

    /// Returns a grid of the same cells without rows and without memory for them.
    pub fn without_rows(&self) -> Self {
        Self {
            starts: vec![0; self.starts.len()],
            held: self.held.clone(),
            order: Vec::new(),
            buffers: SortBuffers::default(),
            ..*self
        }
    }

    /// Sets the cells whose rows the next sorts keep; None: all.
    pub fn hold(&mut self, cells: Option<CellSet>) {
        self.held = cells;
    }

    /// Returns the rows of a cell.
    #[inline]
    pub fn rows(&self, cell: usize) -> Range<usize> {
        self.starts[cell] as usize..self.starts[cell + 1] as usize
    }

    /// Returns the rows of consecutive cells.
    #[inline]
    pub fn rows_of_run(&self, cells: &Range<usize>) -> Range<usize> {
        self.starts[cells.start] as usize..self.starts[cells.end] as usize
    }

    /// Moves a point, m, by whole periods into the box, in the periodic directions.
    pub fn wrap(&self, mut point: [f64; D]) -> [f64; D] {
        for d in 0..D {
            if self.periodic[d] && !(self.lower[d]..self.upper[d]).contains(&point[d]) {
                let length = self.upper[d] - self.lower[d];
                point[d] -= length * ((point[d] - self.lower[d]) / length).floor();
                // Rounding can move a point from just below the box onto its upper bound.
                if !(self.lower[d]..self.upper[d]).contains(&point[d]) && point[d].is_finite() {
                    point[d] = self.lower[d];
                }
            }
        }
        point
    }

    /// Returns the nearest image of a separation, m, in the periodic directions.
    pub fn nearest_image(&self, mut separation: [f64; D]) -> [f64; D] {
        for d in 0..D {
            if self.periodic[d] {
                let length = self.upper[d] - self.lower[d];
                separation[d] -= length * (separation[d] / length).round();
            }
        }
        separation
    }

    /// Returns the cell of a point, m; None if the point is outside the box or not finite.
    #[inline]
    pub fn cell_of(&self, point: [f64; D]) -> Option<usize> {
        let mut cell = 0;
        for d in (0..D).rev() {
            let x = point[d];
            let inside =
                x >= self.lower[d] && if self.periodic[d] { x < self.upper[d] } else { x <= self.upper[d] };
            if !inside {
                return None;
            }
            let along = ((x - self.lower[d]) * self.inverse_cell_size[d]) as usize;
            cell = cell * self.cells[d] + along.min(self.cells[d] - 1);
        }
        Some(cell)
    }

    /// Returns the cell of a point, m, or the cell nearest to a point outside the box.
    ///
    /// All cells in reach of the point are in reach of that cell. A point that is not finite
    /// belongs to some cell, too.
    pub fn nearest_cell(&self, point: [f64; D]) -> usize {
        let inside = self.wrap(point);
        let nearest = std::array::from_fn(|d| inside[d].max(self.lower[d]).min(self.upper[d]));
        self.cell_of(nearest).unwrap_or(0)
    }

    /// Returns the indices of a cell along each axis.
    #[inline]
    pub fn index_of(&self, mut cell: usize) -> [i64; D] {
        std::array::from_fn(|d| {
            let along = cell % self.cells[d];
            cell /= self.cells[d];
            along as i64
        })
    }

    /// Returns the unwrapped indices of the cell of a point, m, which may be outside the box.
    #[inline]
    pub fn unwrapped_index(&self, point: [f64; D]) -> [i64; D] {
        const FAR: f64 = 1e12;
        std::array::from_fn(|d| {
            (((point[d] - self.lower[d]) * self.inverse_cell_size[d]).floor()).clamp(-FAR, FAR) as i64
        })
    }

    /// Returns the lower corner of an unwrapped cell, m.
    #[inline]
    pub fn corner(&self, index: [i64; D]) -> [f64; D] {
        std::array::from_fn(|d| self.lower[d] + index[d] as f64 * self.cell_size[d])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn point_outside_belongs_to_the_nearest_cell() {
        let grid = CellGrid::<2>::new([0.0, 0.0], [3.0, 2.0], [true, false], 1.0, 1.0);
        let places = [[0.5, 0.5], [3.5, 0.5], [-0.5, 1.5], [1.5, 9.0], [1.5, -9.0], [0.5, f64::NAN]];
        assert_eq!(places.map(|place| grid.nearest_cell(place)), [0, 0, 5, 4, 1, 0]);
    }

    #[test]
    fn wrapped_point_is_inside_the_box() {
        let grid = CellGrid::new([-0.3, 0.0], [0.7, 1.0], [true, false], 0.2, 0.2);
        for x in [-0.3, 0.7, 0.7 - 1e-17, -0.3 - 1e-17, -0.3 - 1e-13, 12.4, -7.9] {
            let [wrapped, y] = grid.wrap([x, 3.0]);
            assert!((-0.3..0.7).contains(&wrapped), "{x} is wrapped to {wrapped}");
            assert_eq!(y, 3.0);
            let [columns, _] = grid.cells();
            let cell = grid.cell_of([wrapped, 0.5]).expect("a cell");
            let edge = -0.3 + (cell % columns) as f64 / columns as f64;
            let width = 1.0 / columns as f64;
            assert!((edge - 1e-12..=edge + width + 1e-12).contains(&wrapped), "{wrapped} is in cell {cell}");
        }
    }

    #[test]
    fn periodic_cells_divide_the_period() {
        let grid = CellGrid::new([0.0; 3], [1.0, 0.25, 0.9], [true, true, false], 0.3, 0.3);
        assert_eq!(grid.cells(), [3, 1, 3]);
        assert_eq!(grid.reach, [1, 2, 1]);
    }

    #[test]
    fn point_outside_has_no_cell() {
        let grid = CellGrid::new([0.0; 2], [1.0; 2], [false, true], 0.3, 0.3);
        assert_eq!(
            grid.cell_of([1.0, 0.0]),
            Some(grid.cells()[0] - 1),
            "the upper end belongs to the last cell"
        );
        for point in [[1.0 + 1e-9, 0.5], [-1e-9, 0.5], [0.5, 1.0], [f64::NAN, 0.5], [0.5, f64::INFINITY]] {
            assert_eq!(grid.cell_of(point), None, "{point:?}");
        }
    }
}
