//! State of all particles between two steps as columns in the order of their numbers.
//!
//! It is copied from the sorted arrays, which takes less time than to update the components first
//! and to read them one by one.

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::transfer::rows_by_number;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;

/// Columns with one entry per particle, sorted by number; particles in the reservoir have none.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ParticleTable {
    /// Numbers.
    pub id: Vec<u32>,
    /// Zones.
    pub zone: Vec<Zone>,
    /// Indices of the inlet, outlet or wall part; 0 for fluid.
    pub patch: Vec<u16>,
    /// Positions, m.
    pub position: Vec<DVec3>,
    /// Velocities, m/s; of walls, those of their surface.
    pub velocity: Vec<DVec3>,
    /// Densities, kg/m³.
    pub density: Vec<f64>,
    /// Pressures, Pa.
    pub pressure: Vec<f64>,
}

impl ParticleTable {
    /// Copies the state of the arrays.
    pub(crate) fn of<R: PairReal<D>, const D: usize>(arrays: &ParticleArrays<R, D>) -> Self {
        let rows: Vec<u32> = rows_by_number(&arrays.id).into_iter().filter(|&row| row != u32::MAX).collect();
        let rows = || rows.par_iter().with_min_len(CHUNK).map(|&row| row as usize);
        let patch = |row: usize| if arrays.zone[row] == Zone::Fluid { 0 } else { arrays.patch[row] };
        Self {
            id: rows().map(|row| arrays.id[row]).collect(),
            zone: rows().map(|row| arrays.zone[row]).collect(),
            patch: rows().map(patch).collect(),
            position: rows().map(|row| arrays.position_of(row)).collect(),
            velocity: rows().map(|row| arrays.velocity_of(row)).collect(),
            density: rows().map(|row| arrays.density[row].to_f64()).collect(),
            pressure: rows().map(|row| arrays.pressure[row].to_f64()).collect(),
        }
    }
}

/// Particles per task of a thread.
const CHUNK: usize = 4096;
