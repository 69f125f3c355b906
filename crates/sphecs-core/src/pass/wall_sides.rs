//! Sides of thin walls: whether a pair of particles has a thin wall between it.
//!
//! ```text
//! e_a = ± n_w of the nearest wall particle, towards particle a;  f_a = e_a (d_a + t) for flow,
//! f_w = n_w (t − d_w) for a particle of the wall itself
//! behind(a, b):  (x_a − x_b)·e_a > d_a   and   d_b' = −f_b·e_a > 0
//! ```
//!
//! t is the thickness of the wall, d the distance to its surface. A wall thinner than the support
//! has too few particles to fill the support of the fluid on one side, which reaches the fluid on
//! the other. Here that fluid stands for the missing wall particles: in the sums of particle a, a
//! neighbour b behind the wall is a wall particle at the depth d_b' behind the surface that faces
//! a, with the velocity of the wall and the pressure of a mirrored. So no momentum crosses the
//! wall, the support stays full, and there are no further particles. Particles of the wall itself
//! that are nearer to its other side are seen in the same way.
//!
//! A particle has a side where the foot of its perpendicular is on a face of the wall, so it has
//! none beyond an edge. The method is our own.

use super::column_access::FusedInputsReader;
use super::neighbours::Neighbours;
use super::pack::{ColumnList, Entry, Only, Pack, Source, Vector};
use super::row_pass::{PassInput, RowPass, splat};
use super::settings::PairSettings;
use super::sums::PairSums;
use crate::math::grid::CellGrid;
use crate::math::kernel::KernelShape;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use std::ops::Range;

/// Radius R of the disc that a wall particle represents, over Δ.
pub(super) const DISC: f64 = 0.75;

/// Writer of the sides.
#[derive(Debug)]
pub struct WallSides(());

/// Sides of the particles near thin walls.
#[derive(Debug)]
pub struct SideColumns<R, const D: usize> {
    /// f of the module head, m; 0 for particles without a side.
    pub facing: [Vec<R>; D],
    /// Velocity of the surface that a particle faces, m/s.
    pub surface_velocity: [Vec<R>; D],
    /// Part of the wall that a particle of the flow faces; meaningless without a side.
    pub part: Vec<R>,
    /// Part of each wall particle, for the search.
    wall_part: Vec<R>,
}

impl<R, const D: usize> Default for SideColumns<R, D> {
    fn default() -> Self {
        Self {
            facing: std::array::from_fn(|_| Vec::new()),
            surface_velocity: std::array::from_fn(|_| Vec::new()),
            part: Vec::new(),
            wall_part: Vec::new(),
        }
    }
}

/// Finds wall distance and side of fluid, inflow and outflow particles, and the side of the
/// particles of thin walls, where there are any.
pub(super) fn find_wall_sides<R: Real, const D: usize>(
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
        let disc = L::constant(DISC * self.pair.discretisation.spacing / h);
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
        let mut foot = [zero; D];
        for d in 0..D {
            x[d] = x_a[d] - entry.column(d);
            foot[d] = x[d] - depth * normal[d];
        }
        let along = dot(foot, normal);
        let aside = (dot(foot, foot) - along * along).max(zero).sqrt();
        let beyond = (aside - disc).max(zero);
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

/// Side of a point.
#[derive(Clone, Copy, Debug)]
pub(super) struct PointSide<'a, R, const D: usize> {
    sides: &'a SideColumns<R, D>,
    /// Normal of the surface that the point faces.
    pub normal: [f64; D],
    /// Distance to that surface, m.
    pub front: f64,
}

