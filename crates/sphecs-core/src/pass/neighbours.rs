//! Neighbours of a point, one by one.
//!
//! This is the scalar counterpart of the packed passes, for few points such as probes, inlets and
//! outlets. Periodic images are included, always in the same order.

use std::ops::Range;

use crate::math::grid::CellGrid;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Particles of which the distances are computed before any is visited, in vectors.
const BLOCK: usize = 64;

/// Search for neighbours in sorted arrays, valid from the sort until the next change of position.
#[derive(Clone, Copy, Debug)]
pub struct Neighbours<'a, R: Real, const D: usize> {
    /// Grid that the particles were sorted with.
    pub grid: &'a CellGrid<D>,
    /// The sorted particles.
    pub particles: &'a ParticleArrays<R, D>,
    /// Radius of the search, m; not more than the support of the grid.
    pub support: f64,
}

impl<'a, R: Real, const D: usize> Neighbours<'a, R, D> {
    /// Searches within the support of the grid.
    pub fn new(grid: &'a CellGrid<D>, particles: &'a ParticleArrays<R, D>) -> Self {
        Self { grid, particles, support: grid.support() }
    }

    /// Searches within a radius, m, much smaller than the support of the grid, so that few cells
    /// are visited.
    pub fn within(radius: f64, grid: &'a CellGrid<D>, particles: &'a ParticleArrays<R, D>) -> Self {
        Self { grid, particles, support: radius }
    }

    /// Visits each particle, or periodic image, nearer to `point` than the radius.
    ///
    /// `visit` gets its row, `x_ab = point − x_b`, m, and r², m². A particle at the point itself is
    /// visited too.
    #[inline(always)]
    pub fn for_each(&self, point: [f64; D], mut visit: impl FnMut(usize, [f64; D], f64)) {
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        let limit = self.support * self.support;
        let (mut squares, mut near) = ([0.0; BLOCK], [0_u8; BLOCK]);
        self.for_each_run(point, |rows, shift| {
            for from in rows.clone().step_by(BLOCK) {
                let to = rows.end.min(from + BLOCK);
                self.squares(from..to, point, shift, &mut squares);
                // Without a branch, which no processor would predict.
                let mut count = 0;
                for at in 0..to - from {
                    near[count] = at as u8;
                    count += usize::from(squares[at] < limit);
                }
                for &at in &near[..count] {
                    let row = from + usize::from(at);
                    let mut x_ab = [0.0; D];
                    for d in 0..D {
                        x_ab[d] = point[d] - (self.particles.position[d][row] + shift[d]);
                    }
                    visit(row, x_ab, squares[usize::from(at)]);
                }
            }
        });
    }

    /// Computes r², m², of at most [`BLOCK`] rows.
    ///
    /// Loops, since the functions of arrays and iterators would be calls.
    #[inline(always)]
    fn squares(&self, rows: Range<usize>, point: [f64; D], shift: [f64; D], squares: &mut [f64; BLOCK]) {
        let squares = &mut squares[..rows.len()];
        squares.fill(0.0);
        for d in 0..D {
            for (square, x) in squares.iter_mut().zip(&self.particles.position[d][rows.clone()]) {
                let x_ab = point[d] - (x + shift[d]);
                *square += x_ab * x_ab;
            }
        }
    }

    /// Visits as [`Self::for_each`] does, but only rows from `first` on and with their squared
    /// distances, m²; meant for a radius within which there is hardly ever a particle.
    #[inline]
    pub fn for_each_rare(&self, first: usize, point: [f64; D], mut visit: impl FnMut(usize, f64)) {
        if !point.iter().all(|x| x.is_finite()) {
            return;
        }
        let limit = self.support * self.support;
        let mut squares = [0.0; BLOCK];
        self.for_each_run(point, |rows, shift| {
            for from in (first.max(rows.start)..rows.end).step_by(BLOCK) {
                let block = from..rows.end.min(from + BLOCK);
                self.squares(block.clone(), point, shift, &mut squares);
                let mut least = f64::INFINITY;
                for &square in &squares[..block.len()] {
                    least = if square < least { square } else { least };
                }
                if least < limit {
                    let near = block.filter(|row| squares[row - from] < limit);
                    near.for_each(|row| visit(row, squares[row - from]));
                }
            }
        });
    }

