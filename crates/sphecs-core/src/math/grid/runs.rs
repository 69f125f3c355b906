//! Search for neighbours: runs of rows of consecutive cells along x, each with its periodic shift.

use std::ops::Range;

use super::CellGrid;

impl<const D: usize> CellGrid<D> {
    /// Visits the rows of all cells within the support of a point of the unwrapped cell `index`.
    ///
    /// The rows come in contiguous runs, each with the shift, m, to its periodic image, in a fixed
    /// order.
    #[inline(always)]
    pub fn for_each_run(&self, index: [i64; D], visit: impl FnMut(Range<usize>, [f64; D])) {
        let first = std::array::from_fn(|d| index[d] - self.reach[d]);
        let last = std::array::from_fn(|d| index[d] + self.reach[d]);
        self.for_each_run_between(first, last, visit);
    }

    /// Visits the rows of the unwrapped cells from `first` to `last`, both included, as
    /// [`Self::for_each_run`] does.
    #[inline(always)]
    pub fn for_each_run_between(
        &self,
        first: [i64; D],
        last: [i64; D],
        visit: impl FnMut(Range<usize>, [f64; D]),
    ) {
        self.for_each_line(first, last, |_| true, visit);
    }

    /// Visits the rows of all cells within the support of the box from `lower` to `upper`, m, as
    /// [`Self::for_each_run`] does. Omitted rows are outside the support of every point of the box.
    #[inline(always)]
    pub fn for_each_run_near(
        &self,
        lower: [f64; D],
        upper: [f64; D],
        visit: impl FnMut(Range<usize>, [f64; D]),
    ) {
        let first = self.unwrapped_index(lower.map(|x| x - self.support));
        let last = self.unwrapped_index(upper.map(|x| x + self.support));
        let near = |at: [i64; D]| {
            let corner = self.corner(at);
            let mut square = 0.0;
            for d in 1..D {
                let beyond = (corner[d] - upper[d]).max(lower[d] - corner[d] - self.cell_size[d]).max(0.0);
                square += beyond * beyond;
            }
            square < self.support * self.support
        };
        self.for_each_line(first, last, near, visit);
    }

    /// Visits the lines of cells along x between `first` and `last` for which `wanted` is true.
    #[inline(always)]
    fn for_each_line(
        &self,
        mut first: [i64; D],
        mut last: [i64; D],
        wanted: impl Fn([i64; D]) -> bool,
        mut visit: impl FnMut(Range<usize>, [f64; D]),
    ) {
        for d in 0..D {
            if !self.periodic[d] {
                first[d] = first[d].max(0);
                last[d] = last[d].min(self.cells[d] as i64 - 1);
            }
            if first[d] > last[d] {
                return;
            }
        }
        // Most cells have all their neighbours inside the box and need no periodic images.
        let inside = (0..D).all(|d| first[d] >= 0 && last[d] < self.cells[d] as i64);
        let mut at = first;
        loop {
            if wanted(at) {
                if inside {
                    let line = (1..D).rev().fold(0, |line, d| line * self.cells[d] + at[d] as usize);
                    let base = line * self.cells[0];
                    let (from, to) = (base + first[0] as usize, base + last[0] as usize + 1);
                    let rows = self.starts[from] as usize..self.starts[to] as usize;
                    if !rows.is_empty() {
                        visit(rows, [0.0; D]);
                    }
                } else {
                    self.visit_line(at, first[0], last[0], &mut visit);
                }
            }
            let mut d = 1;
            while d < D {
                at[d] += 1;
                if at[d] <= last[d] {
                    break;
                }
                at[d] = first[d];
                d += 1;
            }
            if d >= D {
                return;
            }
        }
    }