impl<'a, R: Real, const D: usize> PointSide<'a, R, D> {
    /// Returns the side of a point (m); None where the nearest wall is not thin, and beyond an edge.
    pub(super) fn at(
        neighbours: &Neighbours<'_, R, D>,
        pair: &PairSettings,
        sides: &'a SideColumns<R, D>,
        point: [f64; D],
    ) -> Option<Self> {
        let particles = neighbours.particles;
        if particles.wall_thickness.is_empty() {
            return None;
        }
        let disc = DISC * pair.discretisation.spacing;
        let (mut nearest, mut side) = (f64::INFINITY, None);
        neighbours.for_each(point, |row, x_ab, _| {
            if particles.zone[row] != Zone::Wall {
                return;
            }
            let normal: [f64; D] = std::array::from_fn(|d| particles.wall_normal[d][row].to_f64());
            let (depth, thickness) =
                (particles.wall_distance[row].to_f64(), particles.wall_thickness[row].to_f64());
            let foot: [f64; D] = std::array::from_fn(|d| x_ab[d] - depth * normal[d]);
            let product = |a: &[f64; D], b: &[f64; D]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
            let along = product(&foot, &normal);
            let beyond = ((product(&foot, &foot) - along * along).max(0.0).sqrt() - disc).max(0.0);
            let is_other = thickness > 0.0 && along < -0.5 * thickness;
            let front = if is_other { -(along + thickness) } else { along };
            let square = front * front + beyond * beyond;
            if square < nearest {
                nearest = square;
                let sign = if is_other { -1.0 } else { 1.0 };
                let has_side = thickness > 0.0 && beyond == 0.0;
                side =
                    has_side.then(|| Self { sides, normal: normal.map(|n| sign * n), front: front.max(0.0) });
            }
        });
        side
    }

    /// Returns true if a particle of the flow is behind the wall that the point faces; x is the point
    /// less the position of the particle, m.
    pub(super) fn hides(&self, row: usize, x: [f64; D]) -> bool {
        let along =
            |d: usize| self.sides.facing[d].get(row).map_or(0.0, |facing| facing.to_f64()) * self.normal[d];
        let depth: f64 = -(0..D).map(along).sum::<f64>();
        let into: f64 = x.iter().zip(self.normal).map(|(x, n)| x * n).sum();
        depth > 0.0 && into > self.front
    }
}

/// Adds the column of the facing, where a wall is thin.
pub(super) fn facing_column<'a, R: Real, const D: usize, const MOST: usize>(
    list: &mut ColumnList<'a, R, D, MOST>,
    sums: &'a PairSums<R, D>,
) -> Option<Vector> {
    let facing = &sums.sides.read(FusedInputsReader).facing;
    (!facing[0].is_empty()).then(|| list.add_vector(facing))
}

/// Side of a particle, in every lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct OwnSide<L, const D: usize> {
    /// e_a; 0 for a particle without a side.
    normal: [L; D],
    /// d_a/h, infinite for a particle without a side.
    front: L,
    /// Velocity of the surface that it faces, m/s.
    velocity: [L; D],
}

impl<L: Lanes, const D: usize> OwnSide<L, D> {
    /// Returns the side of a row; none where no wall is thin.
    #[inline(always)]
    pub(super) fn new(
        sides: &SideColumns<L::Real, D>,
        row: usize,
        wall_distance: f64,
        h: f64,
        only: Option<u16>,
    ) -> Self {
        let zero = L::constant(0.0);
        let mut own = Self { normal: [zero; D], front: L::constant(f64::INFINITY), velocity: [zero; D] };
        if sides.facing[0].is_empty() || only.is_some_and(|part| sides.part[row].to_f64() != f64::from(part))
        {
            return own;
        }
        let mut square = 0.0;
        for d in 0..D {
            let f = sides.facing[d][row].to_f64();
            square += f * f;
        }
        if square > 0.0 {
            let scale = 1.0 / square.sqrt();
            own.front = L::constant(wall_distance / h);
            for d in 0..D {
                own.normal[d] = L::constant(sides.facing[d][row].to_f64() * scale);
                own.velocity[d] = L::splat(sides.surface_velocity[d][row]);
            }
        }
        own
    }

    /// Returns the relative velocity with that of the wall in place of neighbours behind it, m/s.
    #[inline(always)]
    pub(super) fn relative_velocity(&self, behind: &Behind<L>, own: [L; D], v: [L; D]) -> [L; D] {
        let mut seen = v;
        for d in 0..D {
            seen[d] = L::select(behind.mask(), own[d] - self.velocity[d], v[d]);
        }
        seen
    }
}

