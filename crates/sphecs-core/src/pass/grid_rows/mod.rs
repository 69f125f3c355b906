//! Fields of the fluid at the nodes of a grid: velocity and its curl by a quadratic fit, pressure,
//! density and tag by a linear one.
//!
//! ```text
//! minimise Σ_b V_b W_b (f_b − Σ_i c_i φ_i((x_b − x)/h))²,   f(x) = c_0,   ∂f/∂x_j = c_j/h
//! fluid fraction  α = Σ_flow V_b W_b / (1 − Σ_walls V_b W_b),   at most 1
//! ```
//!
//! These are the fits of [`sampling`](super::sampling) (Liu & Liu 2006), for many points in
//! straight rows. A lane is a node instead of a neighbour: the neighbours of a group of nodes are
//! visited once for all of them, and every lane solves its own equations. This is five times as
//! fast as node by node. Values are fitted relative to those of one particle, so that a constant is
//! exact.
//!
//! Where the quadratic fit would amplify noise, the fit is linear; where the neighbours do not span
//! all directions, it is the Shepard mean, without a curl.

mod near;
mod node_sums;
mod shared_rows;
#[cfg(test)]
mod tests;

use std::marker::PhantomData;

use glam::DVec3;
use rayon::iter::{
    IndexedParallelIterator, IntoParallelRefIterator, IntoParallelRefMutIterator, ParallelIterator,
};

use near::{Gathered, Group};
use node_sums::{NodeSides, Sums, solved};

use super::neighbours::Neighbours;
use super::settings::PairSettings;
use super::wall_sides::{PointSide, SideColumns};
use crate::math::grid::CellGrid;
use crate::math::kernel::{KernelShape, WithShape};
use crate::math::lanes::{Lanes, MOST_LANES, Vectorised};
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;

/// Index of the pressure among the fields; the velocity is before it.
const PRESSURE: usize = 3;

/// Fields that are fitted: velocity, pressure, density, tag.
const FIELDS: usize = 6;

/// Nodes of a grid on a straight line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct NodeRow {
    /// First node, m.
    pub start: DVec3,
    /// Vector from a node to the next, m.
    pub step: DVec3,
    /// False for the nodes that are left out, such as those inside walls.
    pub wanted: Vec<bool>,
}

/// Fields at a node; NaN where no fluid is in the support, or the node was left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NodeFields {
    /// Velocity, m/s.
    pub velocity: [f64; 3],
    /// Curl of the velocity, 1/s; only z in 2D.
    pub vorticity: [f64; 3],
    /// Pressure, Pa.
    pub pressure: f64,
    /// Density, kg/m³.
    pub density: f64,
    /// Passive scalar; 0 without a column of it.
    pub tag: f64,
    /// Fraction of the space between the walls that the flow fills, 0 to 1.
    pub fraction: f64,
}

impl NodeFields {
    /// Fields of a node without fluid.
    pub const ABSENT: Self = Self {
        velocity: [f64::NAN; 3],
        vorticity: [f64::NAN; 3],
        pressure: f64::NAN,
        density: f64::NAN,
        tag: f64::NAN,
        fraction: 0.0,
    };
}

/// Takes the fields of one row of nodes.
pub trait RowSink: Send {
    /// Takes the fields of all nodes of the row, in their order.
    fn take(&mut self, fields: &[NodeFields]);
}

/// Samples the fields of sorted particles in rows of nodes.
#[derive(Clone, Copy, Debug)]
pub struct RowSampler<'a, R: Real, const D: usize> {
    /// Grid that the particles were sorted with.
    pub grid: &'a CellGrid<D>,
    /// The sorted particles.
    pub particles: &'a ParticleArrays<R, D>,
    /// Settings of the scene.
    pub pair: &'a PairSettings,
    /// Passive scalar of each row of the particles; empty for none.
    pub tags: &'a [f32],
    /// Sides of the particles near thin walls: those on the other side of a node do not count.
    pub sides: Option<&'a SideColumns<R, D>>,
}

