//! Division of a flow among ranks before their first step.
//!
//! Rank 0 has all particles and gives each other rank those that it holds.

use std::sync::atomic::Ordering;

use super::Ranks;
use super::bisection::bisect;
use super::domains::set_of;
use super::regions::{Region, held};
use super::rows::cell_of;
use crate::math::column::{ColumnMismatch, Columns};
use crate::math::grid::CellGrid;
use crate::math::grid::cell_set::runs_of;
use crate::math::real::Real;
use crate::particles::arrays::ParticleArrays;
use crate::particles::zone::Zone;

/// Cells that each rank owns at first, and facts of the whole flow that a part may not show.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Division {
    /// Number of ranks.
    ranks: usize,
    /// Rank of each cell.
    owner: Vec<u16>,
    has_walls: bool,
    has_thin_walls: bool,
}

impl Division {
    /// Divides the cells so that all ranks own equally many particles.
    pub fn new<R: Real, const D: usize>(
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
        ranks: usize,
    ) -> Self {
        let mut counts = vec![0.0; grid.len()];
        for row in (0..arrays.len()).filter(|&row| arrays.zone[row] != Zone::Reservoir) {
            if let Some(cell) = cell_of(grid, arrays, row) {
                counts[cell] += 1.0;
            }
        }
        Self {
            ranks,
            owner: bisect(grid, &counts, ranks),
            has_walls: arrays.zone.contains(&Zone::Wall),
            has_thin_walls: !arrays.wall_thickness.is_empty(),
        }
    }

    /// Returns the rows that a rank holds.
    pub fn rows_of<R: Real, const D: usize>(
        &self,
        rank: usize,
        grid: &CellGrid<D>,
        arrays: &ParticleArrays<R, D>,
        regions: &[Region],
    ) -> Vec<u32> {
        let cells = grid.len();
        let own = runs_of(0..cells, |cell| usize::from(self.owner[cell]) == rank);
        let held = held(grid, &set_of(cells, &own), (rank, &self.owner, self.ranks), regions);
        // All ranks get a particle outside the grid, since it stops all of them.
        let is_held = |row: usize| cell_of(grid, arrays, row).is_none_or(|cell| held.contains(cell));
        let exists = |row: usize| arrays.zone[row] != Zone::Reservoir;
        (0..arrays.len()).filter(|&row| exists(row) && is_held(row)).map(|row| row as u32).collect()
    }

    /// Adds the division to the state with which another rank begins.
    pub fn save(&self, to: &mut Columns) {
        to.put("division.ranks", vec![self.ranks as u32]);
        to.put("division.owner", self.owner.clone());
        to.put("division.walls", vec![u8::from(self.has_walls), u8::from(self.has_thin_walls)]);
    }

    /// Takes the division from such a state.
    ///
    /// # Errors
    /// [`ColumnMismatch`] if it has none.
    pub fn restore(from: &mut Columns) -> Result<Self, ColumnMismatch> {
        let walls = from.take_exactly::<u8>("division.walls", 2)?;
        Ok(Self {
            ranks: from.take_exactly::<u32>("division.ranks", 1)?[0] as usize,
            owner: from.take("division.owner")?,
            has_walls: walls[0] != 0,
            has_thin_walls: walls[1] != 0,
        })
    }
}

impl Ranks {
    /// Takes the division with which all ranks begin, before their first step.
    pub fn divide(&self, division: Division) {
        let Some(group) = &self.group else { return };
        group.has_walls.store(division.has_walls, Ordering::Relaxed);
        group.has_thin_walls.store(division.has_thin_walls, Ordering::Relaxed);
        group.state().first_owners = division.owner;
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::regions::tests::region;
    use super::*;
    use crate::particles::rows::ParticleRow;

    #[test]
    fn ranks_begin_with_what_their_cells_reach() {
        let grid = CellGrid::<2>::new([0.0; 2], [12.0, 1.0], [false; 2], 1.0, 1.0);
        let mut particles = ParticleArrays::<f64, 2>::default();
        // One in each cell, one in the reservoir and one outside the grid.
        for id in 0..14 {
            let position = DVec3::new(f64::from(id) + 0.5, 0.5, 0.0);
            let zone = if id == 12 { Zone::Reservoir } else { Zone::Fluid };
            particles.push(&ParticleRow { id, zone, position, ..ParticleRow::default() });
        }
        let division = Division::new(&grid, &particles, 3);
        let rows = |rank: usize, regions: &[Region]| division.rows_of(rank, &grid, &particles, regions);
        assert_eq!(rows(0, &[]), [0, 1, 2, 3, 4, 13]);
        assert_eq!(rows(1, &[]), [3, 4, 5, 6, 7, 8, 13]);
        let regions = [region(7..8, 6..8)];
        assert_eq!(rows(2, &regions), [5, 6, 7, 8, 9, 10, 11, 13]);
        assert_eq!(rows(0, &regions), [0, 1, 2, 3, 4, 13]);
        let mut saved = Columns::default();
        division.save(&mut saved);
        assert_eq!(Division::restore(&mut saved).expect("a division"), division);
        assert!(Division::restore(&mut saved).is_err(), "it has been taken");
    }
}
