//! Side of a point that is sampled.

use super::SideColumns;
use super::disc::{AtDisc, radius};
use crate::math::real::Real;
use crate::particles::zone::Zone;
use crate::pass::neighbours::Neighbours;
use crate::pass::settings::PairSettings;

/// Side of a point.
#[derive(Clone, Copy, Debug)]
pub(in crate::pass) struct PointSide<'a, R, const D: usize> {
    sides: &'a SideColumns<R, D>,
    /// Normal of the surface that the point faces.
    pub normal: [f64; D],
    /// Distance to that surface, m.
    pub front: f64,
}

impl<'a, R: Real, const D: usize> PointSide<'a, R, D> {
    /// Returns the side of a point (m); None where the nearest wall is thick, and beyond an edge.
    pub(in crate::pass) fn at(
        neighbours: &Neighbours<'_, R, D>,
        pair: &PairSettings,
        sides: &'a SideColumns<R, D>,
        point: [f64; D],
    ) -> Option<Self> {
        let particles = neighbours.particles;
        if particles.wall_thickness.is_empty() {
            return None;
        }
        let disc = radius(pair.discretisation.spacing);
        let (mut nearest, mut side) = (f64::INFINITY, None);
        neighbours.for_each(point, |row, x_ab, _| {
            if particles.zone[row] != Zone::Wall {
                return;
            }
            let normal: [f64; D] = std::array::from_fn(|d| particles.wall_normal[d][row].to_f64());
            let (depth, thickness) =
                (particles.wall_distance[row].to_f64(), particles.wall_thickness[row].to_f64());
            let AtDisc { front: along, beyond } = AtDisc::of_point(x_ab, depth, normal, disc);
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

    /// Returns true if a particle of the flow is behind the wall that the point faces.
    ///
    /// x is the point less the position of the particle, m.
    pub(in crate::pass) fn hides(&self, row: usize, x: [f64; D]) -> bool {
        let along =
            |d: usize| self.sides.facing[d].get(row).map_or(0.0, |facing| facing.to_f64()) * self.normal[d];
        let depth: f64 = -(0..D).map(along).sum::<f64>();
        let into: f64 = x.iter().zip(self.normal).map(|(x, n)| x * n).sum();
        depth > 0.0 && into > self.front
    }
}