/// Neighbours behind a thin wall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Behind<L> {
    /// Depth behind the surface that the particle faces, m; 0 for other neighbours.
    pub depth: L,
}

impl<L: Lanes> Behind<L> {
    /// Returns the neighbours behind the wall that a particle faces; x is x_ab/h.
    #[inline(always)]
    pub(super) fn new<const D: usize>(
        side: &OwnSide<L, D>,
        facing: Vector,
        neighbours: Entry<'_, L>,
        x: [L; D],
    ) -> Self {
        let zero = L::constant(0.0);
        let depth = (-dot(neighbours.vector_at(facing), side.normal)).max(zero);
        Self { depth: L::select(side.front.less(dot(x, side.normal)), depth, zero) }
    }

    /// Returns a factor of the pairs with neighbours that have a side but are not behind the wall:
    /// 0 for these, 1 for all others.
    #[inline(always)]
    pub(super) fn of_wall<const D: usize>(&self, facing: Vector, neighbours: Entry<'_, L>, wall: L) -> L {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let f: [L; D] = neighbours.vector_at(facing);
        let flows = L::select(zero.less(wall.abs()), zero, dot(f, f));
        L::select(zero.less(flows), zero, one)
    }

    /// Returns the lanes of neighbours behind the wall.
    #[inline(always)]
    pub(super) fn mask(&self) -> L::Mask {
        L::constant(0.0).less(self.depth)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::kernel::Kernel;
    use crate::pass::edac;
    use crate::pass::samples::{SPACING, Sample, WATER, assert_close, noise, settings};
    use crate::pass::settings::PressureLaw;
    use crate::pass::wall_distance::find_wall_distance;
    use crate::pass::walls::extrapolate_wall_pressure;
    use crate::physics::edac::Edac;
    use crate::physics::shifting::Shifting;

    /// Lattice rows below the plate, and of the plate.
    const BELOW: usize = 6;
    const PLATE: usize = 1;

    /// Returns fluid above and below a plate across the second axis. The plate is one-sided if
    /// `is_thin`; else all below its upper surface is a thick wall.
    fn divided<const D: usize>(law: PressureLaw, is_thin: bool) -> Sample<f64, D> {
        let mut pair = settings(Kernel::WendlandC2, D, 1.5);
        pair.pressure = law;
        pair.viscosity = 1e-3;
        pair.shifting = Shifting::NONE;
        let mut sample = Sample::<f64, D>::lattice(pair, [13; D], false);
        let particles = &mut sample.particles;
        particles.evolves_pressure = law != PressureLaw::Tait;
        particles.drifts = particles.evolves_pressure;
        if particles.drifts {
            particles.previous_pressure.resize(particles.id.len(), 0.0);
            particles.drift.iter_mut().for_each(|column| column.resize(particles.id.len(), 0.0));
        }
        if is_thin {
            particles.wall_thickness.resize(particles.id.len(), 0.0);
        }
        let top = (BELOW + PLATE) as f64 * SPACING;
        for row in 0..particles.len() {
            let height = particles.position[1][row] + 0.3;
            if height > top || (is_thin && height < top - SPACING) {
                continue;
            }
            particles.zone[row] = Zone::Wall;
            particles.wall_normal[1][row] = 1.0;
            particles.wall_distance[row] = top - height;
            if is_thin {
                particles.wall_thickness[row] = SPACING;
            }
        }
        sample
    }

    /// Sums acceleration, divergence and, where it evolves, the rate of the pressure of the fluid
    /// above the plate; each column in the order of the particle numbers.
    fn above<const D: usize>(sample: &mut Sample<f64, D>) -> Vec<Vec<f64>> {
        find_wall_distance(&sample.pair, &sample.grid, &mut sample.particles, &mut sample.sums);
        let carried = |_: &ParticleArrays<f64, D>, _| [0.0; D];
        let (pair, grid) = (&sample.pair, &sample.grid);
        extrapolate_wall_pressure(pair, grid, &mut sample.particles, &mut sample.sums, &carried);
        match sample.pair.pressure {
            PressureLaw::Tait => {
                sample.rates();
            }
            PressureLaw::Evolved(edac) => {
                edac::sum_rates(&sample.pair, &edac, &sample.grid, &mut sample.particles, &mut sample.sums);
            }
        }
        let particles = &sample.particles;
        let is_above = |row: &usize| particles.position[1][*row] + 0.3 > (BELOW + PLATE) as f64 * SPACING;
        let mut rows: Vec<usize> = (0..particles.len()).filter(is_above).collect();
        rows.sort_by_key(|&row| particles.id[row]);
        particles.acceleration.iter().map(|column| rows.iter().map(|&row| column[row]).collect()).collect()
    }

    fn nothing_crosses<const D: usize>(law: PressureLaw) {
        let mut sample = divided::<D>(law, true);
        for row in 0..sample.particles.len() {
            let id = sample.particles.id[row];
            if sample.particles.zone[row] == Zone::Fluid {
                sample.particles.velocity[0][row] = 0.1 + 0.05 * noise(id);
                sample.particles.pressure[row] = 50.0 * noise(id + 7);
            }
        }
        let before = above(&mut sample);
        assert!(before[0].iter().any(|acceleration| *acceleration != 0.0));
        for row in 0..sample.particles.len() {
            if sample.particles.position[1][row] + 0.3 < BELOW as f64 * SPACING {
                sample.particles.velocity[0][row] *= -7.0;
                sample.particles.velocity[1][row] = 0.4;
                sample.particles.pressure[row] += 900.0;
            }
        }
        assert_eq!(above(&mut sample), before, "{law:?} in {D}D");
    }

    #[test]
    fn neither_pressure_nor_friction_crosses_a_thin_wall() {
        for law in [PressureLaw::Tait, PressureLaw::Evolved(Edac::default())] {
            nothing_crosses::<2>(law);
            nothing_crosses::<3>(law);
        }
    }

    #[test]
    fn thin_wall_is_to_its_fluid_as_a_thick_one() {
        for law in [PressureLaw::Tait, PressureLaw::Evolved(Edac::default())] {
            let [thin, thick] = [true, false].map(|is_thin| {
                let mut sample = divided::<2>(law, is_thin);
                for row in 0..sample.particles.len() {
                    sample.particles.pressure[row] = 100.0;
                    sample.particles.density[row] = WATER.reference_density;
                    if sample.particles.zone[row] == Zone::Fluid {
                        sample.particles.velocity[0][row] = (sample.particles.position[1][row] + 0.3).powi(2);
                    }
                }
                above(&mut sample)
            });
            assert_close(&thin, &thick, 1e-3, &format!("{law:?}"));
        }
    }

    #[test]
    fn particles_beyond_the_edge_have_no_side() {
        let mut sample = divided::<2>(PressureLaw::Tait, true);
        let half = 6.0 * SPACING;
        for row in 0..sample.particles.len() {
            if sample.particles.position[0][row] + 0.3 > half {
                sample.particles.zone[row] = Zone::Fluid;
                sample.particles.wall_thickness[row] = 0.0;
            }
        }
        sample.sums.forget_order();
        above(&mut sample);
        let sides = sample.sums.sides.read(FusedInputsReader);
        for row in 0..sample.particles.len() {
            let (x, y) = (sample.particles.position[0][row] + 0.3, sample.particles.position[1][row] + 0.3);
            let height = y - (BELOW as f64 + 0.5) * SPACING;
            if sample.particles.zone[row] != Zone::Fluid || height.abs() > 1.6 * SPACING {
                continue;
            }
            let facing = sides.facing[1][row];
            if x < half {
                let distance = height.abs() - 0.5 * SPACING;
                let expected = height.signum() * (distance + SPACING);
                assert!((facing - expected).abs() < 1e-12, "{facing} at ({x}, {y}), not {expected}");
                assert!((sample.particles.wall_distance[row] - distance).abs() < 1e-12);
            } else if x > half + SPACING {
                assert_eq!(facing, 0.0, "at ({x}, {y})");
            }
        }
    }
}
