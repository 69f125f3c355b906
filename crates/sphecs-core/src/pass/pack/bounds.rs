//! Bounding box of the packed particles; a row out of its reach needs no sum.

use super::{FAR, Pack};
use crate::math::lanes::Lanes;
use crate::math::real::Real;

/// Box around packed particles, in units of h from the centre of the pack.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds<const D: usize> {
    lower: [f64; D],
    upper: [f64; D],
}

/// Margin, relative to the squared support, by which a box must be out of reach: rounding changes a
/// squared distance by less, in f32 too.
const MARGIN: f64 = 1e-5;

impl<R: Real> Pack<R> {
    /// Returns the box around all packed particles.
    #[inline(always)]
    pub fn bounds<L: Lanes<Real = R>, const D: usize>(&self) -> Bounds<D> {
        let (far, half) = (L::constant(FAR), L::constant(0.5 * FAR));
        let mut least = [far; D];
        let mut most = [-far; D];
        for entry in self.entries::<L>(D) {
            for d in 0..D {
                let x = entry.column(d);
                least[d] = least[d].min(x);
                // The padding does not count.
                most[d] = most[d].max(L::select(x.less(half), x, -far));
            }
        }
        let (mut lower, mut upper) = ([0.0; D], [0.0; D]);
        for d in 0..D {
            (lower[d], upper[d]) = (-(-least[d]).largest().to_f64(), most[d].largest().to_f64());
        }
        Bounds { lower, upper }
    }
}

impl<const D: usize> Bounds<D> {
    /// Returns true if everything in the box is out of reach of a point, in units of h from the
    /// centre; `limit` is the square of the support over h.
    #[inline(always)]
    pub fn out_of_reach<R: Real>(&self, point: [R; D], limit: f64) -> bool {
        let mut square = 0.0;
        for d in 0..D {
            let x = point[d].to_f64();
            let (below, above) = (self.lower[d] - x, x - self.upper[d]);
            let beyond = if below > above { below } else { above };
            square += if beyond > 0.0 { beyond * beyond } else { 0.0 };
        }
        square > limit * (1.0 + MARGIN)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::grid::CellGrid;
    use crate::math::lanes::{InstructionSet, Vectorised};
    use crate::pass::pack::{Only, Source};

    /// Number of particles on a line through the middle of one cell.
    struct Line(usize);

    impl<R: Real> Vectorised<R> for Line {
        type Output = Bounds<2>;
        type Module = Self;

        #[inline(always)]
        fn run<L: Lanes<Real = R>>(self) -> Bounds<2> {
            let mut grid = CellGrid::new([0.0; 2], [4.0; 2], [false; 2], 4.0, 4.0);
            let along = |scale: f64| (0..self.0).map(|i| 1.0 + scale * i as f64).collect();
            let position = [along(0.0625), along(0.03125)];
            let id: Vec<u32> = (0..self.0 as u32).collect();
            grid.build(&position, &id, |_| true).expect("all inside");
            let source = Source {
                grid: &grid,
                position: &position,
                columns: &[],
                inverse_h: 0.5,
                support_ratio: 2.0,
                only: Only::All,
            };
            let mut pack = Pack::default();
            assert!(pack.fill::<L, 2>(&source, 0, |_| true));
            pack.bounds::<L, 2>()
        }
    }

    #[test]
    fn box_excludes_the_padding() {
        for set in InstructionSet::available() {
            for count in [1, 3, 8, 31] {
                let last = (count - 1) as f64;
                let expected = Bounds { lower: [-0.5; 2], upper: [-0.5 + last / 32.0, -0.5 + last / 64.0] };
                assert_eq!(f64::dispatch(set, Line(count)), expected, "{count} by {}", set.name());
                assert_eq!(f32::dispatch(set, Line(count)), expected, "{count} by {}", set.name());
            }
        }
    }

    #[test]
    fn reach_is_measured_from_sides_and_corners() {
        let bounds = Bounds { lower: [-1.0, 0.0], upper: [1.0, 0.5] };
        for (point, square) in [([0.3, 0.2], 0.0), ([-3.0, 0.2], 4.0), ([2.0, 2.5], 5.0), ([0.0, -1.5], 2.25)]
        {
            assert!(!bounds.out_of_reach(point, square), "{point:?}");
            assert!(bounds.out_of_reach(point, square * 0.999 - 1e-9), "{point:?}");
        }
    }
}
