//! Search for the sides of particles, by the nearest wall particle; it finds the wall distance too.

use std::ops::Range;

use super::disc::{AtDisc, radius};
use super::{SideColumns, WallSides};
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::pass::pack::{Only, Pack, Source};
use crate::pass::row_pass::{PassInput, RowPass, splat};
use crate::pass::settings::PairSettings;
use crate::pass::sums::PairSums;

/// Finds wall distance and side of fluid, inflow and outflow particles, and the side of the
/// particles of thin walls, where there are any.
pub(in crate::pass) fn find_wall_sides<R: Real, const D: usize>(
    pair: &PairSettings,
    grid: &CellGrid<D>,
    particles: &mut ParticleArrays<R, D>,
    sums: &mut PairSums<R, D>,
) {
    let PairSums { columns, packs, sides, .. } = sums;
    let SideColumns { facing, surface_velocity, part, wall_part } = sides.write(WallSides(()));
    for column in facing.iter_mut().chain(surface_velocity.iter_mut()).chain([&mut *part, &mut *wall_part]) {
        column.resize(particles.len(), R::default());
    }
    let ParticleArrays {
        zone, patch, position, velocity, wall_distance, wall_normal, wall_thickness, ..
    } = particles;
    for (part, patch) in wall_part.iter_mut().zip(&*patch) {
        *part = R::from_f64(f64::from(*patch));
    }
    let neighbours: [&[R]; 9] = std::array::from_fn(|column| match column {
        0 => columns.image_distance.as_slice(),
        1 => wall_thickness.as_slice(),
        d if d < 2 + D => wall_normal[d - 2].as_slice(),
        d if d < 2 + 2 * D => velocity[d - 2 - D].as_slice(),
        _ => wall_part.as_slice(),
    });
    let only = Only::Positive(&columns.image_distance, &columns.walls_before);
    let input = PassInput { pair, grid, position, columns: &neighbours[..3 + 2 * D], only, packs };
    let pass = SidesPass { pair, zone, wall: (&columns.image_distance, wall_thickness, wall_normal) };
    let outputs = (
        &mut wall_distance[..],
        facing.each_mut().map(Vec::as_mut_slice),
        surface_velocity.each_mut().map(Vec::as_mut_slice),
        part.as_mut_slice(),
    );
    input.run(&pass, outputs);
}

struct SidesPass<'a, R, const D: usize> {
    pair: &'a PairSettings,
    zone: &'a [Zone],
    /// Distance behind the surface, thickness and normal of the wall particles.
    wall: (&'a [R], &'a [R], &'a [Vec<R>; D]),
}

/// Distance to the nearest surface, over h, and side of a particle.
#[derive(Clone, Copy)]
struct Side<const D: usize> {
    distance: f64,
    facing: [f64; D],
    surface_velocity: [f64; D],
    part: f64,
}

impl<const D: usize> Side<D> {
    const NONE: Self =
        Self { distance: f64::INFINITY, facing: [0.0; D], surface_velocity: [0.0; D], part: 0.0 };
}

impl<'a, R: Real, const D: usize> RowPass<R, D> for SidesPass<'a, R, D> {
    /// Wall distance, m, facing, m, velocity of the surface, m/s, and part.
    type Outputs = (&'a mut [R], [&'a mut [R]; D], [&'a mut [R]; D], &'a mut [R]);
    type Sum = Side<D>;

    #[inline(always)]
    fn includes(&self, row: usize) -> bool {
        self.zone[row].flows()
    }

    #[inline(always)]
    fn isolated(&self) -> Option<Side<D>> {
        Some(Side::NONE)
    }

    #[inline(always)]
    fn begin(&self, rows: Range<usize>, (_, facing, velocity, _): &mut Self::Outputs) {
        let (depth, thickness, normal) = self.wall;
        for d in 0..D {
            velocity[d][..rows.len()].fill(R::default());
            for (slot, row) in rows.clone().enumerate() {
                let behind = (thickness[row].to_f64() - depth[row].to_f64()).max(0.0);
                facing[d][slot] = R::from_f64(normal[d][row].to_f64() * behind);
            }
        }
    }

