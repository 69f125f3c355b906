//! Particles near a group of nodes, collected for vectorised sums over them.

use glam::DVec3;

use super::{FIELDS, PRESSURE, RowSampler};
use crate::math::real::Real;
use crate::particles::zone::Zone;

/// Nodes of one vector.
#[derive(Clone, Copy, Debug)]
pub(super) struct Group {
    /// First node, m.
    pub(super) start: DVec3,
    /// Vector from a node to the next, m.
    pub(super) step: DVec3,
    /// Distance of the last node from the first, m.
    pub(super) length: f64,
}

/// Particle near a group of nodes.
#[derive(Clone, Copy, Debug)]
pub(super) struct Near<const D: usize> {
    /// (x_b − x)/h from the first node.
    pub(super) offset: [f64; D],
    /// Volume of a particle of the flow, m³ (m² in 2D); 0 for walls.
    pub(super) flow: f64,
    /// Volume of a wall particle, m³ (m² in 2D); 0 for others.
    pub(super) solid: f64,
    /// True for fluid, whose fields are fitted.
    pub(super) is_fluid: bool,
    /// Facing of a particle of the flow near a thin wall, m; 0 for others.
    pub(super) facing: [f64; D],
    /// Fields relative to those of the first fluid particle.
    pub(super) values: [f64; FIELDS],
}

/// Particles near a group of nodes.
#[derive(Clone, Debug)]
pub(super) struct Gathered<const D: usize> {
    /// The particles.
    pub(super) near: Vec<Near<D>>,
    /// Fields of the first fluid particle.
    pub(super) reference: Option<[f64; FIELDS]>,
}

impl<R: Real, const D: usize> RowSampler<'_, R, D> {
    /// Collects the particles within the support of the line of nodes. It is not vectorised, so
    /// that the closures need not be inlined into code for the instruction set.
    pub(super) fn gather(&self, group: &Group, gathered: &mut Gathered<D>) {
        gathered.near.clear();
        gathered.reference = None;
        let support = self.grid.support();
        let inverse_h = 1.0 / self.pair.discretisation.smoothing_length;
        let direction = group.step.normalize();
        let end = group.start + group.length * direction;
        let (low, high) = (group.start.min(end), group.start.max(end));
        let corner = |at: DVec3| std::array::from_fn(|d| at[d]);
        self.grid.for_each_run_near(corner(low), corner(high), |rows, shift| {
            for row in rows {
                let (mut square, mut along) = (0.0, 0.0);
                let mut relative = [0.0; D];
                for d in 0..D {
                    relative[d] = self.particles.position[d][row] + shift[d] - group.start[d];
                    square += relative[d] * relative[d];
                    along += relative[d] * direction[d];
                }
                let is_across = square - along * along < support * support;
                if is_across && along > -support && along < group.length + support {
                    self.add(row, relative, inverse_h, gathered);
                }
            }
        });
    }

    #[inline]
    fn add(&self, row: usize, relative: [f64; D], inverse_h: f64, gathered: &mut Gathered<D>) {
        let (particles, discretisation) = (self.particles, &self.pair.discretisation);
        let (zone, density) = (particles.zone[row], particles.density[row].to_f64());
        let mut offset = [0.0; D];
        for d in 0..D {
            offset[d] = relative[d] * inverse_h;
        }
        let mut near =
            Near { offset, flow: 0.0, solid: 0.0, is_fluid: false, facing: [0.0; D], values: [0.0; FIELDS] };
        if zone == Zone::Wall {
            near.solid = discretisation.cell_volume();
        } else {
            near.flow = discretisation.mass / density;
            if let Some(sides) = self.sides {
                for d in 0..D {
                    near.facing[d] = sides.facing[d].get(row).map_or(0.0, |facing| facing.to_f64());
                }
            }
        }
        if zone == Zone::Fluid {
            let mut values = [0.0; FIELDS];
            for d in 0..D {
                values[d] = particles.velocity[d][row].to_f64();
            }
            values[PRESSURE] = particles.pressure[row].to_f64();
            values[PRESSURE + 1] = density;
            values[PRESSURE + 2] = self.tags.get(row).map_or(0.0, |tag| f64::from(*tag));
            let reference = gathered.reference.get_or_insert(values);
            near.is_fluid = true;
            for field in 0..FIELDS {
                near.values[field] = values[field] - reference[field];
            }
        }
        gathered.near.push(near);
    }
}
