//! Regions around the openings, of which a rank holds those that it touches.
//!
//! Inlets, emitters and outlets whose surroundings overlap are in one region. Its members do alike
//! what has to be done for these openings; the first of them, its leader, tells the other ranks the
//! few numbers that they need.

use std::ops::Range;

use bevy_ecs::resource::Resource;

use super::patch_cells::{cells_near_openings, cells_of_members};
use sphecs_core::boundary::outlet::method::Needs;
use sphecs_core::math::grid::CellGrid;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::ranks::Ranks;
use sphecs_core::pass::ranks::regions::Region;
use sphecs_scene::model::Scene;

/// Regions around the openings of a scene, with what this rank has to do with them.
#[derive(Resource, Clone, Debug, Default)]
pub struct OpeningRegions {
    /// Cells near openings, found once: neither grid nor openings move.
    near: Option<Vec<Range<usize>>>,
    /// Cells near openings in the regions of which this rank is a member.
    near_held: Vec<Range<usize>>,
    /// Regions, found once; None before that, and on one rank alone.
    regions: Option<Vec<Region>>,
    /// Region of each inlet, then of each emitter.
    of_source: Vec<usize>,
    /// Region of each outlet.
    of_outlet: Vec<usize>,
    /// Leader of each region; none before the first sort, and on one rank alone.
    leaders: Vec<usize>,
    /// True for regions of which this rank is a member; none as before.
    is_member: Vec<bool>,
    /// Changes of the domains that the members belong to.
    changes: u64,
}

impl OpeningRegions {
    /// Finds the cells near openings, unless they are known. `needs` are the requirements of the
    /// outlets' conditions.
    pub fn find<const D: usize>(&mut self, scene: &Scene, needs: &[Needs], grid: &CellGrid<D>) {
        self.near.get_or_insert_with(|| cells_near_openings(scene, needs, grid));
    }

    /// Returns the regions.
    pub fn regions<const D: usize>(
        &mut self,
        scene: &Scene,
        needs: &[Needs],
        grid: &CellGrid<D>,
    ) -> &[Region] {
        let Self { near, regions, of_source, of_outlet, .. } = self;
        regions.get_or_insert_with(|| {
            let near = near.get_or_insert_with(|| cells_near_openings(scene, needs, grid));
            let regions = Region::divide(grid, near, &cells_of_members(scene, needs, grid));
            // The centre of an opening is in the slab of cells along its plane.
            let at = |centre: glam::DVec3| {
                let cell = grid.nearest_cell(std::array::from_fn(|axis| centre[axis]));
                let has = |region: &Region| region.core.iter().any(|run| run.contains(&cell));
                regions.iter().position(has).unwrap_or(0)
            };
            let inlets = scene.inlets.iter().map(|inlet| inlet.patch.at);
            *of_source =
                inlets.chain(scene.emitters.iter().map(|emitter| emitter.ball().0)).map(at).collect();
            *of_outlet = scene.outlets.iter().map(|outlet| at(outlet.patch.at)).collect();
            regions
        })
    }

    /// Returns the cells near openings: all, or those of the regions of which this rank is a
    /// member.
    pub fn near(&self, all: bool) -> &[Range<usize>] {
        match &self.near {
            Some(near) if all || self.is_member.is_empty() => near,
            Some(_) => &self.near_held,
            None => &[],
        }
    }

    /// Returns true if the domains have changed since the members were found.
    pub fn are_outdated(&self, ranks: &Ranks) -> bool {
        self.changes != ranks.changes()
    }

    /// Finds the members for the present domains.
    pub fn follow(&mut self, ranks: &Ranks) {
        self.changes = ranks.changes();
        self.leaders = ranks.leaders();
        self.is_member = ranks.memberships();
        let regions = self.regions.iter().flatten().zip(&self.is_member);
        let held = regions.filter(|(_, is_member)| **is_member).flat_map(|(region, _)| &region.core);
        self.near_held = held.cloned().collect();
        self.near_held.sort_unstable_by_key(|run| run.start);
    }

    /// Returns true if this rank is a member of the region of an inlet or emitter.
    pub fn has_source(&self, source: usize) -> bool {
        self.is_member.is_empty() || self.is_member[self.of_source[source]]
    }

    /// Returns true if this rank is a member of the region of an outlet.
    pub fn has_outlet(&self, outlet: usize) -> bool {
        self.is_member.is_empty() || self.is_member[self.of_outlet[outlet]]
    }

    /// Returns true if this rank is a member of the region of the inlet, emitter or outlet of a
    /// zone.
    pub fn has(&self, zone: Zone, patch: u16) -> bool {
        match zone {
            Zone::Inflow => self.has_source(usize::from(patch)),
            _ => self.has_outlet(usize::from(patch)),
        }
    }

    /// Returns the rank that leads the region of the inlet, emitter or outlet of a zone.
    pub fn leader(&self, zone: Zone, patch: u16) -> usize {
        match zone {
            Zone::Inflow => self.leader_of_source(usize::from(patch)),
            _ => self.leader_of_outlet(usize::from(patch)),
        }
    }

    /// Returns the rank that leads the region of an inlet or emitter.
    pub fn leader_of_source(&self, source: usize) -> usize {
        if self.leaders.is_empty() { 0 } else { self.leaders[self.of_source[source]] }
    }

    /// Returns the rank that leads the region of an outlet.
    pub fn leader_of_outlet(&self, outlet: usize) -> usize {
        if self.leaders.is_empty() { 0 } else { self.leaders[self.of_outlet[outlet]] }
    }

    /// Returns the region of an inlet or emitter; None on one rank alone.
    pub fn of_source(&self, source: usize) -> Option<usize> {
        self.of_source.get(source).copied()
    }

    /// Returns the region of an outlet; None on one rank alone.
    pub fn of_outlet(&self, outlet: usize) -> Option<usize> {
        self.of_outlet.get(outlet).copied()
    }

    /// Returns true if no member was ever found: all ranks have the states of all openings.
    pub fn are_new(&self) -> bool {
        self.leaders.is_empty()
    }
}
