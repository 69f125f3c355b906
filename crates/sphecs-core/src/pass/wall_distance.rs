//! Distance of the flow's particles to the nearest wall surface.
//!
//! ```text
//! s_b = x_b + d_b n_b,   t = x_a − s_b,   t_n = t·n_b,   t_s = √(|t|² − t_n²)
//! d_a = min_b √(t_n² + max(0, t_s − R)²),   R = 0.75 Δ
//! ```
//!
//! Every wall particle knows the foot point on its surface, and stands for a disc of it of radius R: more than half the
//! diagonal of a lattice cell, so that the discs of a flat wall leave no gap and its distance is exact. At a convex
//! corner a disc stands out by no more than R − Δ/2 and so shortens a distance by no more than that; beside the
//! particle of the corner itself, which belongs to one face only, a distance to the other is 12 % too long. At a concave
//! corner the nearer wall counts. The distance is positive on both sides of the surface.

use std::ops::Range;

use super::blocks::for_each_block;
use super::pack::{Only, Pack, Source};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::lanes::{Lanes, Vectorised, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Radius of the disc that a wall particle stands for, over Δ.
const DISC: f64 = 0.75;

/// Finds the wall distance of the fluid, inflow and outflow rows; infinite where no wall is in the support.
pub fn find_wall_distance<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if sums.columns.find_walls(pair, particles) == 0 {
        particles.wall_distance.fill(R::from_f64(f64::INFINITY));
        return;
    }
    let columns = &sums.columns;
    let neighbours: [&[R]; 4] = std::array::from_fn(|column| match column {
        0 => columns.image_distance.as_slice(),
        d if d <= D => particles.wall_normal[d - 1].as_slice(),
        _ => &[],
    });
    let source = Source {
        grid,
        position: &particles.position,
        columns: &neighbours[..=D],
        inverse_h: 1.0 / pair.smoothing_length,
        support_ratio: pair.kernel.support_ratio(),
        only: Only::Positive(&columns.image_distance, &columns.walls_before),
    };
    let packs = &sums.packs;
    let zone = &particles.zone;
    let work = |cells: Range<usize>, distance: &mut [R]| {
        let block =
            DistanceBlock { pair, source: &source, zone, cells, distance, pack: &mut packs.of_this_thread() };
        R::dispatch(pair.lanes, block);
    };
    for_each_block(grid, particles.wall_distance.as_mut_slice(), &work, &|(), ()| ());
}

struct DistanceBlock<'a, R: Real, const D: usize> {
    pair: &'a PairSettings,
    source: &'a Source<'a, R, D>,
    zone: &'a [Zone],
    cells: Range<usize>,
    distance: &'a mut [R],
    pack: &'a mut Pack<R>,
}

impl<R: Real, const D: usize> Vectorised<R> for DistanceBlock<'_, R, D> {
    type Output = ();

    #[inline(always)]
    fn run<L: Lanes<Real = R>>(self) {
        let grid = self.source.grid;
        let first = grid.rows(self.cells.start).start;
        let h = self.pair.smoothing_length;
        let square = self.source.support_ratio.powi(2);
        let limit = L::constant(square);
        let disc = L::constant(DISC * self.pair.spacing / h);
        let to_h = L::constant(1.0 / h);
        for cell in self.cells {
            let rows = grid.rows(cell);
            let flows = |zone: Zone| matches!(zone, Zone::Fluid | Zone::Inflow | Zone::Outflow);
            if !self.pack.fill::<L, D>(self.source, cell, |row| flows(self.zone[row])) {
                continue;
            }
            let has_none = self.pack.is_empty();
            let walls = self.pack.bounds::<L, D>();
            for row in rows {
                if !flows(self.zone[row]) {
                    continue;
                }
                let point = self.pack.relative(self.source, row);
                let nearest = if has_none || walls.out_of_reach(point, square) {
                    f64::INFINITY
                } else {
                    nearest_disc::<L, D>(self.pack, point, limit, disc, to_h) * h
                };
                self.distance[row - first] = R::from_f64(nearest);
            }
        }
    }
}