    #[inline(always)]
    fn sum<K: KernelShape, L: Lanes<Real = R>>(
        &self,
        pack: &Pack<R>,
        source: &Source<'_, R, D>,
        row: usize,
    ) -> Side<D> {
        let h = self.pair.discretisation.smoothing_length;
        let limit = L::constant(K::SUPPORT * K::SUPPORT);
        let disc = L::constant(radius(self.pair.discretisation.spacing) / h);
        nearest_side::<L, D>(pack, pack.relative(source, row), limit, disc, h)
    }

    #[inline(always)]
    fn store(
        &self,
        _row: usize,
        slot: usize,
        side: Side<D>,
        (distance, facing, velocity, part): &mut Self::Outputs,
    ) {
        part[slot] = R::from_f64(side.part);
        distance[slot] = R::from_f64(side.distance);
        for d in 0..D {
            facing[d][slot] = R::from_f64(side.facing[d]);
            velocity[d][slot] = R::from_f64(side.surface_velocity[d]);
        }
    }
}

/// Returns the side of a point by the nearest disc of the packed wall particles within `limit`
/// (r²/h²).
#[inline(always)]
fn nearest_side<L: Lanes, const D: usize>(
    pack: &Pack<L::Real>,
    point: [L::Real; D],
    limit: L,
    disc: L,
    h: f64,
) -> Side<D> {
    let zero = L::constant(0.0);
    let infinite = L::constant(f64::INFINITY);
    let to_h = L::constant(1.0 / h);
    let x_a = splat::<L, D>(point);
    let mut nearest = infinite;
    let mut facing = [zero; D];
    let mut velocity = [zero; D];
    let mut part = zero;
    for entry in pack.entries::<L>(3 * D + 3) {
        let depth = entry.column(D) * to_h;
        let thickness = entry.column(D + 1) * to_h;
        let normal = entry.vector::<D>(D + 2);
        let surface_velocity = entry.vector::<D>(2 * D + 2);
        let mut x = [zero; D];
        for d in 0..D {
            x[d] = x_a[d] - entry.column(d);
        }
        let AtDisc { front: along, beyond } = AtDisc::of_lanes(x, depth, normal, disc);
        // On the other side of a thin wall the distance is that to the other surface.
        let to_other = -(along + thickness);
        let is_other = along.less(L::constant(-0.5) * thickness);
        let front = L::select(is_other, to_other, along);
        let front = L::select(zero.less(thickness), front, along);
        let square = front.mul_add(front, beyond * beyond);
        let in_reach = L::select(dot(x, x).less(limit), square, infinite);
        // Where the perpendicular misses the face of the wall, the particle has no side.
        let sign = L::select(is_other, L::constant(-1.0), L::constant(1.0));
        let has_side = L::select(zero.less(beyond), zero, L::select(zero.less(thickness), sign, zero));
        let length = has_side * (front.max(zero) + thickness);
        let is_nearer = in_reach.less(nearest);
        nearest = L::select(is_nearer, in_reach, nearest);
        part = L::select(is_nearer, entry.column(3 * D + 2), part);
        for d in 0..D {
            facing[d] = L::select(is_nearer, length * normal[d], facing[d]);
            velocity[d] = L::select(is_nearer, surface_velocity[d], velocity[d]);
        }
    }
    let mut side = Side::NONE;
    let mut least = f64::INFINITY;
    let (distances, facing, velocity, part) =
        (nearest.to_array(), facing.map(L::to_array), velocity.map(L::to_array), part.to_array());
    for lane in 0..L::COUNT {
        let square = distances[lane].to_f64();
        if square < least {
            least = square;
            side.part = part[lane].to_f64();
            for d in 0..D {
                side.facing[d] = facing[d][lane].to_f64() * h;
                side.surface_velocity[d] = velocity[d][lane].to_f64();
            }
        }
    }
    side.distance = least.sqrt() * h;
    side
}
