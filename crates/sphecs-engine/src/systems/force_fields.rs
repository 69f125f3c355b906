//! Forces that a user adds for all fluid particles at once.
//!
//! A function of one particle costs a call for each of them. A function of columns is called once
//! in every stage, as suits programs that compute with whole arrays.

use std::ops::Range;

use glam::DVec3;
use rayon::iter::{IndexedParallelIterator, IntoParallelRefIterator, ParallelIterator};

use crate::arrays::Arrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::blocks::for_each_part;
use sphecs_core::pass::pair_real::PairReal;

/// State of all fluid particles, one entry of each column per particle, in no lasting order.
#[derive(Clone, Copy, Debug)]
#[non_exhaustive]
pub struct FluidState<'a> {
    /// Time, s.
    pub time: f64,
    /// Numbers of the particles.
    pub id: &'a [u32],
    /// Positions, m.
    pub position: &'a [DVec3],
    /// Velocities, m/s.
    pub velocity: &'a [DVec3],
    /// Densities, kg/m³.
    pub density: &'a [f64],
    /// Pressures, Pa.
    pub pressure: &'a [f64],
}

/// Adds forces per mass, m/s², to the entries of the particles.
pub(super) type ForceField = dyn Fn(&FluidState<'_>, &mut [DVec3]) + Send + Sync;

/// Columns of the fluid particles, kept from stage to stage as buffers.
#[derive(Debug, Default)]
pub(crate) struct FluidBuffers {
    rows: Vec<u32>,
    id: Vec<u32>,
    position: Vec<DVec3>,
    velocity: Vec<DVec3>,
    density: Vec<f64>,
    pressure: Vec<f64>,
    force: Vec<DVec3>,
}

impl FluidBuffers {
    /// Copies the state of the fluid particles and evaluates the fields.
    pub(super) fn evaluate<R: PairReal<D>, const D: usize>(
        &mut self,
        arrays: &Arrays<R, D>,
        time: f64,
        fields: &[Box<ForceField>],
    ) {
        self.rows.clear();
        self.rows.extend((0..arrays.len() as u32).filter(|&row| arrays.zone[row as usize] == Zone::Fluid));
        let rows = self.rows.par_iter().map(|&row| row as usize);
        rows.clone().map(|row| arrays.id[row]).collect_into_vec(&mut self.id);
        rows.clone().map(|row| arrays.position_of(row)).collect_into_vec(&mut self.position);
        rows.clone().map(|row| arrays.velocity_of(row)).collect_into_vec(&mut self.velocity);
        rows.clone().map(|row| arrays.density[row].to_f64()).collect_into_vec(&mut self.density);
        rows.map(|row| arrays.pressure[row].to_f64()).collect_into_vec(&mut self.pressure);
        self.force.clear();
        self.force.resize(self.rows.len(), DVec3::ZERO);
        let Self { rows: _, id, position, velocity, density, pressure, force } = self;
        let state = FluidState { time, id, position, velocity, density, pressure };
        for field in fields {
            field(&state, force);
        }
    }

    /// Adds the evaluated forces to the accelerations of all rows.
    pub(super) fn add_to<R: PairReal<D>, const D: usize>(&self, acceleration: &mut [Vec<R>; D]) {
        let count = acceleration[0].len();
        let work = |part: Range<usize>, acceleration: [&mut [R]; D]| {
            let first = self.rows.partition_point(|&row| (row as usize) < part.start);
            let own = self.rows[first..].iter().zip(&self.force[first..]);
            for (&row, force) in own.take_while(|&(&row, _)| (row as usize) < part.end) {
                for axis in 0..D {
                    acceleration[axis][row as usize - part.start] += R::from_f64(force[axis]);
                }
            }
        };
        for_each_part(0..count, acceleration.each_mut().map(Vec::as_mut_slice), &work);
    }
}
