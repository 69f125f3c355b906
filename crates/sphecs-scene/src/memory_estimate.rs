//! Largest resident memory of a run with its output, estimated from its scene.
//!
//! ```text
//! M = M_program + n_probes M_probe + n_particles M_particle + n_nodes M_node
//! ```
//!
//! Measured on two threads with 400 to 1 400 000 particles in 2D and 3D
//! (`docs/notebook/2026-11-26-output.md`); `python/tests/test_memory.py` compares it with the peak
//! of every shipped scene.

use super::model::{Precision, Scene};
use super::scheme::Scheme;

/// Program, libraries and the buffers of two threads, B (docs/notebook/2026-11-29-ranks.md).
const PROGRAM: f64 = 44e6;

/// A probe: mostly its group in `probes.nc` while the run is packed, B.
const PROBE: f64 = 0.55e6;

/// Returns the memory of a particle, B: components, columns, cells, sums, and at the time of the
/// peak a checkpoint and two frames.
pub fn bytes_per_particle(scheme: &Scheme, precision: Precision) -> f64 {
    let (particle, stress) = match precision {
        Precision::F32 => (610.0, 160.0),
        Precision::F64 => (710.0, 290.0),
    };
    if scheme.has_stress() { particle + stress } else { particle }
}

/// Returns the memory of a run with a number of particles of all zones and of nodes of grids, B.
pub fn memory(scene: &Scene, particles: f64, nodes: f64) -> f64 {
    let probes = scene.output.probes.len() as f64;
    PROGRAM
        + probes * PROBE
        + particles * bytes_per_particle(&scene.scheme, scene.precision)
        + nodes * bytes_of_fields(scene)
}

/// Returns the number of values at a node of the gridded fields: velocity, pressure, density,
/// vorticity, fluid fraction and tag.
pub fn values_of_fields(scene: &Scene) -> f64 {
    let vorticity = if scene.dimensions == 2 { 1 } else { 3 };
    (scene.dimensions + vorticity + 3 + usize::from(scene.has_tags())) as f64
}

/// Returns the number of means at a node: velocity, pressure, vorticity, density, fluid fraction,
/// stresses, variance of the pressure and weight; of the passive scalar mean and variance.
pub fn means_of_fields(scene: &Scene) -> f64 {
    let of_tag = if scene.has_tags() { 2.0 } else { 0.0 };
    of_tag + if scene.dimensions == 2 { 11.0 } else { 17.0 }
}

/// Returns the memory of a node of the gridded fields, B: the values of a time being sampled and of
/// two being written; the means and a checkpoint of them; the mask.
pub fn bytes_of_fields(scene: &Scene) -> f64 {
    let has_means = scene.output.fields.as_ref().is_some_and(|fields| fields.mean.is_some());
    let means = if has_means { 2.0 * 8.0 * means_of_fields(scene) } else { 0.0 };
    3.0 * 4.0 * values_of_fields(scene) + means + 2.0
}

/// Returns the number of nodes of all grids of the gridded fields.
pub fn nodes_of_fields(scene: &Scene) -> f64 {
    scene.field_grids().iter().map(|grid| grid.len() as f64).sum()
}