    /// Visits the cells from `from` to `last` of the line along x through `at`, with one run per
    /// period.
    #[inline(always)]
    fn visit_line(
        &self,
        at: [i64; D],
        mut from: i64,
        last: i64,
        visit: &mut impl FnMut(Range<usize>, [f64; D]),
    ) {
        let mut line = 0;
        let mut shift = [0.0; D];
        for d in (1..D).rev() {
            let image = self.image(d, at[d]);
            let wrapped = at[d] - image * self.cells[d] as i64;
            line = line * self.cells[d] + wrapped as usize;
            shift[d] = image as f64 * (self.upper[d] - self.lower[d]);
        }
        let along = self.cells[0] as i64;
        let base = line * self.cells[0];
        while from <= last {
            let image = self.image(0, from);
            let to = last.min((image + 1) * along - 1);
            shift[0] = image as f64 * (self.upper[0] - self.lower[0]);
            let start = self.starts[base + (from - image * along) as usize] as usize;
            let end = self.starts[base + (to - image * along) as usize + 1] as usize;
            if start < end {
                visit(start..end, shift);
            }
            from = to + 1;
        }
    }

    /// Returns the number of periods from the box to an unwrapped index. Most cells are inside,
    /// where the division is skipped.
    #[inline]
    fn image(&self, d: usize, index: i64) -> i64 {
        let cells = self.cells[d] as i64;
        if (0..cells).contains(&index) { 0 } else { index.div_euclid(cells) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Checks that every row within the support of a point of the box is visited once per image,
    /// and few others.
    #[test]
    fn runs_near_a_box_contain_all_its_neighbours() {
        let (lengths, support) = ([1.0, 0.35, 0.8], 0.2);
        for periodic in [[false; 3], [true, true, false], [true; 3]] {
            let mut grid = CellGrid::new([0.0; 3], lengths, periodic, support, 0.1);
            let count = 700;
            // A sequence that fills the box evenly.
            let place =
                |d: usize, i: usize| lengths[d] * ((i + 1) as f64 * [0.8192, 0.6710, 0.5497][d]).fract();
            let mut position: [Vec<f64>; 3] =
                std::array::from_fn(|d| (0..count).map(|i| place(d, i)).collect());
            let id: Vec<u32> = (0..count as u32).collect();
            let order = grid.build(&position, &id, |_| true).expect("all inside").to_vec();
            for column in &mut position {
                *column = order.iter().map(|&row| column[row as usize]).collect();
            }
            for (lower, upper) in
                [([0.31, 0.12, 0.44], [0.38, 0.2, 0.45]), ([0.01, 0.3, 0.7], [0.02, 0.34, 0.79])]
            {
                let mut seen = Vec::new();
                grid.for_each_run_near(lower, upper, |rows, shift| {
                    seen.extend(rows.map(|row| (row, shift.map(|x: f64| (x * 1e6) as i64))));
                });
                let visited = seen.len();
                seen.sort_unstable();
                seen.dedup();
                assert_eq!(seen.len(), visited, "an image was visited twice");
                let mut reached = 0;
                let images = |d: usize| if periodic[d] { -1..=1 } else { 0..=0 };
                for row in 0..count {
                    for image in images(0).flat_map(|x| images(1).map(move |y| [x, y])) {
                        for z in images(2) {
                            let image = [image[0], image[1], z];
                            let shift: [f64; 3] = std::array::from_fn(|d| f64::from(image[d]) * lengths[d]);
                            let square: f64 = (0..3)
                                .map(|d| position[d][row] + shift[d])
                                .zip(lower.iter().zip(&upper))
                                .map(|(x, (lower, upper))| (x - x.clamp(*lower, *upper)).powi(2))
                                .sum();
                            let visit = (row, shift.map(|x| (x * 1e6) as i64));
                            if square < support * support {
                                reached += 1;
                                assert!(seen.binary_search(&visit).is_ok(), "{visit:?} was not visited");
                            }
                        }
                    }
                }
                assert!(reached > 20 && visited < 6 * reached, "{visited} visited for {reached}");
            }
        }
    }
}