impl<R: Real, const D: usize> RowSampler<'_, R, D> {
    /// Samples all rows and passes the fields of each to `take` with the element of `sinks` that
    /// belongs to it.
    ///
    /// The fields are bitwise independent of the other rows and of the number of threads. All ranks
    /// call it together with the same rows; only rank 0 needs sinks.
    ///
    /// # Panics
    /// If there are not as many sinks as rows.
    pub fn sample<S: Send>(
        &self,
        rows: &[NodeRow],
        sinks: &mut [S],
        take: impl Fn(&mut S, &[NodeFields]) + Sync,
    ) {
        let ranks = &self.pair.ranks;
        assert!(ranks.rank() > 0 || rows.len() == sinks.len(), "one sink for each row");
        if ranks.size() > 1 {
            self.sample_shared(rows, sinks, take);
        } else {
            self.sample_all(rows, &self.reference(), sinks, take);
        }
    }

    fn sample_all<S: Send>(
        &self,
        rows: &[NodeRow],
        reference: &[f64; FIELDS],
        sinks: &mut [S],
        take: impl Fn(&mut S, &[NodeFields]) + Sync,
    ) {
        let buffers = || Buffers::new(*reference);
        rows.par_iter().zip(sinks.par_iter_mut()).for_each_init(buffers, |buffers, (row, sink)| {
            self.sample_row(row, buffers);
            take(sink, &buffers.fields);
        });
    }

    fn sample_row(&self, row: &NodeRow, buffers: &mut Buffers<D>) {
        buffers.fields.clear();
        buffers.fields.resize(row.wanted.len(), NodeFields::ABSENT);
        self.pair.discretisation.kernel.with_shape(OnRow { sampler: self, row, buffers });
    }
}

/// Buffers of a thread.
struct Buffers<const D: usize> {
    gathered: Gathered<D>,
    /// Fields of one group.
    nodes: [NodeFields; MOST_LANES],
    /// Fields of a row.
    fields: Vec<NodeFields>,
}

impl<const D: usize> Buffers<D> {
    fn new(reference: [f64; FIELDS]) -> Self {
        let gathered = Gathered { near: Vec::new(), reference };
        Self { gathered, nodes: [NodeFields::ABSENT; MOST_LANES], fields: Vec::new() }
    }
}

/// Samples a row, before the kernel is known.
struct OnRow<'a, R: Real, const D: usize> {
    sampler: &'a RowSampler<'a, R, D>,
    row: &'a NodeRow,
    buffers: &'a mut Buffers<D>,
}

impl<R: Real, const D: usize> WithShape for OnRow<'_, R, D> {
    type Output = ();

    fn run<K: KernelShape>(self) {
        let Self { sampler, row, buffers } = self;
        let shape = PhantomData::<K>;
        f64::dispatch(sampler.pair.lanes, VectorRow { sampler, row, buffers, shape });
    }
}

/// Samples a row in groups of as many nodes as there are lanes.
struct VectorRow<'a, K, R: Real, const D: usize> {
    sampler: &'a RowSampler<'a, R, D>,
    row: &'a NodeRow,
    buffers: &'a mut Buffers<D>,
    shape: PhantomData<K>,
}

impl<K: KernelShape, R: Real, const D: usize> Vectorised<f64> for VectorRow<'_, K, R, D> {
    type Output = ();
    type Module = Self;

    #[inline(always)]
    fn run<L: Lanes<Real = f64>>(self) {
        let Self { sampler, row, buffers, .. } = self;
        let count = row.wanted.len();
        let mut from = 0;
        while from < count {
            let to = count.min(from + L::COUNT);
            if row.wanted[from..to].contains(&true) {
                let start = row.start + from as f64 * row.step;
                let length = (to - from - 1) as f64 * row.step.length();
                let group = Group { start, step: row.step, length };
                match D {
                    2 => sampler.group::<K, L, 6>(&group, &mut buffers.gathered, &mut buffers.nodes),
                    _ => sampler.group::<K, L, 10>(&group, &mut buffers.gathered, &mut buffers.nodes),
                }
                for node in from..to {
                    if row.wanted[node] {
                        buffers.fields[node] = buffers.nodes[node - from];
                    }
                }
            }
            from = to;
        }
    }
}