/// Distance, in units of h, to the nearest disc of the packed wall particles within `limit` (r²/h²).
#[inline(always)]
fn nearest_disc<L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
    limit: L,
    disc: L,
    to_h: L,
) -> f64 {
    let zero = L::constant(0.0);
    let infinite = L::constant(f64::INFINITY);
    let mut x_a = [zero; D];
    for d in 0..D {
        x_a[d] = L::splat(point[d]);
    }
    let mut nearest = infinite;
    for entry in pack.entries::<L>(2 * D + 1) {
        let depth = entry.column(D);
        let normal = entry.vector::<D>(D + 1);
        let mut x = [zero; D];
        let mut foot = [zero; D];
        for d in 0..D {
            x[d] = x_a[d] - entry.column(d);
            foot[d] = x[d] - depth * to_h * normal[d];
        }
        let along = dot(foot, normal);
        let aside = (dot(foot, foot) - along * along).max(zero).sqrt();
        let beyond = (aside - disc).max(zero);
        let square = along.mul_add(along, beyond * beyond);
        nearest = nearest.min(L::select(dot(x, x).less(limit), square, infinite));
    }
    let largest = (-nearest).largest().to_f64();
    (-largest).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::samples::{SPACING, Sample, settings};

    /// A block whose particles with positive `depth` (m) are wall, with the given normal; returns the distances found by
    /// position.
    fn distances<const D: usize>(
        counts: [usize; D],
        depth: impl Fn([f64; D]) -> f64,
        normal: impl Fn([f64; D]) -> [f64; D],
    ) -> Vec<([f64; D], f64)> {
        let mut sample = Sample::<f64, D>::lattice(settings(Kernel::WendlandC2, D, 1.5), counts, false);
        let particles = &mut sample.particles;
        let point = |particles: &ParticleArrays<f64, D>, row: usize| -> [f64; D] {
            std::array::from_fn(|d| particles.position[d][row] + 0.3)
        };
        for row in 0..particles.len() {
            let x = point(particles, row);
            if depth(x) > 0.0 {
                particles.zone[row] = Zone::Wall;
                particles.wall_distance[row] = depth(x);
                let normal = normal(x);
                for d in 0..D {
                    particles.wall_normal[d][row] = normal[d];
                }
            }
        }
        find_wall_distance(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
        let particles = &sample.particles;
        let fluid = (0..particles.len()).filter(|&row| particles.zone[row] == Zone::Fluid);
        fluid.map(|row| (point(particles, row), particles.wall_distance[row])).collect()
    }

    #[test]
    fn distance_to_a_flat_wall_is_exact() {
        let surface = 4.0 * SPACING;
        for (x, found) in distances([10, 12, 9], |x| surface - x[1], |_| [0.0, 1.0, 0.0]) {
            let expected = x[1] - surface;
            // The first layer of the wall is half a spacing behind its surface.
            if expected < 2.4 * SPACING {
                assert!((found - expected).abs() < 1e-12, "{found} at {x:?}, not {expected}");
            } else {
                assert_eq!(found, f64::INFINITY);
            }
        }
    }

    #[test]
    fn distance_at_corners_is_that_of_the_nearer_surface() {
        let edge = 6.0 * SPACING;
        // Convex: the wall fills x < edge and y < edge. Concave: it fills all but x > edge and y > edge.
        for convex in [true, false] {
            let depth = |x: [f64; 2]| {
                let (along_x, along_y) = (edge - x[0], edge - x[1]);
                if convex {
                    along_x.min(along_y)
                } else if along_x > 0.0 && along_y > 0.0 {
                    along_x.hypot(along_y)
                } else {
                    along_x.max(along_y)
                }
            };
            let normal = |x: [f64; 2]| {
                let (along_x, along_y) = (edge - x[0], edge - x[1]);
                if !convex && along_x > 0.0 && along_y > 0.0 {
                    [along_x / depth(x), along_y / depth(x)]
                } else if (along_x < along_y) == convex {
                    [1.0, 0.0]
                } else {
                    [0.0, 1.0]
                }
            };
            for (x, found) in distances([14, 14], depth, normal) {
                let (along_x, along_y) = (x[0] - edge, x[1] - edge);
                let expected = if !convex {
                    along_x.min(along_y)
                } else if along_x > 0.0 && along_y > 0.0 {
                    along_x.hypot(along_y)
                } else {
                    along_x.max(along_y)
                };
                if expected < 1.4 * SPACING {
                    let shorter = if convex { 0.251 * SPACING } else { 1e-12 };
                    let longer = if convex { 1.12 } else { 1.0 + 1e-12 };
                    assert!(found > 0.0 && found < longer * expected, "{found} at {x:?}, not {expected}");
                    assert!(found > expected - shorter, "{found} at {x:?}, not {expected}");
                }
            }
        }
    }
}