    /// Visits the runs of rows in all cells within the radius, with the shift of their image, m.
    #[inline(always)]
    fn for_each_run(&self, point: [f64; D], visit_run: impl FnMut(Range<usize>, [f64; D])) {
        if self.support < self.grid.support() {
            let reach = self.support * (1.0 + 1e-9);
            let corner = |sign: f64| self.grid.unwrapped_index(point.map(|x| x + sign * reach));
            self.grid.for_each_run_between(corner(-1.0), corner(1.0), visit_run);
        } else {
            self.grid.for_each_run_near(point, point, visit_run);
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use proptest::arbitrary::any;
    use proptest::proptest;
    use proptest::test_runner::Config;

    use super::*;
    use crate::particles::arrays::SpareColumns;
    use crate::particles::rows::ParticleRow;
    use crate::particles::zone::Zone;

    /// Particles at the given fractions of the box, all fluid but every seventh, which is stored.
    fn cloud<const D: usize>(
        lower: [f64; D],
        upper: [f64; D],
        fractions: &[[f64; D]],
    ) -> ParticleArrays<f64, D> {
        let mut arrays = ParticleArrays::default();
        for (row, fraction) in fractions.iter().enumerate() {
            let zone = if row % 7 == 6 { Zone::Reservoir } else { Zone::Fluid };
            let mut position = DVec3::ZERO;
            for d in 0..D {
                position[d] = lower[d] + fraction[d] * (upper[d] - lower[d]);
            }
            arrays.push(&ParticleRow {
                id: (row as u32 * 7919) % 10007,
                zone,
                position,
                ..Default::default()
            });
        }
        arrays
    }

    /// Pairs (id, id, r²) through the grid against all pairs of all images.
    fn check<const D: usize>(length: [f64; D], periodic: [bool; D], cell: f64, fractions: &[[f64; D]]) {
        let support = 0.5;
        let lower = [-0.37; D];
        let upper = std::array::from_fn(|d| lower[d] + length[d]);
        let mut arrays = cloud(lower, upper, fractions);
        let mut grid = CellGrid::new(lower, upper, periodic, support, cell);
        let zone = arrays.zone.clone();
        let order = grid
            .build(&arrays.position, &arrays.id, |row| zone[row] != Zone::Reservoir)
            .expect("the cloud fills the box");
        arrays.reorder(order, &mut SpareColumns::default());

        for radius in [support, 0.3 * support] {
            check_within(radius, length, periodic, &grid, &arrays);
        }
    }

    fn check_within<const D: usize>(
        radius: f64,
        length: [f64; D],
        periodic: [bool; D],
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<f64, D>,
    ) {
        let support = grid.support();
        let neighbours = if radius < support {
            Neighbours::within(radius, grid, arrays)
        } else {
            Neighbours::new(grid, arrays)
        };
        let images: [i64; D] =
            std::array::from_fn(|d| if periodic[d] { (support / length[d]).ceil() as i64 + 1 } else { 0 });
        let mut expected = Vec::new();
        let mut found = Vec::new();
        for a in 0..arrays.len() {
            let point: [f64; D] = std::array::from_fn(|d| arrays.position[d][a]);
            let mut image: [i64; D] = images.map(|n| -n);
            'images: loop {
                for b in 0..arrays.len() {
                    let r2: f64 = (0..D)
                        .map(|d| (point[d] - (arrays.position[d][b] + image[d] as f64 * length[d])).powi(2))
                        .sum();
                    // Rounding may put a pair on the edge on either side.
                    if r2 < radius * radius * (1.0 - 1e-9) {
                        expected.push((arrays.id[a], arrays.id[b], (r2 * 1e9).round() as i64));
                    }
                }
                for d in 0..D {
                    image[d] += 1;
                    if image[d] <= images[d] {
                        continue 'images;
                    }
                    image[d] = -images[d];
                }
                break;
            }
            let mut later = Vec::new();
            neighbours.for_each(point, |b, _, _| later.extend((b > a).then_some(b)));
            let mut rare = Vec::new();
            neighbours.for_each_rare(a + 1, point, |b, _| rare.push(b));
            assert_eq!(rare, later);
            neighbours.for_each(point, |b, x_ab, r2| {
                assert!((x_ab.iter().map(|x| x * x).sum::<f64>() - r2).abs() < 1e-15);
                if r2 < radius * radius * (1.0 - 1e-9) {
                    found.push((arrays.id[a], arrays.id[b], (r2 * 1e9).round() as i64));
                }
            });
        }
        expected.sort_unstable();
        found.sort_unstable();
        assert_eq!(found.len(), expected.len());
        for (found, expected) in found.iter().zip(&expected) {
            // r² through a shifted image and directly differ by rounding, hence ± 1 of 1e-9.
            assert!((found.0, found.1) == (expected.0, expected.1) && (found.2 - expected.2).abs() <= 1);
        }
    }

    proptest! {
        #![proptest_config(Config::with_cases(48))]

        #[test]
        fn neighbours_agree_with_brute_force_in_2d(
            length in [0.1..3.0, 0.1..3.0],
            periodic in [any::<bool>(), any::<bool>()],
            cell in 0.2..0.6,
            fractions in proptest::collection::vec([0.0..1.0, 0.0..1.0], 1..60),
        ) {
            check(length, periodic, cell, &fractions);
        }

        #[test]
        fn neighbours_agree_with_brute_force_in_3d(
            length in [0.1..2.0, 0.1..2.0, 0.1..2.0],
            periodic in [any::<bool>(), any::<bool>(), any::<bool>()],
            cell in 0.2..0.6,
            fractions in proptest::collection::vec([0.0..1.0, 0.0..1.0, 0.0..1.0], 1..40),
        ) {
            check(length, periodic, cell, &fractions);
        }
    }

    #[test]
    fn a_particle_in_one_periodic_cell_has_its_own_images_as_neighbours() {
        // With period 0.2 and support 0.5 there are images at ± 0.2 and ± 0.4 besides the particle
        // itself.
        check([0.2, 0.2], [true, false], 0.5, &[[0.25, 0.5]]);
        let mut grid = CellGrid::new([0.0; 2], [0.2, 0.2], [true, false], 0.5, 0.5);
        let arrays = cloud([0.0; 2], [0.2, 0.2], &[[0.25, 0.5]]);
        grid.build(&arrays.position, &arrays.id, |_| true).expect("inside");
        let mut count = 0;
        Neighbours::new(&grid, &arrays).for_each([0.05, 0.1], |_, _, _| count += 1);
        assert_eq!(count, 5);
    }
}