impl<R: Real, const D: usize> RowSampler<'_, R, D> {
    /// Returns the sides of the nodes of a group; None where no wall is thin.
    #[inline(always)]
    fn sides_of<L: Lanes<Real = f64>>(&self, group: &Group) -> Option<NodeSides<L, D>> {
        let sides = self.sides.filter(|sides| !sides.facing[0].is_empty())?;
        let neighbours = Neighbours::new(self.grid, self.particles);
        let (mut normals, mut fronts) = ([[0.0; MOST_LANES]; D], [f64::INFINITY; MOST_LANES]);
        for lane in 0..L::COUNT {
            let node = group.start + lane as f64 * group.step;
            let side = PointSide::at(&neighbours, self.pair, sides, std::array::from_fn(|d| node[d]));
            if let Some(side) = side {
                fronts[lane] = side.front / self.pair.discretisation.smoothing_length;
                for d in 0..D {
                    normals[d][lane] = side.normal[d];
                }
            }
        }
        let mut normal = [L::constant(0.0); D];
        for d in 0..D {
            normal[d] = L::first_of(&normals[d]);
        }
        Some(NodeSides { normal, front: L::first_of(&fronts) })
    }

    #[inline(always)]
    fn group<K: KernelShape, L: Lanes<Real = f64>, const N: usize>(
        &self,
        group: &Group,
        gathered: &mut Gathered<D>,
        nodes: &mut [NodeFields; MOST_LANES],
    ) {
        self.gather(group, gathered);
        let discretisation = &self.pair.discretisation;
        let inverse_h = 1.0 / discretisation.smoothing_length;
        let mut step = [0.0; D];
        for d in 0..D {
            step[d] = group.step[d] * inverse_h;
        }
        let sides = self.sides_of::<L>(group);
        let sums = Sums::<L, N>::of::<K, D>(&gathered.near, step, sides.as_ref());
        let norm = L::constant(discretisation.kernel_scale());
        let open = (L::constant(1.0) - sums.solid * norm).max(L::constant(LEAST_OPEN));
        let fraction = (sums.flow * norm / open).min(L::constant(1.0)).to_array();
        let fits = solved::<K, L, D, N>(&sums, discretisation.cell_volume());
        let mut values = [[0.0; MOST_LANES]; FIELDS];
        let mut slopes = [[[0.0; MOST_LANES]; D]; D];
        for field in 0..FIELDS {
            values[field] = fits.values[field].to_array();
        }
        for i in 0..D {
            for j in 0..D {
                slopes[i][j] = (fits.slopes[i][j] * L::constant(inverse_h)).to_array();
            }
        }
        let totals = sums.moments[0][0].to_array();
        *nodes = [NodeFields::ABSENT; MOST_LANES];
        for lane in 0..L::COUNT {
            let at = Lane { lane, values: &values, slopes: &slopes };
            nodes[lane].fraction = fraction[lane];
            if totals[lane] > 0.0 {
                at.write(&gathered.reference, &mut nodes[lane]);
            }
        }
    }
}

/// Least part of the space around a node outside walls: in a wall the sum of its particles may
/// exceed 1.
const LEAST_OPEN: f64 = 1e-3;

/// Results of one lane.
struct Lane<'a, const D: usize> {
    lane: usize,
    values: &'a [[f64; MOST_LANES]; FIELDS],
    slopes: &'a [[[f64; MOST_LANES]; D]; D],
}

impl<const D: usize> Lane<'_, D> {
    /// Writes the fields of a node, given those of the reference particle.
    fn write(&self, reference: &[f64; FIELDS], node: &mut NodeFields) {
        let value = |field: usize| reference[field] + self.values[field][self.lane];
        let slope = |i: usize, j: usize| if i < D && j < D { self.slopes[i][j][self.lane] } else { 0.0 };
        node.velocity = [0, 1, 2].map(value);
        node.vorticity = [(2, 1), (0, 2), (1, 0)].map(|(i, j)| slope(i, j) - slope(j, i));
        [node.pressure, node.density, node.tag] = [0, 1, 2].map(|scalar| value(PRESSURE + scalar));
    }
}
