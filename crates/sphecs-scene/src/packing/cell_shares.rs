//! Selection of lattice cells that together have the volume of the fluid.
//!
//! A cell cut by a wall or by the plane of an opening counts with the share of its volume that is
//! fluid. The share is that of 4 points along each axis in 3D, 8 in 2D. The distance at a point
//! follows from those of the corners and of the centre.
//!
//! The cells are visited in their order, and a particle is placed whenever the volume so far
//! exceeds that of the particles by half of one. So every stretch of the surface has its mass to
//! within a particle, and all of the fluid to within half of one.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, ParallelIterator};
use rayon::slice::ParallelSliceMut;

/// Lattice of cells over a box.
pub(super) struct Cells<'a> {
    /// Number of axes.
    pub(super) dimensions: usize,
    /// Number of cells along each axis, 1 where there is none.
    pub(super) counts: [usize; 3],
    /// Edges of a cell along its axes, m; zero where there is none.
    pub(super) edges: [DVec3; 3],
    /// Centre of the cell with these indices, m.
    pub(super) centre: &'a (dyn Fn([usize; 3]) -> DVec3 + Sync),
    /// Signed distance behind the walls, m.
    pub(super) distance: &'a (dyn Fn(DVec3) -> f64 + Sync),
    /// True for a place in front of all openings.
    pub(super) is_in_front: &'a (dyn Fn(DVec3) -> bool + Sync),
}

impl Cells<'_> {
    /// Returns the centres of the selected cells, m, in their order.
    pub(super) fn selected(&self) -> Vec<DVec3> {
        let shares = self.shares();
        let mut carried = 0.0;
        let mut selected = Vec::new();
        for (index, share) in shares.into_iter().enumerate() {
            carried += f64::from(share);
            if carried >= 0.5 && share > 0.0 {
                carried -= 1.0;
                selected.push((self.centre)(self.cell(index)));
            }
        }
        selected
    }

    fn cell(&self, index: usize) -> [usize; 3] {
        [
            index / self.counts[2] / self.counts[1],
            index / self.counts[2] % self.counts[1],
            index % self.counts[2],
        ]
    }

    /// Returns the share of each cell that is fluid.
    fn shares(&self) -> Vec<f32> {
        let mut shares = vec![0.0; self.counts.iter().product()];
        let axis = self.dimensions - 1;
        let length = self.counts[axis].max(1);
        shares.par_chunks_mut(length).enumerate().for_each(|(row, shares)| {
            self.row(row * length, shares);
        });
        shares
    }

    /// Finds the shares of consecutive cells along the last axis. The distance changes by at most
    /// an edge from cell to cell, so that cells far from the surface need no evaluation.
    fn row(&self, first: usize, shares: &mut [f32]) {
        let edge = self.edges[self.dimensions - 1].length();
        let half_diagonal = 0.5 * self.edges.iter().map(|edge| edge.length_squared()).sum::<f64>().sqrt();
        let mut bound = f64::INFINITY;
        let mut at = 0;
        while at < shares.len() {
            let centre = (self.centre)(self.cell(first + at));
            bound += edge;
            if bound >= -half_diagonal {
                bound = (self.distance)(centre);
            }
            if bound >= half_diagonal {
                at = at.saturating_add((((bound - half_diagonal) / edge) as usize).max(1));
                bound = f64::INFINITY;
                continue;
            }
            shares[at] = self.share(centre, bound < -half_diagonal);
            at += 1;
        }
    }

    /// Returns the share of a cell; `is_inside` says that no wall cuts it.
    fn share(&self, centre: DVec3, is_inside: bool) -> f32 {
        let corners = 1 << self.dimensions;
        let corner = |number: usize| {
            let half = |axis: usize| if number >> axis & 1 == 1 { 0.5 } else { -0.5 };
            centre + (0..self.dimensions).map(|axis| self.edges[axis] * half(axis)).sum::<DVec3>()
        };
        // Openings are planes: a cell whose corners are on one side is not cut.
        let middle = |point: DVec3| centre + 0.99 * (point - centre);
        let in_front = (0..corners).filter(|number| (self.is_in_front)(middle(corner(*number)))).count();
        if in_front == 0 {
            return 0.0;
        }
        if is_inside && in_front == corners {
            return 1.0;
        }
        let mut distances = [-1.0; 8];
        if !is_inside {
            (0..corners).for_each(|number| distances[number] = (self.distance)(corner(number)));
        }
        // Of a curved surface: the distance at the centre less what the corners say.
        let of_corners = distances[..corners].iter().sum::<f64>() / corners as f64;
        let bulge = if is_inside { 0.0 } else { (self.distance)(centre) - of_corners };
        let along: usize = if self.dimensions == 2 { 8 } else { 4 };
        let total = along.pow(self.dimensions as u32);
        let is_fluid = |index: usize| {
            let part = |axis: usize| ((index / along.pow(axis as u32) % along) as f64 + 0.5) / along as f64;
            let parts: [f64; 3] = std::array::from_fn(part);
            let weight = |number: usize| -> f64 {
                let of = |axis: usize| if number >> axis & 1 == 1 { parts[axis] } else { 1.0 - parts[axis] };
                (0..self.dimensions).map(of).product()
            };
            let squares: f64 = parts[..self.dimensions].iter().map(|part| (part - 0.5).powi(2)).sum();
            let bulge = bulge * (1.0 - 4.0 * squares / self.dimensions as f64);
            let distance = (0..corners).map(|number| weight(number) * distances[number]).sum::<f64>() + bulge;
            let point = || {
                let of = |axis: usize| self.edges[axis] * (parts[axis] - 0.5);
                centre + (0..self.dimensions).map(of).sum::<DVec3>()
            };
            distance <= 0.0 && (in_front == corners || (self.is_in_front)(point()))
        };
        (0..total).filter(|index| is_fluid(*index)).count() as f32 / total as f32
    }
}
