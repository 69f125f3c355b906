//! Which rows of the sorted arrays belong to which patch.

use bevy_ecs::resource::Resource;
use glam::DVec3;

use super::near::{LAYERS_BEYOND_REACH, NearRows};
use sphecs_core::math::grid::CellGrid;
use sphecs_core::math::real::Real;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::with_lists;
use sphecs_core::physics::outlet::OutletCondition;
use sphecs_scene::model::Scene;

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
    /// Fluid rows that a hybrid outlet takes means of; of other outlets none.
    pub in_reach: Vec<Vec<u32>>,
    /// The rows among which all of these are, and all that cross a plane.
    pub near: NearRows,
    /// The same of each part of the rows: kept, so that collecting allocates nothing.
    parts: Vec<PatchRows>,
}

impl PatchRows {
    /// Where the inflow particles of an inlet stand, m.
    pub fn inflow_places<R: Real, const D: usize>(
        &self,
        arrays: &ParticleArrays<R, D>,
        inlet: u16,
    ) -> impl Iterator<Item = DVec3> {
        let rows = self.inflow[usize::from(inlet)].iter().map(|&row| row as usize);
        rows.filter(|&row| arrays.zone[row] == Zone::Inflow).map(|row| arrays.position_of(row))
    }

    /// Empty lists for every patch of a scene.
    fn clear(&mut self, scene: &Scene) {
        self.inflow.resize_with(scene.inlets.len(), Vec::new);
        self.outflow.resize_with(scene.outlets.len(), Vec::new);
        self.before_outlet.resize_with(scene.outlets.len(), Vec::new);
        self.in_reach.resize_with(scene.outlets.len(), Vec::new);
        self.lists().for_each(Vec::clear);
    }

    fn lists(&mut self) -> impl Iterator<Item = &mut Vec<u32>> {
        let outlets = self.outflow.iter_mut().chain(&mut self.before_outlet).chain(&mut self.in_reach);
        self.inflow.iter_mut().chain(outlets)
    }

    /// Collects the rows, in their order, of arrays that are sorted by the grid.
    pub fn collect<R: Real, const D: usize>(
        &mut self,
        scene: &Scene,
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
    ) {
        self.clear(scene);
        if scene.inlets.is_empty() && scene.outlets.is_empty() {
            return;
        }
        self.near.find(scene, grid);
        let (near, mut parts) = (&self.near, std::mem::take(&mut self.parts));
        // PluginContext are joined in their order, so the lists do not depend on who collected them.
        let found = with_lists(near.count(), &mut parts, &|among, part: &mut Self| {
            part.clear(scene);
            for row in near.rows(among) {
                part.sort_in(scene, arrays, row);
            }
        });
        for part in found {
            for (all, of_part) in self.lists().zip(part.lists()) {
                all.extend_from_slice(of_part);
            }
        }
        self.parts = parts;
    }

    /// Puts a row into the lists that it belongs to.
    fn sort_in<R: Real, const D: usize>(&mut self, scene: &Scene, arrays: &ParticleArrays<R, D>, row: usize) {
        match arrays.zone[row] {
            Zone::Inflow => self.inflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Outflow => self.outflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Fluid => {
                let adjacent = ADJACENT_LAYERS * scene.spacing;
                let lists = self.before_outlet.iter_mut().zip(&mut self.in_reach);
                for (outlet, (before, in_reach)) in scene.outlets.iter().zip(lists) {
                    let point = arrays.position_of(row);
                    let along = outlet.patch.along(point);
                    let near = |reach: f64, margin: f64| {
                        along > -reach && along < scene.spacing && outlet.patch.covers(point, margin)
                    };
                    if near(adjacent, scene.spacing) {
                        before.push(row as u32);
                    }
                    if matches!(outlet.condition, OutletCondition::Hybrid { .. }) {
                        let support = scene.scheme.support(scene.spacing);
                        if near(support + LAYERS_BEYOND_REACH * scene.spacing, support) {
                            in_reach.push(row as u32);
                        }
                    }
                }
            }
            Zone::Wall | Zone::Reservoir => {}
        }
    }
}
