//! Distance of flow particles to the nearest wall surface.
//!
//! ```text
//! d_a = min_b √(t_n² + t_s²)
//! ```
//!
//! with the discs of the wall particles (`wall_sides/disc.rs`). At a concave corner the nearer wall
//! counts. The distance is positive on both sides of the surface.

use super::pack::{Only, Pack, Source};
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use super::wall_sides::{AtDisc, find_wall_sides, radius};
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Finds the wall distance of fluid, inflow and outflow particles, m; infinite where no wall is in
/// the support.
pub fn find_wall_distance<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    sums.packs.prepare();
    if !sums.columns.find_walls(pair, particles) {
        particles.wall_distance.fill(R::from_f64(f64::INFINITY));
        return;
    }
    if !particles.wall_thickness.is_empty() || pair.ranks.have_thin_walls() {
        find_wall_sides(pair, grid, particles, sums);
        return;
    }
    let PairSums { columns, packs, .. } = sums;
    let ParticleArrays { zone, position, wall_distance, wall_normal, .. } = particles;
    let neighbours: [&[R]; 4] = std::array::from_fn(|column| match column {
        0 => columns.image_distance.as_slice(),
        d if d <= D => wall_normal[d - 1].as_slice(),
        _ => &[],
    });
    let only = Only::Positive(&columns.image_distance, &columns.walls_before);
    let input = PassInput { pair, grid, position, columns: &neighbours[..=D], only, packs };
    input.run(&WallDistancePass { pair, zone }, &mut wall_distance[..]);
}

struct WallDistancePass<'a> {
    pair: &'a PairSettings,
    zone: &'a [Zone],
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for WallDistancePass<'a> {
    type Outputs = &'a mut [R];
    /// Distance, m.
    type Sum = f64;

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.zone[row].flows()
    }

    #[inline(always)]
    fn isolated(&self) -> Option<f64> {
        Some(f64::INFINITY)
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> f64 {
        let h = self.pair.discretisation.smoothing_length;
        let limit = L::constant(K::SUPPORT * K::SUPPORT);
        let disc = L::constant(radius(self.pair.discretisation.spacing) / h);
        let to_h = L::constant(1.0 / h);
        nearest_disc::<L, D>(pack, pack.relative(source, row), limit, disc, to_h) * h
    }

    #[inline(always)]
    fn store(&self, _row: usize, slot: usize, nearest: f64, distance: &mut &'a mut [R]) {
        distance[slot] = R::from_f64(nearest);
    }
}

/// Returns the distance, in units of h, to the nearest disc of the packed wall particles within
/// `limit` (r²/h²).
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
    let x_a = splat::<L, D>(point);
    let mut nearest = infinite;
    for entry in pack.entries::<L>(2 * D + 1) {
        let depth = entry.column(D);
        let normal = entry.vector::<D>(D + 1);
        let mut x = [zero; D];
        for d in 0..D {
            x[d] = x_a[d] - entry.column(d);
        }
        let AtDisc { front, beyond } = AtDisc::of_lanes(x, depth * to_h, normal, disc);
        let square = front.mul_add(front, beyond * beyond);
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

    /// A block whose particles with positive `depth` (m) are wall, with the given normal; returns
    /// the distances found by position.
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
    fn distance_at_corners_is_to_the_nearer_surface() {
        let edge = 6.0 * SPACING;
        // Convex: the wall fills x < edge and y < edge. Concave: it fills all but x > edge and
        // y > edge.
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
