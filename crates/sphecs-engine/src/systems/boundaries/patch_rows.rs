//! Rows of the sorted arrays that belong to each inlet and outlet.

use std::ops::Range;

use bevy_ecs::resource::Resource;
use glam::DVec3;

use super::patch_cells::PatchCells;
use sphecs_core::boundary::outlet::method::Needs;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::with_lists;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;

/// Layers of fluid upstream of an outlet over which the flow next to it is averaged.
pub(super) const ADJACENT_LAYERS: f64 = 3.0;

/// Rows by inlet and outlet, valid until the next sort.
#[derive(Resource, Clone, Debug, Default)]
pub struct PatchRows {
    /// Inflow rows of each inlet, then of each emitter.
    pub inflow: Vec<Vec<u32>>,
    /// Outflow rows of each outlet.
    pub outflow: Vec<Vec<u32>>,
    /// Fluid rows in the last three layers before each outlet.
    pub before_outlet: Vec<Vec<u32>>,
    /// Fluid rows upstream of each outlet that its condition uses; empty if it uses none.
    pub upstream: Vec<Vec<u32>>,
    /// Rows of the cells near inlets and outlets, of which this rank has the particles. They
    /// contain the rows above and all rows that cross a plane.
    pub near: PatchCells,
    /// Lists of each part of the rows, kept so that collecting allocates nothing.
    parts: Vec<PatchRows>,
}

impl PatchRows {
    /// Returns the positions of the inflow particles of an inlet, m.
    pub fn inflow_positions<R: PairReal<D>, const D: usize>(
        &self,
        arrays: &ParticleArrays<R, D>,
        inlet: u16,
    ) -> impl Iterator<Item = DVec3> {
        let rows = self.inflow[usize::from(inlet)].iter().map(|&row| row as usize);
        rows.filter(|&row| arrays.zone[row] == Zone::Inflow).map(|row| arrays.position_of(row))
    }

    /// Empties the lists of every patch of a scene.
    fn clear(&mut self, scene: &Scene) {
        self.inflow.resize_with(scene.source_count(), Vec::new);
        self.outflow.resize_with(scene.outlets.len(), Vec::new);
        self.before_outlet.resize_with(scene.outlets.len(), Vec::new);
        self.upstream.resize_with(scene.outlets.len(), Vec::new);
        self.lists().for_each(Vec::clear);
    }

    fn lists(&mut self) -> impl Iterator<Item = &mut Vec<u32>> {
        let outlets = self.outflow.iter_mut().chain(&mut self.before_outlet).chain(&mut self.upstream);
        self.inflow.iter_mut().chain(outlets)
    }

    /// Collects the rows, in their order, of arrays that are sorted by the grid, from the cells
    /// `near` openings. `needs` are the requirements of the outlets' conditions.
    pub fn collect<R: PairReal<D>, const D: usize>(
        &mut self,
        scene: &Scene,
        needs: &[Needs],
        (grid, near): (&CellGrid<D>, &[Range<usize>]),
        arrays: &ParticleArrays<R, D>,
    ) {
        self.clear(scene);
        if scene.source_count() == 0 && scene.outlets.is_empty() {
            return;
        }
        self.near.find(near, grid);
        let (near, mut parts) = (&self.near, std::mem::take(&mut self.parts));
        // Parts are joined in their order, so that the lists do not depend on the number of
        // threads.
        let found = with_lists(near.count(), &mut parts, &|among, part: &mut Self| {
            part.clear(scene);
            for row in near.rows(among) {
                part.add(scene, needs, arrays, row);
            }
        });
        for part in found {
            for (all, of_part) in self.lists().zip(part.lists()) {
                all.extend_from_slice(of_part);
            }
        }
        self.parts = parts;
    }

    /// Adds a row to the lists that it belongs to.
    fn add<R: PairReal<D>, const D: usize>(
        &mut self,
        scene: &Scene,
        needs: &[Needs],
        arrays: &ParticleArrays<R, D>,
        row: usize,
    ) {
        match arrays.zone[row] {
            Zone::Inflow => self.inflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Outflow => self.outflow[usize::from(arrays.patch[row])].push(row as u32),
            Zone::Fluid => {
                let adjacent = ADJACENT_LAYERS * scene.spacing;
                let lists = self.before_outlet.iter_mut().zip(&mut self.upstream);
                for ((outlet, needs), (before, upstream)) in scene.outlets.iter().zip(needs).zip(lists) {
                    let point = arrays.position_of(row);
                    let along = outlet.patch.along(point);
                    let near = |reach: f64, margin: f64| {
                        along > -reach && along < scene.spacing && outlet.patch.covers(point, margin)
                    };
                    if near(adjacent, scene.spacing) {
                        before.push(row as u32);
                    }
                    if let Some(layers) = needs.upstream_layers {
                        let support = scene.discretisation.support;
                        if near(support + layers * scene.spacing, support) {
                            upstream.push(row as u32);
                        }
                    }
                }
            }
            Zone::Wall | Zone::Reservoir => {}
        }
    }
}
