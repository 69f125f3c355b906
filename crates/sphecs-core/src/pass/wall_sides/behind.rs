//! Neighbours behind a thin wall, in the pair loops.

use super::SideColumns;
use crate::math::lanes::{Lanes, dot};
use crate::math::real::Real;
use crate::pass::pack::{Entry, Vector};

/// Side of a particle, in every lane.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct OwnSide<L, const D: usize> {
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
    pub(in crate::pass) fn new(
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
    pub(in crate::pass) fn relative_velocity(&self, behind: &Behind<L>, own: [L; D], v: [L; D]) -> [L; D] {
        let mut seen = v;
        for d in 0..D {
            seen[d] = L::select(behind.mask(), own[d] - self.velocity[d], v[d]);
        }
        seen
    }
}

/// Neighbours behind a thin wall.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct Behind<L> {
    /// Depth behind the surface that the particle faces, m; 0 for other neighbours.
    pub depth: L,
}

impl<L: Lanes> Behind<L> {
    /// Returns the neighbours behind the wall that a particle faces; x is x_ab/h.
    #[inline(always)]
    pub(in crate::pass) fn new<const D: usize>(
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
    pub(in crate::pass) fn of_wall<const D: usize>(
        &self,
        facing: Vector,
        neighbours: Entry<'_, L>,
        wall: L,
    ) -> L {
        let (zero, one) = (L::constant(0.0), L::constant(1.0));
        let f: [L; D] = neighbours.vector_at(facing);
        let flows = L::select(zero.less(wall.abs()), zero, dot(f, f));
        L::select(zero.less(flows), zero, one)
    }

    /// Returns the lanes of neighbours behind the wall.
    #[inline(always)]
    pub(in crate::pass) fn mask(&self) -> L::Mask {
        L::constant(0.0).less(self.depth)
    }
}
