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
    /// Fields relative to the reference.
    pub(super) values: [f64; FIELDS],
}

/// Particles near a group of nodes.
#[derive(Clone, Debug)]
pub(super) struct Gathered<const D: usize> {
    /// The particles.
    pub(super) near: Vec<Near<D>>,
    /// Fields of the [reference particle](RowSampler::reference).
    pub(super) reference: [f64; FIELDS],
}

/// Fields of a particle, and its cell; particles of lower cells are before it.
#[derive(Clone, Copy, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
struct InCell {
    cell: u64,
    fields: [f64; FIELDS],
}

impl<R: Real, const D: usize> RowSampler<'_, R, D> {
    /// Returns the fields of the first fluid particle, in the order of the cells, whose fields are
    /// finite; 0 without one. All nodes have one reference, whichever rank samples them.
    pub(super) fn reference(&self) -> [f64; FIELDS] {
        let ranks = &self.pair.ranks;
        let own = ranks.own_rows(self.grid).into_iter().flatten();
        let mut fluid = own.filter(|&row| self.particles.zone[row] == Zone::Fluid);
        let first = fluid.find(|&row| self.fields(row).iter().all(|field| field.is_finite()));
        let own = match first {
            Some(row) => {
                let cells = self.grid.starts().partition_point(|&start| start as usize <= row);
                InCell { cell: cells as u64, fields: self.fields(row) }
            }
            None => InCell { cell: u64::MAX, fields: [0.0; FIELDS] },
        };
        ranks.joined(own, |a, b| if b.cell < a.cell { b } else { a }).fields
    }

    /// Returns the fields of a particle.
    #[inline]
    fn fields(&self, row: usize) -> [f64; FIELDS] {
        let particles = self.particles;
        let mut fields = [0.0; FIELDS];
        for d in 0..D {
            fields[d] = particles.velocity[d][row].to_f64();
        }
        fields[PRESSURE] = particles.pressure[row].to_f64();
        fields[PRESSURE + 1] = particles.density[row].to_f64();
        fields[PRESSURE + 2] = self.tags.get(row).map_or(0.0, |tag| f64::from(*tag));
        fields
    }

    /// Collects the particles within the support of the line of nodes. It is not vectorised, so
    /// that the closures need not be inlined into code for the instruction set.
    pub(super) fn gather(&self, group: &Group, gathered: &mut Gathered<D>) {
        gathered.near.clear();
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
            let fields = self.fields(row);
            near.is_fluid = true;
            for field in 0..FIELDS {
                near.values[field] = fields[field] - gathered.reference[field];
            }
        }
        gathered.near.push(near);
    }
}
