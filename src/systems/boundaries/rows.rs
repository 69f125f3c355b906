//! Which rows of the sorted arrays belong to which patch.

use std::ops::Range;

use bevy_ecs::resource::Resource;

use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;
use crate::pass::blocks::join_parts;
use crate::scene::model::Scene;

/// Layers of fluid next to an outlet whose mean stands for the flow there.
const ADJACENT_LAYERS: f64 = 3.0;

/// Rows by patch, valid from one sort to the next.
#[derive(Resource, Clone, Debug, Default)]
pub struct PatchRows {
    /// Inflow rows of each inlet.
    pub inflow: Vec<Vec<u32>>,
    /// Outflow rows of each outlet.
    pub outflow: Vec<Vec<u32>>,
    /// Fluid rows in the last three layers before each outlet.
    pub before_outlet: Vec<Vec<u32>>,
}

impl PatchRows {
    fn empty(scene: &Scene) -> Self {
        Self {
            inflow: vec![Vec::new(); scene.inlets.len()],
            outflow: vec![Vec::new(); scene.outlets.len()],
            before_outlet: vec![Vec::new(); scene.outlets.len()],
        }
    }

    /// Collects the rows, in their order.
    pub fn collect<R: Real, const D: usize>(&mut self, scene: &Scene, arrays: &ParticleArrays<R, D>) {
        // Parts are joined in their order, so the lists do not depend on who collected them.
        let rows = if scene.inlets.is_empty() && scene.outlets.is_empty() { 0 } else { arrays.len() };
        let find = |rows: Range<usize>| {
            let mut found = Self::empty(scene);
            for row in rows {
                found.sort_in(scene, arrays, row);
            }
            found
        };
        *self = join_parts(0..rows, &find, &Self::followed_by);
    }

    /// Puts a row into the lists that it belongs to.
    fn sort_in<R: Real, const D: usize>(&mut self, scene: &Scene, arrays: &ParticleArrays<R, D>, row: usize) {
        match arrays.zone[row] {
            Zone::Inflow => self.inflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Outflow => self.outflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Fluid => {
                let reach = ADJACENT_LAYERS * scene.spacing;
                for (outlet, rows) in scene.outlets.iter().zip(&mut self.before_outlet) {
                    let point = arrays.position_of(row);
                    let along = outlet.patch.along(point);
                    if along > -reach && along < scene.spacing && outlet.patch.covers(point, scene.spacing) {
                        rows.push(row as u32);
                    }
                }
            }
            Zone::Wall | Zone::Reservoir => {}
        }
    }

    fn followed_by(mut self, next: Self) -> Self {
        let lists = self.inflow.iter_mut().chain(&mut self.outflow).chain(&mut self.before_outlet);
        for (rows, more) in lists.zip(next.inflow.into_iter().chain(next.outflow).chain(next.before_outlet)) {
            rows.extend(more);
        }
        self
    }
}
