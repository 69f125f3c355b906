//! Flow through the openings that follows from the velocities in the whole domain.
//!
//! ```text
//! Q_i = Σ_b V0 v_b·∇φ_i(x_b) + ⟨φ_i⟩ Q̃_in
//! ```
//!
//! The sum is over the fluid particles, V0 = m/ρ0, with the weights of
//! [`potential_flow`](sphecs_scene::potential_flow), in which sound does not count. Q̃_in is the slow
//! part of the prescribed inflow.

use rayon::iter::{IndexedParallelIterator, IntoParallelIterator, ParallelIterator};

use super::prescribed_inflow::PrescribedInflow;
use sphecs_core::boundary::outlet::method::Needs;
use sphecs_core::particles::arrays::ParticleArrays;
use sphecs_core::particles::zone::Zone;
use sphecs_core::pass::pair_real::PairReal;
use sphecs_scene::model::Scene;
use sphecs_scene::potential_flow::{PotentialFlow, potential_flows};

/// Rows per partial sum: constant, so that the sums are bitwise independent of the number of
/// threads.
const CHUNK: usize = 4096;

/// Flow through the openings whose condition uses it: a function of the present state, which a
/// checkpoint need not save.
#[derive(Debug, Default)]
pub struct ThroughFlow {
    weights: Vec<Option<PotentialFlow>>,
    /// Mean velocity through each section in the present step, m/s.
    velocities: Vec<Option<f64>>,
    sums: Vec<f64>,
}

impl ThroughFlow {
    /// Returns the flow of a scene whose outlets have these requirements.
    pub fn new(scene: &Scene, needs: &[Needs]) -> Self {
        let weights = potential_flows(scene, |outlet| needs[outlet].uses_through_flow);
        Self { weights, velocities: Vec::new(), sums: Vec::new() }
    }

    /// Finds the velocities of the present state.
    pub fn find<R: PairReal<D>, const D: usize>(
        &mut self,
        scene: &Scene,
        inflow: &PrescribedInflow,
        arrays: &ParticleArrays<R, D>,
    ) {
        let Self { weights, velocities, sums } = self;
        velocities.clear();
        let volume = scene.discretisation.cell_volume();
        for (index, (outlet, weights)) in scene.outlets.iter().zip(&*weights).enumerate() {
            velocities.push(weights.as_ref().map(|weights| {
                let of_chunk = |chunk: usize| {
                    let rows = chunk * CHUNK..arrays.len().min((chunk + 1) * CHUNK);
                    rows.filter(|&row| arrays.zone[row] == Zone::Fluid)
                        .map(|row| weight(weights, arrays, row))
                        .sum()
                };
                (0..arrays.len().div_ceil(CHUNK)).into_par_iter().map(of_chunk).collect_into_vec(sums);
                let prescribed = inflow.at_outlet(index).map_or(0.0, |inflow| inflow.rate);
                (volume * sums.iter().sum::<f64>() + weights.inlet_potential * prescribed) / outlet.patch.area
            }));
        }
    }

    /// Returns the mean velocity through the section of an outlet, m/s; None if its condition does
    /// not use it.
    pub fn velocity(&self, outlet: usize) -> Option<f64> {
        self.velocities.get(outlet).copied().flatten()
    }
}

/// Returns v·∇φ of a row, 1/s.
fn weight<R: PairReal<D>, const D: usize>(
    weights: &PotentialFlow,
    arrays: &ParticleArrays<R, D>,
    row: usize,
) -> f64 {
    let gradient = weights.gradient(arrays.position_of(row));
    let velocity = arrays.velocity_of(row);
    (0..D).map(|axis| velocity[axis] * f64::from(gradient[axis])).sum()
}
